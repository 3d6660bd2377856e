"""The error of a snapshot against the exact solution, in the words of the pictures."""

from collections.abc import Callable

import numpy as np

from tisph.report.labels import scientific
from tisph.snapshot import Snapshot
from tisph.verification.metrics import relative_error, rms_error

_TIMES, _HEIGHTS = 40, 51
_SMALL = 0.01  # of the largest speed: a flow slower than that counts as none


def velocity_error_label(channel) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> error of the velocity in words, for example ``L2 error 1.5×10⁻³``.

    Where u crosses zero or dies away (``loses_its_scale``), a relative error would be large for no fault of the
    particles: it is then the rms error as a multiple of the reference velocity U, ``rms error 1.5×10⁻³ U``.
    """
    if loses_its_scale(channel):
        return lambda snapshot: f"rms error {scientific(rms_error(channel, snapshot))} U"
    return lambda snapshot: _l2_words(relative_error(channel, snapshot), "L2 error")


def shear_stress_error_label(channel) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> relative error of the polymer shear stress in words."""

    def label(snapshot: Snapshot) -> str:
        exact = channel.exact_polymer_shear_stress(snapshot.y, snapshot.t)
        norm = float(np.linalg.norm(exact))
        error = float(np.linalg.norm(snapshot.stress_xy - exact)) / norm if norm > 0 else None
        return _l2_words(error, "L2 error of Sxy")

    return label


def loses_its_scale(channel) -> bool:
    """Tell whether the exact velocity takes both signs at any time, or dies away.

    The flow itself decides, not the length of a run: the same flow has the same error measure everywhere.
    """
    if channel.bottom.oscillates or channel.top.oscillates:
        return True
    slowest = max(channel.viscous_time, channel.polymer.relaxation_time if channel.polymer else 0.0)
    # The slowest mode decays as exp(-pi^2 t*): at t* = 3 nothing of a start is left.
    times = channel.start_time + 3.0 * slowest * np.linspace(0.0, 1.0, _TIMES) ** 2
    u = channel.exact_velocity(np.linspace(0.0, channel.gap, _HEIGHTS)[:, None], times[None, :])
    small = _SMALL * np.abs(u).max()
    return bool((u.min() < -small and u.max() > small) or np.abs(u[:, -1]).max() <= small)


def _l2_words(error: float | None, name: str) -> str:
    return f"{name}: none yet" if error is None else f"{name} {scientific(error)}"
