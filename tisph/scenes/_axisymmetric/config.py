"""Config of axisymmetric scenes."""

from collections.abc import Iterator

from tisph.config import schema
from tisph.config.base import Model, Problem
from tisph.scenes._cell.sections import incommensurate_periods


class Config(schema.Config):
    """A run of axisymmetric flow, periodic along the axis: x along it, y the distance from it.

    The spacing is the nearest to the one given of which the length is a whole number.
    """

    geometry: Model

    axisymmetric = True
    periodic = (True, False)

    @property
    def inner_radius(self) -> float:
        """Radius of the inner wall [length], 0 where the fluid reaches the axis."""
        raise NotImplementedError

    @property
    def outer_radius(self) -> float:
        """Radius of the outer wall [length]."""
        raise NotImplementedError

    @property
    def across(self) -> float:
        """Difference of the radii."""
        return self.outer_radius - self.inner_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Length, and difference of the radii."""
        return self.geometry.length, self.across

    @property
    def spacing(self) -> float:
        """Particle spacing [length], which divides the length."""
        return self.geometry.length / max(1, round(self.geometry.length / super().spacing))

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        if self.scheme.type == "wcsph":
            yield "scheme.type", "wcsph is planar; take auto or implicit"
        if self.discretisation.precision == "f32":
            yield "discretisation.precision", "must be f64 in axisymmetric flow"

    def incommensurate(self) -> Iterator[Problem]:
        """A length that is too short."""
        return incommensurate_periods(self)
