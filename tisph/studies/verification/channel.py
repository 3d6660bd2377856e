"""Driven flow, oscillating and stopped walls of a Newtonian fluid in the verification suite.

These are the flows in which the velocity profile is curved at a wall: consistent images must show it there.
"""

from tisph.studies import flows
from tisph.studies.flows import across, jitter, treatment
from tisph.studies.verification.criteria import at_most, closes, near, order, share

WALL_SHEAR = 0.01
CLOSURE = 0.01

FLOOR = 1e-4
"""Bound of an error that no longer falls with the spacing.

Layers of particles that shear change the weights in the Laplacian, and on average the viscosity by 4e-5, at any
resolution. A parabola next to consistent images has no larger error than that, and a flow that has nearly come to
rest approaches it too: an order is asked for where the error is above.
"""

POISEUILLE = {"poiseuille": flows.POISEUILLE, "poiseuille_steady": flows.POISEUILLE_STEADY}

OTHERS = {
    "backflow": flows.BACKFLOW,
    "oscillating_slow": flows.OSCILLATING_SLOW,
    "oscillating_fast": flows.OSCILLATING_FAST,
    "stopped": flows.STOPPED,
}

FLOWS = {**POISEUILLE, **OTHERS}


def runs(quick):
    """Configs by run name: a flow's own name for 50 across, and with what differs behind it.

    Quick ones are the driven flow at 25 and 50 across, and one flow with moving walls of each kind.
    """
    if quick:
        return {
            "poiseuille": flows.POISEUILLE.at(),
            "poiseuille_25": flows.POISEUILLE.at(across(25)),
            "poiseuille_25_comoving": flows.POISEUILLE.at(across(25), treatment("comoving_image")),
            "backflow": flows.BACKFLOW.at(across(25)),
            "oscillating_fast": flows.OSCILLATING_FAST.at(samples=(0.04,)),
        }
    found = {}
    for name, flow in FLOWS.items():
        found |= {name: flow.at(), f"{name}_25": flow.at(across(25)), f"{name}_100": flow.at(across(100))}
    for name, flow in POISEUILLE.items():
        found[f"{name}_jitter_0.2"] = flow.at(jitter(0.2))
        found[f"{name}_comoving"] = flow.at(treatment("comoving_image"))
    return found


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    if quick:
        return [
            share("poiseuille_25", "poiseuille_25_comoving", 0.1, 0.5),
            order("poiseuille", {"poiseuille_25": 25, "poiseuille": 50}, 0.1, 1.9),
            *_walls("poiseuille", flows.POISEUILLE),
            at_most("backflow", 0.1, "rms", 2e-3),
            *_walls("backflow", flows.BACKFLOW),
            at_most("oscillating_fast", 0.04, "rms", 2e-3),
            at_most("oscillating_fast", 0.04, "wall_shear", WALL_SHEAR),
            closes("oscillating_fast", CLOSURE),
        ]
    start_up, steady = flows.POISEUILLE.samples[0], flows.POISEUILLE_STEADY.samples[0]
    at_floor = ("poiseuille_steady_25", "poiseuille_steady", "poiseuille_steady_100", "poiseuille_steady_jitter_0.2")
    found = [
        share("poiseuille", "poiseuille_comoving", start_up, 0.5),
        order("poiseuille", _resolutions("poiseuille"), start_up, 1.9),
        near("poiseuille_jitter_0.2", "poiseuille", start_up, 0.15),
        *_walls("poiseuille", flows.POISEUILLE),
        share("poiseuille_steady", "poiseuille_steady_comoving", steady, 0.5),
        *(at_most(name, steady, "l2", FLOOR) for name in at_floor),
        *_walls("poiseuille_steady", flows.POISEUILLE_STEADY),
    ]
    for name, flow in OTHERS.items():
        found += [at_most(name, t_star, "rms", 2e-3) for t_star in flow.samples]
        found += [order(name, _resolutions(name), flow.samples[0], 1.8, "rms"), *_walls(name, flow)]
    return found


def _resolutions(name):
    return {f"{name}_25": 25, name: 50, f"{name}_100": 100}


def _walls(name, flow):
    """Criteria of the forces on the walls."""
    return [*(at_most(name, t_star, "wall_shear", WALL_SHEAR) for t_star in flow.samples), closes(name, CLOSURE)]
