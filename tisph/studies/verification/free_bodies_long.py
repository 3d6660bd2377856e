"""Runs of minutes or hours of bodies that the flow carries, against what others have published.

Their numbers are as good as is said with each: most were digitised from figures.
"""

import math

import numpy as np

from tisph.studies.flows import across, at_times, merged, oldroyd_b, state
from tisph.studies.verification.criteria import ends_as, ends_at, of_whole_runs
from tisph.studies.verification.free_bodies import angular_velocity, wall_stress
from tisph.studies.verification.free_bodies_cases import VISCOSITY, fluid, free_circle, in_shear

MIGRATION = {
    10: 0.2963,
    20: 0.3485,
    30: 0.3916,
    40: 0.4234,
    50: 0.4474,
    60: 0.4643,
    70: 0.4760,
    80: 0.4823,
    90: 0.4873,
    100: 0.4908,
    120: 0.4955,
    140: 0.4976,
    160: 0.4983,
    180: 0.4991,
    200: 0.4995,
}
"""Height of a circle that moves to the middle of a sheared gap, by time: J. Feng, H. H. Hu, D. D. Joseph, J. Fluid
Mech. 277 (1994) 271-301, digitised in the documentation of N. Hori's program EllipsesInFlows: to 0.01."""

RESTING_HEIGHT = 0.2723
"""Of a circle in a channel that pressure drives: T.-W. Pan, R. Glowinski, J. Comput. Phys. 181 (2002) 260-279; from
0.2722 to 0.2745 in T. Inamuro, K. Maeba, F. Ogino, Int. J. Multiphase Flow 26 (2000) 1981-2004."""

FASTEST = 17.4
"""Largest Reynolds number, density of the disc * speed * diameter / viscosity, of a disc that settles in a box 2 wide
and 6 high: 17.3 in R. Glowinski et al., J. Comput. Phys. 169 (2001) 363-426, 17.4 to 17.5 in D. Wan, S. Turek, Int. J.
Numer. Methods Fluids 51 (2006) 531-566."""

TURNING = (0.705, 0.539, 0.399, 0.298, 0.233, 0.207, 0.192, 0.191, 0.198, 0.211)
TURNING += (0.240, 0.295, 0.387, 0.516, 0.677, 0.785, 0.729, 0.576, 0.423, 0.319)
"""Angular velocity over shear rate, clockwise, of an ellipse at the times 0.5, 1, ... 10 over shear rate, released
across the flow: C. K. Aidun, Y. Lu, E.-J. Ding, J. Fluid Mech. 373 (1998) 287-311, digitised, to 0.01."""

DISC = 0.125
"""Radius of the disc that settles, in a fluid of density 1 and viscosity 0.1, with a density of 1.25; cgs units."""

RADII = (0.06, 0.08, 0.1)
"""Of single circles in square cells, from the stress of which that of a dilute suspension is extrapolated."""

NEWTONIAN = 0.4856
"""Angular velocity over shear rate of a circle of radius 0.125 in a square cell, by ourselves: slow flow, 50 across."""


def _migrating():
    return merged(in_shear(1.0 / 40.0, 1.0, 40, free_circle(0.5, 0.25, 0.125)), at_times(MIGRATION))


def _driven():
    channel = {"scene": "channel", "geometry": {"gap": 1.0, "length": 1.0}, "walls": {}}
    drive = {"drive": {"acceleration": 2.337e-4}, "bodies": [free_circle(0.5, 0.4, 0.125)]}
    return merged(fluid(1.0 / 2334.0), channel, drive, across(40), at_times(range(200, 2001, 200)))


def _settling(number):
    """In a closed box, its corners rounded; ``number`` of particles over its height. It falls on the floor at 0.77."""
    corners = [[-1.0, -3.0], [1.0, -3.0], [1.0, 3.0], [-1.0, 3.0]]
    box = {"type": "polygon", "centre": [1.0, 3.0], "corners": corners, "corner_radius": 0.1}
    cell = {"scene": "region", "walls": {"around": box}, "bodies": [free_circle(1.0, 4.0, DISC, density=1.25)]}
    times = at_times([*np.arange(0.05, 0.7, 0.05).round(2), *np.arange(0.7, 0.771, 0.005).round(3)])
    return merged(fluid(0.1), cell, {"drive": {"gravity": [0.0, -981.0]}}, across(number), times)


