"""The error of a snapshot against the exact solution, in the words of the pictures."""

from collections.abc import Callable

import numpy as np

from tisph.report.labels import scientific
from tisph.snapshot import Snapshot
from tisph.verification.metrics import relative_error, rms_error
from tisph.verification.resolution import layer_spacings, resolution

_TIMES, _HEIGHTS = 40, 51
_SMALL = 0.01  # of the largest speed: a flow slower than that counts as none


def velocity_error_label(channel) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> error of the velocity in words, for example ``L2 error 1.5×10⁻³``.

    Where u crosses zero or dies away (``loses_its_scale``), a relative error would be large for no fault of the
    particles: it is then the rms error as a multiple of the reference velocity U, ``rms error 1.5×10⁻³ U``. Before a
    layer is resolved it has no error to speak of: ``unresolved: 0.3 spacings`` is how thin it is.
    """
    by_speed = loses_its_scale(channel)

    def label(snapshot: Snapshot) -> str:
        if by_speed:
            return f"rms error {scientific(rms_error(channel, snapshot))} U"
        return _l2_words(relative_error(channel, snapshot), "L2 error")

    return _once_resolved(channel, label)


def shear_stress_error_label(channel) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> relative error of the polymer shear stress in words."""

    def label(snapshot: Snapshot) -> str:
        exact = channel.exact_polymer_shear_stress(snapshot.y, snapshot.t)
        norm = float(np.linalg.norm(exact))
        error = float(np.linalg.norm(snapshot.stress_xy - exact)) / norm if norm > 0 else None
        return _l2_words(error, "L2 error of Sxy")

    return _once_resolved(channel, label)


def _once_resolved(channel, label: Callable[[Snapshot], str]) -> Callable[[Snapshot], str]:
    """Return ``label``, except for snapshots with a layer that the particles do not resolve: how thin it is."""

    def words(snapshot: Snapshot) -> str:
        if resolution(channel, snapshot.t)[0]:
            return label(snapshot)
        return f"unresolved: {layer_spacings(channel, snapshot.t):.1f} spacings"

    return words


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
    u -= channel.frame_velocity
    small = _SMALL * np.abs(u).max()
    return bool((u.min() < -small and u.max() > small) or np.abs(u[:, -1]).max() <= small)


def _l2_words(error: float | None, name: str) -> str:
    return f"{name}: none yet" if error is None else f"{name} {scientific(error)}"
