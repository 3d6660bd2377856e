"""Keys of open ends: an inlet with a velocity and a profile, and an outlet."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from tisph.config.base import Model, NonNegative, Positive, Signed, findings, refusals, refuse
from tisph.config.fields import either
from tisph.config.motion import Amplitude, Times, Values, check_as_many, check_schedule

Heights = Annotated[tuple[NonNegative, ...], Field(strict=False, min_length=2, max_length=1000)]


class Table(Model):
    """Velocities through an inlet at ``heights`` above its lower end [length], from 0 to its width.

    A cubic spline goes through them. It is scaled: the inlet has the mean velocity that it says.
    """

    heights: Heights
    velocities: Annotated[tuple[Signed, ...], Field(strict=False, min_length=2, max_length=1000)]

    @model_validator(mode="after")
    def _check_table(self) -> "Table":
        if len(self.heights) != len(self.velocities):
            text = f"must be as many as there are heights, {len(self.heights)}"
            raise refusals([(("velocities",), text, self.velocities)])
        if self.heights[0] != 0.0 or list(self.heights) != sorted(set(self.heights)):
            raise refusals([(("heights",), "must ascend from 0", self.heights)])
        return self


Named = Literal["developed", "parabolic", "uniform"]


class Inlet(Model):
    """Fluid enters with the mean velocity ``velocity`` + ``amplitude`` * cos or sin (``phase``) of w t [length/time].

    Or with the mean ``velocities`` at ``times``, linear in between and constant before and after. ``profile``: of the
    fluid's own developed flow, a parabola, uniform, or a table.
    """

    unset_keys = ("velocity", "amplitude", "angular_frequency", "phase", "times", "velocities")

    type: Literal["inlet"]
    velocity: Signed | None = None
    amplitude: Amplitude | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None
    times: Times | None = None
    velocities: Values | None = None
    profile: either(Named, Table, lambda value: isinstance(value, dict | Table), "heights and velocities") = "developed"

    @model_validator(mode="before")
    @classmethod
    def _fill_in_phase(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("amplitude") is not None and data.get("phase") is None:
            return {**data, "phase": "cos"}
        return data

    @model_validator(mode="after")
    def _check_motion(self) -> "Inlet":
        if self.velocities is not None:
            refuse(findings(self, ("velocity", "amplitude", "angular_frequency", "phase"), "is not for velocities at times"))
            check_as_many(self, "velocities")
            check_schedule(self, "velocities")
            if len(set(self.times or ())) < len(self.times or ()):
                text = "must ascend: an inflow that jumps needs an infinite pressure; give a short ramp"
                raise refusals([(("times",), text, self.times)])
            return self
        refuse(findings(self, ("times",), "is only for velocities at times"))
        if self.amplitude is None:
            refuse(findings(self, ("angular_frequency", "phase"), "is only for an inlet with an amplitude"))
            if not self.velocity:
                raise refusals([(("velocity",), "must be given, and not 0, or an amplitude, or velocities at times", {})])
        elif self.angular_frequency is None:
            raise refusals([(("angular_frequency",), "is missing: an inlet with an amplitude oscillates", {})])
        return self


class Outlet(Model):
    """Fluid leaves freely: nu du/dn = p n, so that a developed flow leaves as it came."""

    type: Literal["outlet"]


End = Annotated[Inlet | Outlet, Field(discriminator="type")]


class Ends(Model):
    """Ends of a channel at x = 0 (``left``) and x = length (``right``): one inlet and one outlet."""

    left: End
    right: End

    @model_validator(mode="after")
    def _check_one_of_each(self) -> "Ends":
        if self.left.type == self.right.type:
            other = "outlet" if self.left.type == "inlet" else "inlet"
            raise refusals([(("right", "type"), f"must be {other}, with an {self.left.type} on the left", self.right.type)])
        return self

    @property
    def inlet(self) -> Inlet:
        """The end that is the inlet."""
        return self.left if isinstance(self.left, Inlet) else self.right  # type: ignore[return-value]
