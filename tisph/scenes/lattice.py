"""Bodies in a doubly periodic cell: fluid flows through a lattice of them, or they move in it.

The cell is 0 <= x <= length, 0 <= y <= height; bodies may lie across its edges. The fluid is at rest at first, and
driven by an acceleration along x, by bodies that move, or both. An acceleration f is that of a pressure which falls by
density * f per length: at last the forces on the bodies add up to it times the mass of the fluid, and with the
pressure's own buoyancy, the same for the bodies' areas, to density * f * length * height.

No solution is known. What others have found for cylinders in slow flow: A. S. Sangani and A. Acrivos, Int. J.
Multiphase Flow 8 (1982) 193-206.
"""

from collections.abc import Iterator

from tisph.config import checks, schema
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
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.geometry.length, self.geometry.height

    @property
    def aspect(self) -> float:
        """Length over height."""
        return self.geometry.length / self.geometry.height

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        yield from cell_problems(self, bodies_of(self, {}), {})

    def incommensurate(self) -> Iterator[Problem]:
        """A length that the spacing does not divide, or periods that are too short."""
        yield from checks.incommensurate_columns(self) or incommensurate_periods(self)


class Scene:
    """Makes the scene."""

    @staticmethod
    def from_config(config):
        """The scene that a validated config describes."""
        return Cell.around(config, bodies_of(config, {}), {})
