"""Double shear layer in a doubly periodic square: two opposite streams that roll up into vortices, at any time.

With the period L, the thickness d of the layers and the perturbation e, the run starts with

    u = U tanh((y - L/4)/d) below y = L/2, U tanh((3L/4 - y)/d) above it,    v = e U sin(2 pi x/L).

Each layer rolls up into a vortex, and the fluid between the vortices is strained. There is no exact solution. A fluid
with polymer starts without stress.

Source: J. B. Bell, P. Colella and H. M. Glaz, J. Comput. Phys. 85 (1989) 257-283, section 5; D. L. Brown and M. L.
Minion, J. Comput. Phys. 122 (1995) 165-183 (thick layers: L/30 at a Reynolds number of 1e4; thin ones: L/100).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem, Whole
from tisph.measures.fits import velocity_gradients
from tisph.scenes._scene import Scene as AnyScene
from tisph.scenes._views import Profile, TimeSeries, energy_series, kinetic_energy, planar_diagnostics, velocity_profile
from tisph.snapshot import STRESSES, Snapshot

ROLLING_UP = 1.25
"""Largest speed in the flow over the speed of the streams."""

THICKEST = 1 / 24
"""Thickness of a layer over the period above which the streams have a kink: between them tanh' is 1e-5 of its peak."""


class Geometry(Model):
    """Side of the square [length]."""

    length: Positive


class Initial(Model):
    """Speed of the streams [length/time], ``thickness`` of the layers [length], ``perturbation`` over the speed.

    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y; the same ``seed`` gives
    the same displacements.
    """

    velocity: Positive
    thickness: Positive
    perturbation: Annotated[float, Field(gt=0, lt=1)] = 0.05
    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0


class Config(schema.Config):
    """A whole run of shear layers."""

    geometry: Geometry
    initial: Initial

    periodic = (True, True)
    across_name = "the side"

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.geometry.length, self.geometry.length

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        largest = THICKEST * self.geometry.length
        if self.initial.thickness > largest:
            text = f"must be at most {largest:.6g}, 1/24 of the side"
            yield "initial.thickness", f"{text}: streams must be even between the layers"


@dataclass(frozen=True, kw_only=True)
class Scene(AnyScene):
    """The layers; all quantities in the config's units. ``speed``: speed of the streams."""

    length: float
    speed: float
    thickness: float
    perturbation: float

    flow_quantities = ("kinetic_energy", "dissipation")

    @classmethod
    def from_config(cls, config: "Config") -> "Scene":
        """Return the scene that a validated config describes."""
        return cls(
            **cls.fluid_of(config),
            length=config.geometry.length,
            speed=config.initial.velocity,
            thickness=config.initial.thickness,
            perturbation=config.initial.perturbation,
            columns=config.columns,
            rows=config.rows,
        )

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.length, self.length

    @property
    def reference_length(self) -> float:
        """The side."""
        return self.length

    @property
    def velocity_scale(self) -> float:
        """The speed of the streams."""
        return self.speed

    @property
    def peak_velocity(self) -> float:
        """Rough bound of the speed in the vortices."""
        return ROLLING_UP * super().peak_velocity

    def thinnest_layer(self, t: float) -> tuple[float, str]:
        """See ``Scene.thinnest_layer``: the layers at the start, which are not resolved later if not then."""
        return self.thickness, "the shear layer of the start"

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return velocities, and stresses of a polymer, when the run starts."""
        from_layer = np.where(y <= 0.5 * self.length, y - 0.25 * self.length, 0.75 * self.length - y)
        u = self.speed * np.tanh(from_layer / self.thickness)
        stress = dict.fromkeys(STRESSES, np.zeros(np.shape(x))) if self.polymer else {}
        return {"u": u, "v": self.perturbation * self.speed * np.sin(2 * np.pi * x / self.length), **stress}

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return means over the particles, and ``planar_diagnostics``.

        ``kinetic_energy`` per mass; ``dissipation`` per mass, without the dissipation of a polymer; ``mean_u``,
        ``mean_v``: mean velocity of the fluid, 0 at first.
        """
        square, others = planar_diagnostics(self, snapshot)
        dissipation = self.solvent_viscosity * square
        if self.rheology and not self.polymer:
            slopes = velocity_gradients(self, snapshot)
            squared = (slopes[0] - slopes[3]) ** 2 + (slopes[1] + slopes[2]) ** 2
            law = self.rheology.law(self.kinematic_viscosity, self.density)
            dissipation = np.mean(snapshot.weight * law.viscosity(squared) * squared)
        return {
            "kinetic_energy": kinetic_energy(self, snapshot),
            "dissipation": dissipation,
            "mean_u": np.mean(snapshot.weight * snapshot.u),
            "mean_v": np.mean(snapshot.weight * snapshot.v),
            **others,
        }

    def description(self) -> dict[str, Any]:
        """Return side and thickness of the layers."""
        return {"length": self.length, "thickness": self.thickness}

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        length, time = self.units.length, self.units.time
        elastic = [("Weissenberg number", f"{self.weissenberg:.4g}  (relaxation time * U / L)")] if self.polymer else []
        spacings = f"{self.thickness / self.spacing:.3g} spacings"
        return [
            ("Reynolds number", f"{self.reynolds:.6g}  (U L / nu)"),
            (self.velocity_name("speed U of the streams"), f"{self.reference_velocity:.6g} {length}/{time}"),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("side L", f"{self.length:.6g} {length}"),
            ("thickness of a layer", f"{self.thickness:.6g} {length}, {spacings}"),
            *elastic,
        ]

    def profiles(self) -> list[Profile]:
        """Return the velocities along the centre lines."""
        return [velocity_profile(self, "u", "y"), velocity_profile(self, "v", "x")]

    def time_series(self) -> TimeSeries:
        """Return the kinetic energy."""
        return energy_series(self)
