"""Rheometry in the verification suite: creep, recovery, a plate that rings, step strain, a rate that rises.

Oldroyd-B fluid of the base: total viscosity 1, a tenth of it the solvent's, relaxation time 1. Bounds are those of
start-up between walls of given velocities.
"""

from tisph.studies import flows
from tisph.studies.flows import across, merged
from tisph.studies.verification.criteria import at_most

BOUND = 1e-3

WALLS = {
    "creep": {"shear_stress": 1.0},
    "recovery": {"times": [0.0, 1.0], "stresses": [1.0, 0.0]},
    "ringing": {"shear_stress": 1.0, "mass_per_area": 1.0},
    "step_strain": {"times": [0.0, 0.2, 0.2], "velocities": [1.0, 1.0, 0.0]},
    "rising_rate": {"times": [0.0, 3.0], "velocities": [0.0, 3.0]},
}
TIMES = {
    "creep": (0.5, 1.0, 3.0),
    "recovery": (1.0, 1.5, 3.0),
    "ringing": (0.5, 1.0, 3.0),
    "step_strain": (0.5, 1.0, 3.0),
    "rising_rate": (0.5, 1.0, 3.0),
}


def runs(quick):
    """Configs by run name: what drives the upper wall."""
    base = merged(flows.NEWTONIAN, flows.oldroyd_b(), {"scheme": {"type": "implicit"}})
    if quick:
        return {"ringing_25": _config(base, "ringing", (1.0,), across(25))}
    return {name: _config(base, name, TIMES[name]) for name in WALLS}


def criteria(quick):
    """What the runs are held to."""
    cases = {"ringing_25": (1.0,)} if quick else TIMES
    return [
        at_most(case, t_star, quantity, BOUND)
        for case, times in cases.items()
        for t_star in times
        for quantity in ("l2", "shear_stress_l2")
    ]


def _config(base, name, times, *changes):
    return flows.sampled(merged(base, {"walls": {"top": WALLS[name]}}, *changes), times)
