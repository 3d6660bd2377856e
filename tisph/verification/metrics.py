"""Error measures of one sample: the numbers of a sample in ``summary.json``.

A straight-line fit through the tracers, the measure of the verification page, cannot see errors that are
symmetric about mid-gap. It is given, and always beside the errors of the whole profile.
"""

import numpy as np

from tisph.verification.interpolation import interpolate
from tisph.verification.reference import with_reference
from tisph.verification.resolution import resolution
from tisph.verification.wall_shear import wall_shear

CENTRELINE_POINTS = 32
"""Points along the channel over which the velocity at mid-gap is averaged."""

ROUNDINGS = 4.0
"""Last digits of the velocity of the frame below which a velocity in it is rest: exact solutions are sums of a few."""


def sample_metrics(channel, snapshot, tracers):
    """Compare a snapshot with the exact solution at its time.

    ``tracers`` is the pair (y, u) of arrays of heights and velocities at the probes. Returns a dict of
    numbers, None where one does not exist (a relative error of a liquid at rest, a wall shear that is infinite):

    ``t``, ``step`` (how many there have been), ``t_star`` = nu t/gap^2 with the total viscosity; ``resolved`` and the
    ``reason`` why not, None where it is (``resolution.py``); over the particles at
    their own positions ``l2`` = sqrt(sum (u-u_exact)^2 / sum u_exact^2), ``rms`` = sqrt(mean (u-u_exact)^2) / U and
    ``linf`` = max |u-u_exact| / U, u being relative to the channel's ``frame_velocity`` and U its reference velocity
    (``l2`` says little where u crosses zero, ``rms`` always does); with
    polymer ``shear_stress_l2`` = sqrt(sum (S-S_exact)^2 / sum S_exact^2) of S = S_xy, and ``normal_stress_l2``,
    that of the first normal stress difference S_xx - S_yy;
    ``slope`` (1/time), ``intercept`` (velocity) of the least-squares line u(y) through the tracers; ``centreline``: u
    at mid-gap, averaged along the channel; ``wall_shear_bottom``, ``wall_shear_top``: total shear stress on the
    liquid's side of the walls, see ``wall_shear.py``; each also ``_exact``, the lines being fitted to exact
    velocities at the same tracers; ``density_variation`` = max |density/density_0 - 1|;
    ``max_transverse_velocity`` = max |v|.
    """
    snapshot = with_reference(channel, snapshot)
    measures = {
        "t": snapshot.t,
        "step": snapshot.step,
        "t_star": snapshot.t / channel.viscous_time,
        "l2": relative_error(channel, snapshot),
        "rms": rms_error(channel, snapshot),
        "linf": _largest_error(channel, snapshot),
        **_stress_errors(channel, snapshot),
        **_line_fits(channel, snapshot.t, *tracers),
        **_centreline(channel, snapshot),
        **_wall_shears(channel, snapshot),
        "density_variation": np.max(np.abs(snapshot.density / channel.density - 1)),
        "max_transverse_velocity": np.max(np.abs(snapshot.v)),
    }
    numbers = {key: value if key == "step" else _number(value) for key, value in measures.items()}
    resolved, reason = resolution(channel, snapshot.t)
    return {"t": numbers.pop("t"), "resolved": resolved, "reason": reason, **numbers}


def _number(value):
    return float(value) if value is not None and np.isfinite(value) else None


def relative_error(channel, snapshot):
    """L2 error sqrt(sum (u - u_exact)^2 / sum u_exact^2) over the particles; None if all should be at rest.

    Velocities are those of the flow's own frame (``channel.frame_velocity``).
    """
    frame = channel.frame_velocity
    exact = _exact_velocity(channel, snapshot) - frame
    return _relative_difference(snapshot.u - frame, exact, ROUNDINGS * np.spacing(abs(frame)))


def rms_error(channel, snapshot):
    """Root mean square error sqrt(mean (u - u_exact)^2) over the particles, over the reference velocity."""
    error = snapshot.u - _exact_velocity(channel, snapshot)
    return float(np.sqrt(np.mean(error**2))) / channel.reference_velocity


def _exact_velocity(channel, snapshot):
    reference = snapshot.reference
    return channel.exact_velocity(snapshot.y, snapshot.t) if reference is None else reference["u"]


def _relative_difference(values, exact, nothing=0.0):
    """L2 norm of the difference over that of ``exact``; None where that is ``nothing``, as a root mean square."""
    norm = float(np.linalg.norm(exact))
    return float(np.linalg.norm(values - exact)) / norm if norm > nothing * len(exact) ** 0.5 else None


def _stress_errors(channel, snapshot):
    if channel.polymer is None:
        return {}
    exact = snapshot.reference
    normal = exact["stress_xx"] - exact["stress_yy"]
    return {
        "shear_stress_l2": _relative_difference(snapshot.stress_xy, exact["stress_xy"]),
        "normal_stress_l2": _relative_difference(snapshot.stress_xx - snapshot.stress_yy, normal),
    }


def _largest_error(channel, snapshot):
    error = snapshot.u - _exact_velocity(channel, snapshot)
    return np.max(np.abs(error)) / channel.reference_velocity


def _line_fits(channel, t, y, u):
    slope, intercept = fit_line(y, u)
    slope_exact, intercept_exact = fit_line(y, channel.exact_velocity(y, t))
    return {
        "slope": slope,
        "slope_exact": slope_exact,
        "intercept": intercept,
        "intercept_exact": intercept_exact,
    }


def fit_line(y, u):
    """Slope and intercept of the least-squares line through the points (``y``, ``u``); NaN for one point."""
    offset = y - np.mean(y)
    spread = np.sum(offset**2)
    slope = np.sum(offset * u) / spread if spread > 0 else np.nan
    return slope, np.mean(u) - slope * np.mean(y)


def _centreline(channel, snapshot):
    x = (np.arange(CENTRELINE_POINTS) + 0.5) * channel.length / CENTRELINE_POINTS
    middle = 0.5 * channel.gap
    velocity = interpolate(snapshot, channel, x, np.full(CENTRELINE_POINTS, middle))
    return {
        "centreline": np.mean(velocity),
        "centreline_exact": channel.exact_velocity(middle, snapshot.t),
    }


def _wall_shears(channel, snapshot):
    bottom, top = wall_shear(channel, snapshot)
    bottom_exact, top_exact = channel.exact_wall_shear(snapshot.t)
    return {
        "wall_shear_bottom": bottom,
        "wall_shear_bottom_exact": bottom_exact,
        "wall_shear_top": top,
        "wall_shear_top_exact": top_exact,
    }
