"""What a config says of a wall's motion: a constant velocity of some kind, or one that oscillates."""

from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Field, model_validator

from tisph.config.base import Model, NonNegative, Signed, findings, refusal, refusals, refuse


def _not_zero(value: float) -> float:
    if value == 0:
        raise refusal("must not be 0: for a wall at rest give velocity: 0, or angular_velocity: 0")
    return value


Amplitude = Annotated[Signed, AfterValidator(_not_zero)]
"""The type of an amplitude."""


MOST_TIMES = 1000
Times = Annotated[tuple[NonNegative, ...], Field(strict=False, min_length=1, max_length=MOST_TIMES)]
Values = Annotated[tuple[Signed, ...], Field(strict=False, min_length=1, max_length=MOST_TIMES)]
"""The type of what a wall is given at each of the times."""


class WallMotion(Model):
    """Base of models with the keys ``speed_key``, the same ``_before``, amplitude, angular_frequency and phase.

    Constant from t = 0 on, with another value before it or not; or amplitude * cos or sin (``phase``) of
    ``angular_frequency`` [1/time] * t. Without any of them the wall is at rest.
    """

    speed_key: ClassVar[str]
    other_keys: ClassVar[tuple[str, ...]] = ()
    """Keys of what else may move a wall; with one of them a model checks its form itself."""

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
        """The constant velocity, of whatever kind; None of a wall that oscillates."""
        return getattr(self, self.speed_key)

    @property
    def speed_before(self) -> float | None:
        """What it was before t = 0, if that was something else."""
        return getattr(self, f"{self.speed_key}_before")


def check_as_many(wall: WallMotion, key: str) -> None:
    """Raise ValidationError where ``times`` are not as many as the values that the ``wall`` has under a ``key``."""
    values = getattr(wall, key)
    if values is not None and len(wall.times or ()) != len(values):
        text = f"must be as many times, ascending from 0 on, as there are {key}, {len(values)}"
        raise refusals([(("times",), text, wall.times)])


def check_schedule(wall: WallMotion, key: str) -> None:
    """Raise ValidationError where the velocities under a ``key`` at their times say nothing, or two things."""
    times, velocities = wall.times, getattr(wall, key)
    counts = [times.count(time) for time in times]
    if list(times) != sorted(times) or counts[0] > 1 or max(counts) > 2:
        text = "must ascend from 0 on; two equal ones, where the velocity jumps, come after the first"
        raise refusals([(("times",), text, times)])
    if not any(velocities):
        raise refusals([((key,), f"must not all be 0: for a wall at rest give {wall.speed_key}: 0", velocities)])
