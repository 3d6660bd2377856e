"""Error norms of a sample against the reference solution at its particles: its numbers in ``summary.json``."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tisph.measures.flow import FlowInBox
from tisph.measures.heat import substance_errors, substance_measures
from tisph.measures.resolution import load_scatters, resolution
from tisph.measures.steadiness import followed, steadiness
from tisph.snapshot import Snapshot


def with_reference(scene: FlowInBox, snapshot: Snapshot, fields: Sequence[str] | None = None) -> Snapshot:
    """Return ``snapshot`` with its ``reference``: arrays (particles,) of all fields with a reference.

    ``fields`` restricts them, unless the snapshot has a reference already.
    """
    if snapshot.reference is not None:
        return snapshot
    names = scene.fields if fields is None else fields
    return replace(snapshot, reference={name: scene.exact(name, snapshot.x, snapshot.y, snapshot.t) for name in names})


ROUNDINGS = 4.0
"""Units in the last place of the frame's velocity below which a velocity in the frame counts as 0."""


def sample_metrics(
    scene: FlowInBox, snapshot: Snapshot, series: tuple[Any, ...], errors_alone: bool = False
) -> dict[str, Any]:
    """Return the numbers of a sample: its errors against the reference of the scene, and the scene's own measures.

    ``series`` is the argument of ``Scene.diagnostics``, whose numbers ``errors_alone`` omits. A number is None where it
    does not exist, such as an error without a reference, or a relative error of a fluid at rest.

    ``t``, ``step`` (the number of steps so far), ``t_star`` = t / time scale of the scene; ``resolved``, and a
    ``reason`` where it is not (``resolution.py``). Over the particles at their own positions, weighted by their areas
    where these vary, for the velocity components u that have a reference: ``l2`` = sqrt(sum |u-u_exact|^2 / sum
    |u_exact|^2), with u relative to the scene's ``frame_velocity``; ``rms`` = sqrt(mean |u-u_exact|^2) / U and ``linf``
    = max |u-u_exact| / U, with U the reference velocity. ``rms`` is meaningful at all times, ``l2`` is not where u
    crosses zero. ``steady``, ``steady_change`` and ``steady_reason``: ``steadiness.py``, where ``series`` has sizes.
    """
    snapshot = with_reference(scene, snapshot)
    squares, record = _squared_errors(scene, snapshot), followed(series)
    diagnostics: dict[str, Any] = {
        "t": snapshot.t,
        "step": snapshot.step,
        "t_star": snapshot.t / scene.time_scale,
        "l2": relative_error(scene, snapshot),
        "rms": rms_error(scene, snapshot),
        "linf": None if squares is None else np.sqrt(np.max(squares)) / scene.reference_velocity,
        **({} if errors_alone else {**scene.diagnostics(snapshot, series), **load_scatters(scene, snapshot)}),
        **substance_errors(scene, snapshot),
        **({} if errors_alone else substance_measures(scene, snapshot)),
        **({} if errors_alone or record is None else steadiness(scene, snapshot.t, record).numbers),
    }
    numbers = {}
    for key, value in diagnostics.items():
        if key.endswith("_exact") and not scene.comparable:  # a reference of the flow at one temperature
            continue
        if key != "step" and not isinstance(value, bool | str):
            value = float(value) if value is not None and np.isfinite(value) else None
        numbers[key] = value
    resolved, reason = resolution(scene, snapshot.t, snapshot)
    return {"t": numbers.pop("t"), "resolved": resolved, "reason": reason, **numbers}


def relative_error(scene: FlowInBox, snapshot: Snapshot) -> float | None:
    """Return sqrt(sum |u - u_exact|^2 / sum |u_exact|^2) over the particles; None for an exact solution at rest.

    Velocities are relative to the flow's own frame (``scene.frame_velocity``).
    """
    values, exact = velocities(scene, snapshot)
    if not len(exact):
        return None
    for components in (values, exact):
        components[0] -= scene.frame_velocity
    rounding = ROUNDINGS * np.spacing(abs(scene.frame_velocity))
    return relative_difference(values, exact, snapshot.weight, rounding)


def rms_error(scene: FlowInBox, snapshot: Snapshot) -> float | None:
    """Return sqrt(mean |u - u_exact|^2) over the particles, over the reference velocity; None without a reference."""
    squares = _squared_errors(scene, snapshot)
    return None if squares is None else float(np.sqrt(np.mean(snapshot.weight * squares))) / scene.reference_velocity


def root_mean_square(values: np.ndarray) -> float:
    """Return the root mean square of an array of any shape."""
    return float(np.sqrt(np.mean(np.square(values))))


def _squared_errors(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray | None:
    values, exact = velocities(scene, snapshot)
    return np.square(values - exact).sum(axis=0) if len(exact) else None


def field_error(scene: FlowInBox, snapshot: Snapshot, field: str) -> float | None:
    """Return sqrt(sum (f - f_exact)^2 / sum f_exact^2) of one field over the particles.

    None for f_exact = 0, and for a field without a reference.

    For the pressure, which is defined up to a constant, the mean of f - f_exact is subtracted first.
    """
    if field not in scene.fields:
        return None
    exact = (with_reference(scene, snapshot, (field,)).reference or {})[field]
    values = snapshot.field(field)
    if field == "pressure":
        values = values - np.mean(snapshot.weight * (values - exact))
    return relative_difference(values, exact, snapshot.weight)


def velocities(scene: FlowInBox, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities and their references, arrays (components with a reference, particles)."""
    names = [name for name in ("u", "v", "w") if name in scene.fields]
    snapshot = with_reference(scene, snapshot, names)
    exact = snapshot.reference or {}
    values = np.array([getattr(snapshot, name) for name in names], dtype=float)
    return values, np.array([exact[name] for name in names], dtype=float)


def relative_difference(values: np.ndarray, exact: np.ndarray, weight: Any, nothing: float = 0.0) -> float | None:
    """Return |values - exact| / |exact| in the L2 norm; None where the root mean square of ``exact`` is ``nothing``.

    ``values`` and ``exact`` (..., particles); ``weight``: ``Snapshot.weight`` of the particles.
    """
    norm = float(np.linalg.norm(weight**0.5 * exact))
    off = float(np.linalg.norm(weight**0.5 * (values - exact)))
    return off / norm if norm > nothing * np.shape(exact)[-1] ** 0.5 else None


def fit_line(y: np.ndarray, u: np.ndarray) -> tuple[float, float]:
    """Return slope and intercept of the least-squares line through the points (``y``, ``u``); NaN for one point."""
    offset = y - np.mean(y)
    spread = np.sum(offset**2)
    slope = np.sum(offset * u) / spread if spread > 0 else np.nan
    return slope, np.mean(u) - slope * np.mean(y)


def fitted_order(resolutions: Iterable[float], errors: Sequence[float] | np.ndarray) -> float:
    """Return the power of the spacing with which ``errors`` at ``resolutions`` (particles across) fall."""
    return float(fit_line(-np.log(list(resolutions)), np.log(errors))[0])
