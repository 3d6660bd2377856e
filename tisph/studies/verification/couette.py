"""Plane Couette flow in the verification suite.

Every flow is start-up plane Couette flow at Re = U gap/nu = 50 (or its developed state), in which the
errors at a dimensionless time t* = nu t/gap^2 depend on the number of particles across alone. The base is
gap 1 cm, length 2 cm, U = 0.5 cm/s, nu = 0.01 cm^2/s, so t = 1.8, 2.7, 20, 100 s are t* = 0.018, 0.027,
0.2, 1.
"""

from tisph.studies.flows import across, jitter, merged, sampled, state, walls
from tisph.studies.verification.criteria import at_most, closes, near, order, same_bits, same_velocities

BASE = {
    "scene": "channel",
    "units": {"length": "cm", "mass": "kg", "time": "s"},
    "fluid": {"density": 1e-3, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 2.0},
    "walls": {
        "treatment": {"type": "comoving_image"},
        "bottom": {"velocity": 0.0},
        "top": {"velocity": 0.5},
    },
    "initial": {"state": "rest"},
    "discretisation": {"particles_across": 50},
    "scheme": {"type": "wcsph"},
}

SI = {
    "units": {"length": "m", "mass": "kg", "time": "s"},
    "fluid": {"density": 1000.0, "kinematic_viscosity": 1e-6},
    "geometry": {"gap": 0.01, "length": 0.02},
    "walls": {"bottom": {"velocity": 0.0}, "top": {"velocity": 0.005}},
}

# Re = 0.2 * 3 / 0.012 = 50; 25 particles across are 15 along.
OTHER_NUMBERS = {
    "fluid": {"density": 850.0, "kinematic_viscosity": 0.012},
    "geometry": {"gap": 3.0, "length": 1.8},
    "walls": {"bottom": {"velocity": 0.0}, "top": {"velocity": -0.2}},
}

SHORT = {"geometry": {"length": 0.4}}
"""For quick runs: nothing depends on x but what disorder makes of it, as in ``flows.py``."""

HALF = {"geometry": {"length": 1.0}}
HALF_SI = merged(SI, {"geometry": {"length": 0.01}})
"""For quick runs in which disorder counts: errors of one arrangement and another differ by less in a longer channel."""

EARLY = (0.018, 0.027)

# Two moving walls have the relative error of one as long as their shear layers do not overlap. The errors
# add up like the velocities: at t* = 0.027 the overlap makes l2 6.5 % larger for opposite walls and 6.5 %
# smaller for equal ones, at t* = 0.018 it is 0.4 %.
BEFORE_LAYERS_MEET = 0.018


def runs(quick):
    """Configs by run name, as plain dicts: the suite of minutes, or the quick one.

    That has the same bounds with fewer and shorter runs: most at 25 across, where a run costs its start-up.
    """
    if quick:
        bottom_wall = {"bottom": {"velocity": 0.2}, "top": {"velocity": 0.0}}
        return {
            "lattice": _flow(EARLY, SHORT),
            "jitter_0.2": _flow(EARLY, SHORT, jitter(0.2)),
            "developed": _flow(EARLY, SHORT, across(25), state("developed")),
            "across_25": _flow(EARLY, HALF, jitter(0.1), across(25)),
            "across_50": _flow(EARLY, HALF, jitter(0.1)),
            "other_flow": _flow(EARLY, jitter(0.1, 1), across(25), OTHER_NUMBERS, {"walls": bottom_wall}),
            "opposite_walls": _flow(EARLY, HALF, jitter(0.1), across(25), walls(0.5, -0.5)),
            "si": _flow(EARLY, jitter(0.1), across(25), HALF_SI),
            "repeat": _flow(EARLY, HALF, jitter(0.1), across(25)),
        }
    early_and_late = (*EARLY, 0.2)
    return {
        "lattice": _flow(early_and_late),
        "jitter_0.2": _flow(early_and_late, jitter(0.2)),
        "jitter_0.2_seed_1": _flow(early_and_late, jitter(0.2, seed=1)),
        "long": _flow((1.0,), jitter(0.1)),
        "developed": _flow(EARLY, state("developed")),
        "across_25": _flow(EARLY, jitter(0.1), across(25)),
        "across_50": _flow(EARLY, jitter(0.1)),
        "across_100": _flow(EARLY, jitter(0.1), across(100)),
        "other_seed": _flow(EARLY, jitter(0.1, seed=1)),
        "other_numbers": _flow(EARLY, OTHER_NUMBERS),
        "bottom_wall": _flow(EARLY, walls(-0.5, 0.0)),
        "opposite_walls": _flow(EARLY, walls(0.5, -0.5)),
        "equal_walls": _flow(EARLY, walls(0.5, 0.5)),
        "si": _flow(EARLY, jitter(0.1), SI),
        "repeat": _flow(EARLY, jitter(0.1)),
    }


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    if quick:
        return [
            at_most("lattice", 0.018, "l2", 1.5e-3),
            at_most("lattice", 0.027, "l2", 1.0e-3),
            at_most("lattice", 0.027, "wall_shear", 0.01),
            closes("lattice", 0.01),
            *(near("jitter_0.2", "lattice", t_star, 0.15) for t_star in EARLY),
            *(at_most("developed", t_star, "l2", 1e-6) for t_star in EARLY),
            order("across_25/50", {"across_25": 25, "across_50": 50}, 0.027, 1.85),
            *(near("other_flow", "across_25", t_star, 0.05) for t_star in EARLY),
            near("opposite_walls", "across_25", BEFORE_LAYERS_MEET, 0.05),
            same_velocities("si", "across_25", 1e-6),
            same_bits("repeat", "across_25"),
        ]
    l2_bounds = {0.018: 1.5e-3, 0.027: 1.0e-3, 0.2: 2.0e-4}
    return [
        *(at_most("lattice", t_star, "l2", bound) for t_star, bound in l2_bounds.items()),
        *(at_most("lattice", t_star, "wall_shear", 0.01) for t_star in l2_bounds),
        closes("lattice", 0.01),
        *(near("jitter_0.2", "lattice", t_star, 0.15) for t_star in l2_bounds),
        *(near("jitter_0.2_seed_1", "lattice", t_star, 0.15) for t_star in l2_bounds),
        *(at_most("developed", t_star, "l2", 1e-6) for t_star in EARLY),
        order("across_25/50/100", {f"across_{number}": number for number in (25, 50, 100)}, 0.027, 1.85),
        *(near("other_seed", "across_50", t_star, 0.05) for t_star in EARLY),
        *(near("other_numbers", "lattice", t_star, 0.05) for t_star in EARLY),
        *(near("bottom_wall", "lattice", t_star, 0.05) for t_star in EARLY),
        near("opposite_walls", "lattice", BEFORE_LAYERS_MEET, 0.05),
        near("equal_walls", "lattice", BEFORE_LAYERS_MEET, 0.05),
        same_velocities("si", "across_50", 1e-6),
        same_bits("repeat", "across_50"),
        at_most("long", 1.0, "l2", 5e-6),
        at_most("long", 1.0, "transverse", 1e-6),
        at_most("long", 1.0, "density_variation", 1e-4),
    ]


def _flow(sample_times, *changes):
    """The base config with ``changes`` merged into it in turn, and samples at the given t*."""
    return sampled(merged(BASE, *changes), sample_times)
