"""Lid-driven cavity: fluid in a box whose top slides, from rest to the steady state.

Particles fill the box evenly, the first layer half a spacing from the walls. The lid starts at t = 0, with one speed
all along (``sharp``: it slides past the corners, where the flow is singular), or with 16 X^2 (1 - X)^2 of it, X =
x/width (``regular``). The fluid is a Newtonian one. References are those of the steady state: see
``tisph/exact/cavity.py``.
"""

from collections.abc import Iterator
from typing import Literal

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem, Signed
from tisph.config.checks import is_whole
from tisph.scenes._cavity import Cavity
from tisph.scenes._initial import RestInitial

__all__ = ["Cavity", "Config", "Scene"]

Scene = Cavity
"""The name under which a run asks a module of this folder for its scene."""


class Geometry(Model):
    """Sides of the box 0 <= x <= ``width``, 0 <= y <= ``height`` [length]."""

    width: Positive
    height: Positive


class Lid(Model):
    """Velocity along x of the lid y = height [length/time]: of all of it (sharp), or of its middle (regular)."""

    velocity: Signed
    profile: Literal["sharp", "regular"] = "sharp"


class Walls(Model):
    """The lid; the other three walls are at rest."""

    lid: Lid


class Config(schema.Config):
    """A whole run of a lid-driven cavity."""

    geometry: Geometry
    walls: Walls
    initial: RestInitial = RestInitial()

    periodic = (False, False)
    across_name = "the width"

    @property
    def across(self) -> float:
        """The width."""
        return self.geometry.width

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.geometry.width, self.geometry.height

    @property
    def singular(self) -> bool:
        """Whether the lid slides past corners."""
        return self.walls.lid.profile == "sharp"

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        yield from _rheology(self)
        if self.walls.lid.velocity == 0:
            yield "walls.lid.velocity", "must not be 0: nothing else drives the flow"

    def incommensurate(self) -> Iterator[Problem]:
        """A height that is no whole number of spacings."""
        if not is_whole(self.geometry.height / self.spacing):
            rows = max(1, round(self.geometry.height / self.spacing))
            nearest = f"{rows * self.spacing:.6g}"
            yield "geometry.height", f"must be a whole number of spacings of {self.spacing:.6g}; nearest: {nearest}"


def _rheology(config: Config) -> Iterator[Problem]:
    """Fluids that cannot be served under a sharp lid."""
    rheology = config.fluid.rheology
    if rheology.type != "newtonian" and config.singular:
        text = f"must be regular with {rheology.type}: the flow in the corners of a sharp lid is that of newtonian ones"
        yield "walls.lid.profile", text