def _ellipse():
    """Reynolds number 25 of the gap and the walls' difference, 1 of the ellipse: 4 G a^2/nu."""
    body = {"type": "ellipse", "centre": [1.0, 0.5], "angle": 1.5707963268, "half_axes": [0.1, 0.05]}
    return merged(in_shear(0.04, 2.0, 120, {**body, "motion": "free", "density": 1.003}), at_times(_half_times()))


def _half_times():
    return [0.5 * number for number in range(1, len(TURNING) + 1)]


def _dilute(radius):
    return merged(in_shear(VISCOSITY, 1.0, 64, free_circle(0.5, 0.5, radius)), at_times([0.02]))


def _viscoelastic(time, number):
    """Relaxation ``time``, which is the Weissenberg number, from rest: a polymer has no developed start with bodies."""
    sheared = merged(in_shear(VISCOSITY, 1.0, number, free_circle(0.5, 0.5, 0.125)), oldroyd_b(time, 0.5))
    return merged(sheared, state("rest"), at_times([5.0]))


CASES = {
    "migration": _migrating(),
    "driven_to_its_height": _driven(),
    "settling_disc": _settling(216),
    "settling_disc_288": _settling(288),
    "turning_ellipse": _ellipse(),
    **{f"dilute_{radius:g}": _dilute(radius) for radius in RADII},
    **{f"free_at_wi_{time:g}_{number}": _viscoelastic(time, number) for time in (0.5, 1.0) for number in (64, 80)},
}


def runs():
    """Configs by run name, as plain dicts."""
    return CASES


def criteria():
    """What the runs are held to, in the order of the table."""
    return [
        *_dilute_limit(),
        *_slowed(0.5),
        *_slowed(1.0),
        of_whole_runs("turning_ellipse", "angular velocity off Aidun et al., at most", 0.03, _turning_off),
        ends_at("settling_disc", "largest Reynolds number", FASTEST, 0.01, _fastest),
        ends_as("settling_disc", "settling_disc_288", "time of contact", 0.01, _contact_time),
        of_whole_runs("migration", "height off Feng et al., at most", 0.02, _migration_off),
        of_whole_runs("migration", "height off the middle", 2e-3, lambda run: abs(_heights(run)[-1] - 0.5)),
        of_whole_runs("driven_to_its_height", f"height off {RESTING_HEIGHT:g}", 5e-3, _resting_off),
    ]


def _heights(run):
    return run.bodies("centre")[:, 0, 1]


def _migration_off(run):
    return np.abs(_heights(run) - [*MIGRATION.values()]).max()


def _resting_off(run):
    return abs(_heights(run)[-1] - RESTING_HEIGHT)


def _fastest(run):
    return 1.25 * np.abs(run.bodies("velocity")[:, 0, 1]).max() * 2 * DISC / 0.1


def _contact_time(run):
    """When the gap between disc and floor is half the radius; nearer than 2 spacings, 0.056, a model pushes it off."""
    times = [sample["t"] for sample in run.summary["samples"]]
    return np.interp(-DISC / 2, DISC - _heights(run), times)


def _turning_off(run):
    return np.abs(run.bodies("angular_velocity")[:, 0] + TURNING).max()


def _dilute_limit():
    """(stress - 1)/fraction, on a line to the fraction 0: 2 (A. Einstein, Ann. Phys. 19 (1906), in two dimensions)."""
    names = tuple(f"dilute_{radius:g}" for radius in RADII)
    fractions = [math.pi * radius**2 for radius in RADII]

    def off(*results):
        rises = [wall_stress(run, CASES[name]) - 1 for name, run in zip(names, results, strict=True)]
        intrinsic = np.divide(rises, fractions)
        return abs(np.polyfit(fractions, intrinsic, 1)[1] / 2 - 1)

    return [of_whole_runs("dilute suspension", "intrinsic viscosity off 2", 0.02, off, names)]


def _slowed(time):
    """No value is known: it turns more slowly than in a Newtonian fluid, and refined by a quarter it does so alike."""
    coarse, fine = (f"free_at_wi_{time:g}_{number}" for number in (64, 80))
    return [
        of_whole_runs(fine, "angular velocity over shear rate", NEWTONIAN, lambda run: -angular_velocity(run)),
        ends_as(coarse, fine, "angular velocity", 1e-2, angular_velocity),
    ]
