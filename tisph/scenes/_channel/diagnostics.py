"""What a sample of a channel is measured by beside its errors: lines through probes, centreline, walls, stresses.

A straight-line fit through the probes, the measure of the verification page, cannot see errors that are
symmetric about mid-gap. It is given, and always beside the errors of the whole profile.
"""

import numpy as np

from tisph.measures.channel import interpolate, wall_shear, wall_velocity
from tisph.measures.metrics import fit_line, relative_difference

CENTRELINE_POINTS = 32
"""Points along the channel over which the velocity at mid-gap is averaged."""


def diagnostics(channel, snapshot, series):
    """Numbers of a snapshot with its reference; ``series`` begins with heights y and velocities u at the probes.

    With polymer ``shear_stress_l2`` = sqrt(sum (S-S_exact)^2 / sum S_exact^2) of S = S_xy, and ``normal_stress_l2``,
    that of the first normal stress difference S_xx - S_yy;
    ``slope`` (1/time), ``intercept`` (velocity) of the least-squares line u(y) through the probes; ``centreline``: u
    at mid-gap, averaged along the channel; ``wall_shear_bottom``, ``wall_shear_top``: total shear stress on the
    fluid's side of the walls, see ``measures/channel.py``; each also ``_exact``, the lines being fitted to exact
    velocities at the same probes; ``density_variation`` = max |density/density_0 - 1|;
    ``max_transverse_velocity`` = max |v|. None where one does not exist (a wall shear that is infinite).
    """
    return {
        **_stress_errors(channel, snapshot),
        **_line_fits(channel, snapshot.t, *series[:2]),
        **_centreline(channel, snapshot),
        **_wall_shears(channel, snapshot),
        **_plate(channel, snapshot),
        "density_variation": np.max(np.abs(snapshot.density / channel.density - 1)),
        "max_transverse_velocity": np.max(np.abs(snapshot.v)),
    }


def _stress_errors(channel, snapshot):
    if channel.polymer is None:
        return {}
    exact = snapshot.reference
    normal = exact["stress_xx"] - exact["stress_yy"]
    return {
        "shear_stress_l2": relative_difference(snapshot.stress_xy, exact["stress_xy"]),
        "normal_stress_l2": relative_difference(snapshot.stress_xx - snapshot.stress_yy, normal),
    }


def _line_fits(channel, t, y, u):
    slope, intercept = fit_line(y, u)
    slope_exact, intercept_exact = fit_line(y, channel.exact_velocity(y, t))
    return {
        "slope": slope,
        "slope_exact": slope_exact,
        "intercept": intercept,
        "intercept_exact": intercept_exact,
    }


def _centreline(channel, snapshot):
    x = (np.arange(CENTRELINE_POINTS) + 0.5) * channel.length / CENTRELINE_POINTS
    middle = 0.5 * channel.gap
    velocity = interpolate(snapshot, channel, x, np.full(CENTRELINE_POINTS, middle))
    return {
        "centreline": np.mean(velocity),
        "centreline_exact": channel.exact_velocity(middle, snapshot.t),
    }


def _plate(channel, snapshot):
    """Velocity of the stress-controlled wall, if there is one."""
    if channel.driven_side is None:
        return {}
    velocity = wall_velocity(channel, channel.driven_side, snapshot)
    return {
        "plate_velocity": velocity,
        "plate_velocity_exact": channel.exact_velocity(channel.gap * channel.driven_side, snapshot.t),
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
