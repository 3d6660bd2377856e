"""Circles at random places, of one radius or several, with a given area fraction.

Their places follow from the seed (``geometry/packing.py``). All circles share the other keys of a circle, such as its
motion.
"""

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, create_model, model_validator

from tisph.bodies import circle
from tisph.config.base import Model, Positive, Whole, refusals
from tisph.config.fields import MOST_BODIES, either
from tisph.geometry.packing import random_centres
from tisph.geometry.region import Region

USUAL_GAP = 2.5
"""Default of ``least_gap`` in particle spacings, somewhat above the required gap."""

HALVINGS = 6
"""Number of halvings in the search for the largest possible fraction."""

PLACE = ("type", "centre", "angle", "radius")

_Several = Annotated[tuple[Positive, ...], Field(strict=False, min_length=1, max_length=MOST_BODIES)]
if TYPE_CHECKING:
    Radii = float | tuple[float, ...]
else:
    Radii = either(Positive, _Several, lambda value: isinstance(value, list | tuple), "a list of radii")
_of_each: Any = {name: (field.annotation, field) for name, field in circle.Parameters.model_fields.items()}
Shared: Any = create_model("Shared", __base__=Model, **{name: _of_each[name] for name in _of_each if name not in PLACE})


class Parameters(Shared):
    """Radius [length], or radii of a mixture with their ``shares`` of the circles' area, equal by default.

    ``fraction`` of the cell's area that the circles fill, as nearly as whole circles can. ``least_gap`` [length]
    between circles, their periodic copies and walls: 2.5 particle spacings by default.
    """

    unset_keys = ("shares", "least_gap", *circle.Parameters.unset_keys)
    shaped_by: ClassVar[str] = circle.Parameters.shaped_by

    type: Literal["random_circles"] = "random_circles"
    radius: Radii
    shares: _Several | None = None
    fraction: Annotated[float, Field(gt=0, lt=1)]
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0
    least_gap: Positive | None = None

    @model_validator(mode="after")
    def _check_radii(self) -> "Parameters":
        shares = self.shares
        if shares is not None and len(shares) != len(self.radii):
            raise refusals([(("shares",), f"must be as many as the radii, {len(self.radii)}", shares)])
        if shares is not None and abs(math.fsum(shares) - 1) > 1e-9:  # typed in by hand, as 1/3 may be
            raise refusals([(("shares",), f"must add up to 1, but make {math.fsum(shares):.10g}", shares)])
        self._circle(self.radii[0], (0.0, 0.0))  # ValidationError where a shared key is impossible
        return self

    @property
    def radii(self) -> tuple[float, ...]:
        """All radii [length]."""
        return self.radius if isinstance(self.radius, tuple) else (self.radius,)

    def for_spacing(self, spacing: float) -> "Parameters":
        """Return the parameters with every default that depends on the particle spacing [length]."""
        at_circles = self.spacing or spacing
        return self if self.least_gap is not None else self.model_copy(update={"least_gap": USUAL_GAP * at_circles})

    def bodies(self, region: Region) -> tuple[circle.Parameters, ...]:
        """Return the circles in ``region``, in the order of the radii.

        ``least_gap`` must have a value. ValidationError for a ``fraction`` that is impossible, with the key ``bodies``.
        """
        counts = self._counts(self.fraction, region)
        text = self._miscounted(counts, region)
        centres = None if text else self._centres(counts, region)
        if centres is None:
            raise refusals([(("bodies", "fraction"), text or self._too_crowded(sum(counts), region), self.fraction)])
        circles = zip(self._repeated(counts), centres.tolist(), strict=True)
        return tuple(self._circle(radius, tuple(centre)) for radius, centre in circles)

    def _circle(self, radius: float, centre: tuple[float, float]) -> circle.Parameters:
        shared = {key: getattr(self, key) for key in Shared.model_fields if key in self.model_fields_set}
        return circle.Parameters(centre=centre, radius=radius, **shared)

    def _counts(self, fraction: float, region: Region) -> list[int]:
        """Return the number of circles of each radius at an area ``fraction``, rounded."""
        shares = self.shares or [1 / len(self.radii)] * len(self.radii)
        area = fraction * region.area
        return [round(share * area / (math.pi * radius**2)) for share, radius in zip(shares, self.radii, strict=True)]

    def _repeated(self, counts: list[int]) -> list[float]:
        """Return the radii of all circles."""
        return [radius for radius, count in zip(self.radii, counts, strict=True) for _ in range(count)]

    def _centres(self, counts: list[int], region: Region) -> np.ndarray | None:
        return random_centres(self._repeated(counts), region, self.least_gap or 0.0, self.seed)

    def _miscounted(self, counts: list[int], region: Region) -> str:
        """Return the error in the numbers of circles, empty where there is none."""
        if 0 in counts:
            radius = self.radii[counts.index(0)]
            alone = math.pi * radius**2 / region.area
            return f"must be at least {alone:.4g}, the fraction of one circle of radius {radius:g}"
        many = sum(counts)
        return f"makes {many} circles; at most {MOST_BODIES} bodies are allowed" if many > MOST_BODIES else ""

    def _too_crowded(self, count: int, region: Region) -> str:
        """Return a message that ``count`` circles do not fit, with the largest possible fraction, by bisection."""
        low, high = 0.0, self.fraction
        for _ in range(HALVINGS):
            middle = round(0.5 * (low + high), 4)
            fits = self._centres(self._counts(middle, region), region) is not None
            low, high = (middle, high) if fits else (low, middle)
        all_there = 0 not in self._counts(low, region)
        fewer = (
            f"the largest fraction for which they were is {low:g}" if all_there else "nor for fewer: take smaller ones"
        )
        return f"no places with gaps of {self.least_gap:.4g} were found for so many circles, {count}; {fewer}"
