"""Keys of open ends: an inlet with a velocity and a profile, and an outlet, or two ends with given pressures."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from tisph.config.base import Model, NonNegative, Positive, Signed, findings, refusals, refuse
from tisph.config.fields import either
from tisph.config.motion import Times, Values, check_as_many

Points = Annotated[tuple[NonNegative, ...], Field(strict=False, max_length=1000)]


class Table(Model):
    """Velocities through an inlet at ``heights`` above its lower end [length], from 0 to its width.

    A cubic spline through them is scaled to the mean velocity of the inlet.
    """

    heights: Points
    velocities: Points

    @model_validator(mode="after")
    def _check_table(self) -> "Table":
        if len(self.heights) != len(self.velocities):
            text = f"must be as many as there are heights, {len(self.heights)}"
            raise refusals([(("velocities",), text, self.velocities)])
        if len(self.heights) < 2 or list(self.heights) != sorted({0.0, *self.heights}):
            raise refusals([(("heights",), "must be two or more, ascending from 0", self.heights)])
        if not any(self.velocities):
            raise refusals([(("velocities",), "must not all be 0", self.velocities)])
        return self


Named = Literal["developed", "parabolic", "uniform"]
Profile = either(Named, Table, lambda value: isinstance(value, dict | Table), "a map of heights and velocities")

Kind = Literal["inlet", "outlet"]
MOTION_KEYS = ("velocity", "amplitude", "angular_frequency", "phase", "times", "velocities")


class End(Model):
    """An inlet, whose velocity is given, or an outlet, whose ``pressure`` is, 0 unless given: nu du/dn = p n.

    A developed flow leaves an outlet unchanged, and enters one if its pressure is the higher one of two.

    Fluid enters an inlet with the mean ``velocity`` + ``amplitude`` * cos or sin (``phase``) of w t [length/time], or
    with the mean ``velocities`` at ``times``, linear in between and constant before and after. Its ``profile`` is the
    profile of the fluid's own developed flow, a parabola, uniform, or a table. Where the mean changes in time, the
    profile is scaled by it; developed flow of a Newtonian or Oldroyd-B fluid has the exact profile at each time.
    """

    unset_keys = (*MOTION_KEYS, "profile", "pressure")

    type: Kind
    velocity: NonNegative | None = None
    amplitude: Signed | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None
    times: Times | None = None
    velocities: Values | None = None
    profile: Profile | None = None
    pressure: Signed | None = None

    @model_validator(mode="before")
    @classmethod
    def _fill_in(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        usual = {"phase": "cos"} if data.get("amplitude") is not None else {}
        usual |= {"profile": "developed"} if data.get("type") == "inlet" else {}
        usual |= {"type": "outlet"} if data.get("pressure") is not None else {}
        return {**data, **{key: value for key, value in usual.items() if data.get(key) is None}}

    @model_validator(mode="after")
    def _check_motion(self) -> "End":
        if self.type == "outlet":
            refuse(findings(self, self.unset_keys[:-1], "is only for an inlet"))
            return self
        refuse(findings(self, ("pressure",), "is only for an outlet: the flow decides the pressure of an inlet"))
        if self.velocities is not None:
            refuse(findings(self, MOTION_KEYS[:4], "is not for an inlet with velocities at times"))
            check_as_many(self, "velocities")
            if list(self.times or ()) != sorted(set(self.times or ())):
                text = "must ascend: an inflow that jumps needs an infinite pressure; give a short ramp"
                raise refusals([(("times",), text, self.times)])
            if not any(self.velocities):
                raise refusals([(("velocities",), "must not all be 0", self.velocities)])
        else:
            refuse(findings(self, ("times",), "is only for an inlet with velocities at times"))
            if self.amplitude is None:
                refuse(findings(self, ("angular_frequency", "phase"), "is only for an inlet with an amplitude"))
            elif self.angular_frequency is None:
                raise refusals([(("angular_frequency",), "is missing: an inlet with an amplitude oscillates", {})])
            if not (self.velocity or self.amplitude):
                text = "must be greater than 0, unless there is an amplitude, or velocities at times"
                raise refusals([(("velocity",), text, {} if self.velocity is None else self.velocity)])
        return self

    def jumps_at_walls(self, on_axis: bool = False) -> bool:
        """Return whether the velocity of the fluid at a wall is not 0; ``on_axis``: the lower end is no wall."""
        ends = self.profile.velocities[:: len(self.profile.velocities) - 1] if isinstance(self.profile, Table) else ()
        return self.profile == "uniform" or any(ends[1:] if on_axis else ends)


class Ends(Model):
    """Ends of a channel at x = 0 (``left``) and x = length (``right``): an inlet and an outlet, or two outlets.

    The pressures of two outlets drive the flow.
    """

    left: End
    right: End

    @model_validator(mode="after")
    def _check_one_of_each(self) -> "Ends":
        if self.left.type == self.right.type == "inlet":
            raise refusals([(("right", "type"), "must be outlet, with an inlet on the left", self.right.type)])
        if self.inlet is None and not self.pressure_drop:
            text = "must be another one than on the left, or the other end an inlet: nothing drives the flow"
            raise refusals([(("right", "pressure"), text, self.right.pressure or 0.0)])
        if self.inlet and (self.left.pressure or self.right.pressure):
            side = "left" if self.left.pressure else "right"
            text = "must be 0 with an inlet, whose pressure is relative to it: leave it out"
            raise refusals([((side, "pressure"), text, self.left.pressure or self.right.pressure)])
        return self

    @property
    def pressure_drop(self) -> float:
        """Pressure of the left end minus that of the right one."""
        return (self.left.pressure or 0.0) - (self.right.pressure or 0.0)

    @property
    def inlet(self) -> Any:
        """The end that is the inlet, None between two outlets."""
        return next((end for end in (self.left, self.right) if end.type == "inlet"), None)

    @property
    def inlet_side(self) -> str:
        """Side of the inlet, left or right."""
        return "left" if self.inlet is self.left else "right"
