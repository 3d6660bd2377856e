"""Viscoelastic fluids in two-dimensional flow, in the verification suite: between two cylinders, and past one.

Between the cylinders, of radii 1 and 2, the fluid is at rest until the inner one rotates at 1; viscosity, density and
relaxation time are 1, so that times are relaxation times. The cylinder of radius 1 is in the middle of a channel of
width 4 and period 16; what drives the fluid was chosen for a Weissenberg number lambda U/R, U the mean velocity in the
channel, of about 0.25. All particles start up to a fifth of a spacing off an even arrangement.
"""

import csv
import math

from scipy.interpolate import CubicSpline

from tisph.studies.flows import across, at_times, merged, walls
from tisph.studies.verification.criteria import at_most, of_whole_runs, order

START = {
    "scene": "annulus",
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 1.0,
        "rheology": {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.1},
    },
    "geometry": {"inner_radius": 1.0, "outer_radius": 2.0},
    "walls": {"inner": {"angular_velocity": 1.0}},
    "initial": {"jitter": 0.2, "seed": 0},
    "discretisation": {"particles_across": 25},
}

GIESEKUS = {
    "fluid": {
        "rheology": {"type": "giesekus", "relaxation_time": 1.0, "solvent_fraction": 0.1, "mobility": 0.2},
    }
}

OSCILLATING_INNER = {
    "fluid": {"rheology": {"type": "oldroyd_b", "relaxation_time": 0.1, "solvent_fraction": 0.1}},
    "walls": {"inner": {"angular_velocity": None, "amplitude": 1.0, "angular_frequency": 6.2832, "phase": "sin"}},
}
"""The inner cylinder oscillates, one period in ten relaxation times."""

STRAINED = {
    "walls": {"inner": {"angular_velocity": None, "times": [0.0, 0.2, 0.2], "angular_velocities": [1.0, 1.0, 0.0]}},
}
"""The inner cylinder rotates for a fifth of a relaxation time and stops: step strain."""

STRAINED_BOUNDS = {"rms": 1e-3, "shear_stress_l2": 6e-3, "normal_stress_l2": 6e-3, "torque_inner off exact": 6e-3}
"""At 16 across; of stress and torque those at 25, 1e-3, for a spacing 25/16 as large, with the fourth power."""

DRAG = CubicSpline(
    [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9],
    [132.3575, 130.36, 126.63, 123.19, 120.60, 118.84, 117.78, 117.32, 117.37, 117.79],
)
"""Force on the cylinder over dynamic viscosity and mean velocity by Weissenberg number, for a solvent fraction of 0.59
and without inertia: M. A. Hulsen, R. Fattal and R. Kupferman, J. Non-Newtonian Fluid Mech. 127 (2005) 27-39."""


CONFINED = merged(
    {
        "scene": "channel",
        "fluid": {
            "density": 1.0,
            "kinematic_viscosity": 5.0,
            "rheology": {"type": "oldroyd_b", "relaxation_time": 0.3, "solvent_fraction": 0.59},
        },
        "geometry": {"gap": 4.0, "length": 16.0},
        "bodies": [{"type": "circle", "centre": [8.0, 2.0], "radius": 1.0}],
        "drive": {"acceleration": 14.0},
        "initial": {"jitter": 0.2, "seed": 0},
        **at_times([2.0]),
    },
    walls(0.0, 0.0),
    across(48),
)

SAMPLES = (0.5, 1.0, 2.0)

QUICK = {"oldroyd_b_annulus_12": merged(START, across(12), at_times([1.0]))}

FULL = {
    "oldroyd_b_annulus_12": merged(START, across(12), at_times(SAMPLES)),
    "oldroyd_b_annulus_25": merged(START, at_times(SAMPLES)),
    "oldroyd_b_annulus_50": merged(START, across(50), at_times(SAMPLES)),
    "giesekus_annulus_50": merged(START, GIESEKUS, across(50), at_times(SAMPLES)),
    "oldroyd_b_swinging_16": merged(START, OSCILLATING_INNER, across(16), at_times((0.5, 1.0))),
    "oldroyd_b_step_strain_16": merged(START, STRAINED, across(16), at_times(SAMPLES)),
    "confined_cylinder": CONFINED,
}


def runs(quick):
    """Configs by run name, as plain dicts."""
    return QUICK if quick else FULL


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    if quick:
        # 16 times the bounds at 25 across, for a spacing twice as large
        return [at_most("oldroyd_b_annulus_12", 1.0, "l2", 8e-3), *_torques("oldroyd_b_annulus_12", 1.0, 1.6e-2)]
    resolutions = {f"oldroyd_b_annulus_{number}": number for number in (12, 25, 50)}
    return [
        *_start("oldroyd_b_annulus_25"),
        *_start("oldroyd_b_annulus_50"),
        *_start("giesekus_annulus_50"),
        *(
            at_most("oldroyd_b_swinging_16", t_star, quantity, 1e-3)
            for t_star in (0.5, 1.0)
            for quantity in ("l2", "shear_stress_l2", "torque_inner off exact")
        ),
        *(
            at_most("oldroyd_b_step_strain_16", t_star, quantity, bound)
            for t_star in SAMPLES
            for quantity, bound in STRAINED_BOUNDS.items()
        ),
        _normal_stress("oldroyd_b_step_strain_16"),
        order("oldroyd_b_annulus 12/25/50", resolutions, 1.0, 3, "l2"),
        _drag("confined_cylinder"),
    ]


def _start(name):
    quantities = {"l2": 5e-4, "shear_stress_l2": 1e-3, "normal_stress_l2": 1e-3}
    return [
        check
        for t_star in SAMPLES
        for check in (
            *(at_most(name, t_star, quantity, bound) for quantity, bound in quantities.items()),
            *_torques(name, t_star, 1e-3),
        )
    ]


def _torques(name, t_star, bound):
    return [at_most(name, t_star, f"torque_{side} off exact", bound) for side in ("inner", "outer")]


def _normal_stress(name):
    """N1 at the inner cylinder at all times of the history at which the flow is resolved, over the largest."""

    def off(result):
        with open(result.folder / "history.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        pairs = [(float(row["n1_inner"]), float(row["n1_inner_exact"])) for row in rows if int(row["resolved"])]
        return max(abs(found - exact) for found, exact in pairs) / max(exact for _, exact in pairs)

    return of_whole_runs(name, "N1 at the inner cylinder off the largest", STRAINED_BOUNDS["normal_stress_l2"], off)


def _drag(name):
    """Drag at the Weissenberg number that the run came to; the falling pressure, which drives it, pushes as well."""
    config = FULL[name]
    viscosity, drive = config["fluid"]["kinematic_viscosity"], config["drive"]["acceleration"]
    relaxation_time = config["fluid"]["rheology"]["relaxation_time"]

    def off(result):
        velocity = result.last["superficial_velocity"]
        found = (result.last["drag"] + drive * math.pi) / (viscosity * velocity)
        return abs(found / float(DRAG(relaxation_time * velocity)) - 1)

    return of_whole_runs(name, "drag over viscosity and velocity off the literature", 5e-3, off)
