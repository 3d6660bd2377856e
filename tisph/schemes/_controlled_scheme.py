"""The common part of both implicit schemes: steps of a ``StepControl``, and output at any time within a step."""

import math
from collections.abc import Sequence
from typing import Any

from tisph.errors import DivergedError
from tisph.runtime import view
from tisph.schemes._step_control import Kept, StepControl


class ControlledScheme(Kept):
    """Base of a scheme whose steps are dense; see ``_protocol.Scheme``.

    ``control``: the ``StepControl``; ``operators``: the least-squares operators of its points.
    """

    control: StepControl
    operators: Any
    points: Any
    kept: tuple[str, ...] = ("time", "steps", "shortest", "longest", "order_reduced", "singular")

    def reset_steps(self, time: float) -> None:
        """Go back to before the first step, at ``time``."""
        self.time, self.control.rejected = time, 0
        self.steps = self.order_reduced = self.singular = 0
        self.shortest, self.longest = math.inf, 0.0

    def end_step(self, dt: float, measured: float) -> None:
        """Count a step ``dt`` that was accepted; the limit of the next one depends on the ``measured`` flow."""
        self.time = self.control.end(self.time, dt)
        self.control.step_taken(self.time, measured)
        self.steps += 1
        self.shortest, self.longest = min(self.shortest, dt), max(self.longest, dt)
        self.order_reduced += int(view(self.operators.order_reduced))
        self.singular += int(view(self.operators.singular))

    @property
    def present_step(self) -> str:
        """The step that is being taken, and its time, as text."""
        return f"at step {self.steps + 1}, t = {self.time:.6g}"

    def diverged(self, text: str) -> DivergedError:
        """Return the DivergedError with a ``text`` and the present step."""
        return DivergedError(f"{text} {self.present_step}")

    def require_room(self, what: str, needed: int) -> None:
        """Raise DivergedError if ``needed``, the size that a field for ``what`` lacks, is not 0."""
        if needed:
            text = f"x, y: too many {what} ({needed}), {self.present_step}: the particles have clustered"
            raise DivergedError(text)

    @property
    def finished(self) -> bool:
        """Whether the last target is reached."""
        return self.control.finished

    def set_targets(self, targets: Sequence[float]) -> bool:
        """Go on to other targets; return whether a run that had them from the start would have the same steps."""
        return self.control.set_targets(targets, self.time)

    def output_times(self, due: Sequence[float]) -> Sequence[float]:
        """Return all times that are ``due``, since snapshots are interpolated within a step."""
        return due

    def numbers(self) -> dict[str, Any]:
        """Return the common numbers of both schemes for ``summary.json``."""
        return {
            "mach": 0.0,
            "sound_speed": None,
            "neighbours_mean": self.points.mean_length(),
            "steps_rejected": self.control.rejected,
            "order_reduced": self.order_reduced,
            "neighbourhoods_dropped": self.singular,
        }

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {**super().host_state(), **self.control.host_state()}

    def restore_host_state(self, state: Any) -> None:
        """Restore the numbers of ``host_state``."""
        super().restore_host_state(state)
        self.control.restore_host_state(state)
