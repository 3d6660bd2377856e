"""Keys of a wall's motion, a velocity or angular velocity that is constant, oscillates, or is given at times; slip."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import AfterValidator, Field, model_validator

from tisph.config.base import Model, NonNegative, Positive, Signed, findings, refusal, refusals, refuse
from tisph.config.fields import number_or


def _not_zero(value: float) -> float:
    if value == 0:
        raise refusal("must not be 0: for a wall at rest give velocity: 0, or angular_velocity: 0")
    return value


SlipLength = number_or(Positive, "infinite")
"""The fluid at a wall is faster than the wall by this [length] times shear stress over viscosity; infinite: no stress.

As on a flat free surface, or a plane of symmetry.
"""


Spacing = Positive | None
"""Particle spacing at a wall [length], at most that of the flow; away from the wall it grows to it. None: the same."""


def slip_length_of(wall: Any) -> float:
    """Return the slip length [length] of a ``wall`` or body of a config: 0 without slip, infinite without friction."""
    given = wall.slip_length if wall is not None else None
    return math.inf if given == "infinite" else given or 0.0


def frictionless_findings(wall: Any, keys: Sequence[str]) -> list[tuple[Any, ...]]:
    """Return errors for ``refuse``: motions along itself, by these ``keys``, of a ``wall`` that has no friction."""
    if wall.slip_length != "infinite":
        return []
    text = "does nothing to a fluid that slips without friction (slip_length: infinite): leave it out"
    return findings(wall, [key for key in keys if getattr(wall, key)], text)


Amplitude = Annotated[Signed, AfterValidator(_not_zero)]

MOST_TIMES = 1000
Times = Annotated[tuple[NonNegative, ...], Field(strict=False, min_length=1, max_length=MOST_TIMES)]
Values = Annotated[tuple[Signed, ...], Field(strict=False, min_length=1, max_length=MOST_TIMES)]
"""Values of a wall, one for each of its times."""


class WallMotion(Model):
    """Base of models with the keys ``speed_key``, ``speed_key`` + _before, amplitude, angular_frequency and phase.

    The velocity is constant from t = 0 on, and may have another value before; or it is amplitude * cos or sin
    (``phase``) of ``angular_frequency`` [1/time] * t. Without any of the keys the wall is at rest.
    """

    speed_key: ClassVar[str]
    other_keys: ClassVar[tuple[str, ...]] = ()
    """Further keys that define a motion; with one of them a model checks its form itself."""

    if TYPE_CHECKING:  # subclasses define these keys
        amplitude: float | None
        angular_frequency: float | None

    @model_validator(mode="before")
    @classmethod
    def _fill_in_speed_or_phase(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        if all(
            data.get(key) is None for key in (cls.speed_key, "amplitude", "angular_frequency", "phase", *cls.other_keys)
        ):
            return {**data, cls.speed_key: 0.0}
        if data.get("amplitude") is not None and data.get("phase") is None:
            return {**data, "phase": "cos"}
        return data

    @model_validator(mode="after")
    def _check_forms(self) -> "WallMotion":
        if any(getattr(self, key) is not None for key in self.other_keys):
            return self
        oscillates = self.amplitude is not None
        alien = (f"{self.speed_key}_before",) if oscillates else ("angular_frequency", "phase")
        constant = self.speed_key.replace("_", " ")
        form = (
            f"of constant {constant}; this one oscillates" if oscillates else "that oscillates, which has an amplitude"
        )
        found = findings(self, alien, f"is only for a wall {form}")
        if oscillates and self.angular_frequency is None:
            found.append((("angular_frequency",), "is missing: a wall with an amplitude oscillates", {}))
        refuse(found)
        return self

    @property
    def speed(self) -> float | None:
        """The constant velocity or angular velocity; None of a wall that oscillates."""
        return getattr(self, self.speed_key)

    @property
    def speed_before(self) -> float | None:
        """The value of ``speed`` before t = 0; None where it was the same."""
        return getattr(self, f"{self.speed_key}_before")


def check_as_many(wall: Any, key: str) -> None:
    """Raise ValidationError where a ``wall`` has not as many ``times`` as values under a ``key``."""
    values = getattr(wall, key)
    if values is not None and len(wall.times or ()) != len(values):
        text = f"must be as many times, ascending from 0 on, as there are {key}, {len(values)}"
        raise refusals([(("times",), text, wall.times)])


def check_schedule(wall: Any, key: str) -> None:
    """Raise ValidationError where the ``times`` of a ``wall`` do not ascend, or all velocities under ``key`` are 0."""
    times, velocities = wall.times, getattr(wall, key)
    counts = [times.count(time) for time in times]
    if list(times) != sorted(times) or counts[0] > 1 or max(counts) > 2:
        text = "must ascend from 0 on; two equal ones, where the velocity jumps, come after the first"
        raise refusals([(("times",), text, times)])
    if not any(velocities):
        raise refusals([((key,), f"must not all be 0: for a wall at rest give {wall.speed_key}: 0", velocities)])
