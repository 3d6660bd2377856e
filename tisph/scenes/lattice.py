"""Lattice of bodies: in a doubly periodic cell, fluid flows through a lattice of them, or they move in it.

The cell is 0 <= x <= length, 0 <= y <= height; bodies may lie across its edges. The fluid is at rest at first, and
driven by an acceleration along x, by bodies that move, or both. An acceleration f represents a pressure that falls by
density * f per length. In the steady state the forces on the bodies add up to f times the mass of the fluid; with the
buoyancy by that pressure, density * f per area of the bodies, to density * f * length * height.

There is no exact solution. Numerical results for cylinders in slow flow: A. S. Sangani and A. Acrivos, Int. J.
Multiphase Flow 8 (1982) 193-206.
"""

from collections.abc import Iterator

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem
from tisph.config.fields import bodies
from tisph.scenes._cell import Cell, bodies_of, cell_problems
from tisph.scenes._initial import Contact, Drive, RestInitial, incommensurate_periods


class Geometry(Model):
    """Periods along x and y [length]."""

    length: Positive
    height: Positive


class Config(schema.Config):
    """A whole run in the cell."""

    geometry: Geometry
    bodies: bodies(required=True)
    drive: Drive = Drive()
    contact: Contact | None = None
    initial: RestInitial = RestInitial()

    unset_keys = (*schema.Config.unset_keys, "contact")
    periodic = (True, True)
    across_name = "the height"

    @property
    def flow(self) -> str:
        """See ``schema.Config.flow``."""
        return f"{self.named_bodies} in a periodic cell"

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.geometry.length, self.geometry.height

    @property
    def aspect(self) -> float:
        """Length over height."""
        return self.geometry.length / self.geometry.height

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        yield from cell_problems(self, bodies_of(self, {}), {})

    def incommensurate(self) -> Iterator[Problem]:
        """Yield an error for a length that the spacing does not divide, or for each period that is too short."""
        yield from schema.incommensurate_columns(self) or incommensurate_periods(self)


class Scene:
    """Maker of the scene."""

    @staticmethod
    def from_config(config: "Config") -> Cell:
        """Return the scene that a validated config describes."""
        return Cell.around(config, bodies_of(config, {}), {})
