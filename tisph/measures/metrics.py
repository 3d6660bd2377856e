"""Error measures of one sample: the numbers of a sample in ``summary.json``.

The reference solution at the particles of a snapshot, beside what they have.
"""

from dataclasses import replace

import numpy as np

from tisph.measures.resolution import resolution


def with_reference(scene, snapshot, fields=None):
    """Return ``snapshot`` with its ``reference``: arrays (particles,) of all fields that the scene has one of.

    Of these only ``fields``, where they are given and the snapshot has no reference yet.
    """
    if snapshot.reference is not None:
        return snapshot
    names = scene.fields if fields is None else fields
    return replace(snapshot, reference={name: scene.exact(name, snapshot.x, snapshot.y, snapshot.t) for name in names})


ROUNDINGS = 4.0
"""Last digits of the velocity of the frame below which a velocity in it is rest: exact solutions are sums of a few."""


def sample_metrics(scene, snapshot, series, errors_alone=False):
    """Compare a snapshot with the reference of its scene at its time.

    ``series`` is what the scene follows in time, see ``Scene.diagnostics``, whose numbers ``errors_alone`` leaves out.
    Returns a dict of numbers, None where one does not exist (a relative error of a fluid at rest, any error without a
    reference):

    ``t``, ``step`` (how many there have been), ``t_star`` = t / time scale of the scene; ``resolved`` and the
    ``reason`` why not, None where it is (``resolution.py``); over the particles at their own positions, u standing for
    the velocity, along one axis or both as the reference has them, ``l2`` = sqrt(sum |u-u_exact|^2 / sum |u_exact|^2),
    ``rms`` = sqrt(mean |u-u_exact|^2) / U and ``linf`` = max |u-u_exact| / U, u being relative to the scene's
    ``frame_velocity`` and U its reference velocity (``l2`` says little where u crosses zero, ``rms`` always does); and
    what the scene itself measures.
    """
    snapshot = with_reference(scene, snapshot)
    diagnostics = {
        "t": snapshot.t,
        "step": snapshot.step,
        "t_star": snapshot.t / scene.time_scale,
        "l2": relative_error(scene, snapshot),
        "rms": rms_error(scene, snapshot),
        "linf": _largest_error(scene, snapshot),
        **({} if errors_alone else scene.diagnostics(snapshot, series)),
    }
    numbers = {
        key: value if key == "step" or isinstance(value, bool | str) else _number(value)
        for key, value in diagnostics.items()
    }
    resolved, reason = resolution(scene, snapshot.t, snapshot)
    return {"t": numbers.pop("t"), "resolved": resolved, "reason": reason, **numbers}


def _number(value):
    return float(value) if value is not None and np.isfinite(value) else None


def relative_error(scene, snapshot):
    """L2 error sqrt(sum |u - u_exact|^2 / sum |u_exact|^2) over the particles; None if all should be at rest.

    Velocities are those of the flow's own frame (``scene.frame_velocity``).
    """
    values, exact = velocities(scene, snapshot)
    if not len(exact):
        return None
    for components in (values, exact):
        components[0] -= scene.frame_velocity
    return relative_difference(values, exact, ROUNDINGS * np.spacing(abs(scene.frame_velocity)))


def rms_error(scene, snapshot):
    """Root mean square error sqrt(mean |u - u_exact|^2) over the particles, over the reference velocity."""
    squares = _squared_errors(scene, snapshot)
    return None if squares is None else float(np.sqrt(np.mean(squares))) / scene.reference_velocity


def root_mean_square(values):
    """Return that of an array of any shape."""
    return float(np.sqrt(np.mean(np.square(values))))


def _largest_error(scene, snapshot):
    squares = _squared_errors(scene, snapshot)
    return None if squares is None else np.sqrt(np.max(squares)) / scene.reference_velocity


def _squared_errors(scene, snapshot):
    values, exact = velocities(scene, snapshot)
    return np.square(values - exact).sum(axis=0) if len(exact) else None


def field_error(scene, snapshot, field):
    """L2 error sqrt(sum (f - f_exact)^2 / sum f_exact^2) of one field over the particles; None if that should be zero.

    Of the pressure, of which only differences count, the mean of f - f_exact is taken away first.
    """
    exact = with_reference(scene, snapshot, (field,)).reference[field]
    values = getattr(snapshot, field)
    return relative_difference(values - np.mean(values - exact) if field == "pressure" else values, exact)


def velocities(scene, snapshot):
    """Velocities and their references, arrays (components that have one, particles)."""
    names = [name for name in ("u", "v", "w") if name in scene.fields]
    snapshot = with_reference(scene, snapshot, names)
    pairs = [(getattr(snapshot, name), snapshot.reference[name]) for name in names]
    return tuple(np.array([pair[side] for pair in pairs], dtype=float) for side in (0, 1))


def relative_difference(values, exact, nothing=0.0):
    """L2 norm of the difference over that of ``exact``; None where that is ``nothing``, as a root mean square."""
    norm = float(np.linalg.norm(exact))
    return float(np.linalg.norm(values - exact)) / norm if norm > nothing * np.shape(exact)[-1] ** 0.5 else None


def fit_line(y, u):
    """Slope and intercept of the least-squares line through the points (``y``, ``u``); NaN for one point."""
    offset = y - np.mean(y)
    spread = np.sum(offset**2)
    slope = np.sum(offset * u) / spread if spread > 0 else np.nan
    return slope, np.mean(u) - slope * np.mean(y)


def fitted_order(resolutions, errors):
    """Power of the spacing with which ``errors`` at ``resolutions`` (particles across) fall, by least squares."""
    return float(fit_line(-np.log(list(resolutions)), np.log(errors))[0])
