"""The error of a snapshot against the reference, in the words of the pictures."""

from collections.abc import Callable

from tisph.measures.metrics import field_error, relative_error, rms_error
from tisph.measures.resolution import layer_spacings, resolution
from tisph.report.labels import scientific
from tisph.snapshot import Snapshot


def velocity_error_label(scene) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> error of the velocity in words, for example ``L2 error 1.5×10⁻³``.

    Where u crosses zero or decays (``vanishing_scale``), a relative error would be large for no fault of the
    particles: it is then the rms error as a multiple of the reference velocity U, ``rms error 1.5×10⁻³ U``. Before a
    layer is resolved it has no error to speak of: ``unresolved: 0.3 spacings`` is how thin it is. Without a reference
    there are no words.
    """
    if not scene.fields:
        return lambda snapshot: ""
    by_speed = scene.vanishing_scale

    def label(snapshot: Snapshot) -> str:
        if by_speed:
            return f"rms error {scientific(rms_error(scene, snapshot))} U"
        return _l2_words(relative_error(scene, snapshot), "L2 error")

    return _once_resolved(scene, label)


def field_error_label(scene, field: str, name: str) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> relative error of one ``field``, whose ``name`` is in the words."""
    return _once_resolved(scene, lambda snapshot: _l2_words(field_error(scene, snapshot, field), f"L2 error of {name}"))


def _once_resolved(scene, label: Callable[[Snapshot], str]) -> Callable[[Snapshot], str]:
    """Return ``label``, except for snapshots with a layer that the particles do not resolve: how thin it is."""

    def words(snapshot: Snapshot) -> str:
        if resolution(scene, snapshot.t)[0]:
            return label(snapshot)
        return f"unresolved: {layer_spacings(scene, snapshot.t):.1f} spacings"

    return words


def _l2_words(error: float | None, name: str) -> str:
    return f"{name}: none yet" if error is None else f"{name} {scientific(error)}"
