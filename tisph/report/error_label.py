"""The error of a snapshot against the reference, in the words of the pictures."""

from collections.abc import Callable

from tisph.measures.metrics import field_error, relative_error, rms_error
from tisph.measures.resolution import unresolved
from tisph.report.labels import scientific
from tisph.snapshot import Snapshot


def error_label(scene, field: tuple[str, str] | None = None) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> relative error of the velocity in words, for example ``L2 error 1.5×10⁻³``.

    Where u crosses zero or decays (``vanishing_scale``), a relative error would be large for no fault of the
    particles: it is then the rms error as a multiple of the reference velocity U, ``rms error 1.5×10⁻³ U``. What is not
    resolved has no error to speak of: ``unresolved: 0.3 spacings`` is the thickness of a layer. With ``field``, a name
    and what it is called, it is the error of that one. Without a reference there are no other words.
    """
    of_velocity = field is None
    by_speed = of_velocity and bool(scene.fields) and scene.vanishing_scale  # takes longer than drawing a frame
    name = "L2 error" if of_velocity else f"L2 error of {field[1]}"

    def label(snapshot: Snapshot) -> str:
        lacking = unresolved(scene, snapshot.t, snapshot)
        if lacking:
            return f"unresolved: {lacking[0]}"
        if of_velocity and not scene.fields:
            return ""
        if by_speed:
            return f"rms error {scientific(rms_error(scene, snapshot))} U"
        error = relative_error(scene, snapshot) if of_velocity else field_error(scene, snapshot, field[0])
        return f"{name}: none yet" if error is None else f"{name} {scientific(error)}"

    return label
