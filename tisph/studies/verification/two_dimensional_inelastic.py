"""Generalised Newtonian fluids between two cylinders, in the verification suite: from rest to the steady flow.

The radii are 1 and 2, the inner cylinder rotates at 1 from t = 0 on; density and viscosity in ``fluid`` are 1, so that
t* = t. The particles start up to a fifth of a spacing off an even arrangement.
"""

from tisph.studies.flows import across, at_times, merged
from tisph.studies.verification.circular_couette import ANNULUS, START
from tisph.studies.verification.criteria import at_most
from tisph.studies.verification.rheologies import VISCOUS

LAWS = {**VISCOUS, "thinning": {**VISCOUS["thinning"], "index": 0.5}}

QUICK = ("carreau",)

SAMPLES = (0.5, 2.0)
"""t* on the way, and at which all flows are steady."""

BOUNDS = {"l2": 1e-4, "torque_inner off exact": 1e-3, "torque_outer off exact": 1e-3}


def runs(quick):
    """Configs by run name, as plain dicts."""
    resolution = across(12) if quick else {}
    found = {}
    for name in QUICK if quick else LAWS:
        fluid = {"fluid": {"kinematic_viscosity": 1.0, "rheology": LAWS[name]}}
        found[f"{name}_annulus"] = merged(ANNULUS, START, fluid, resolution, at_times(SAMPLES))
    return found


def criteria(quick):
    """What the runs are held to: at 12 across 16 times the bounds at 25, for a spacing twice as large."""
    factor = 16.0 if quick else 1.0
    return [
        at_most(f"{name}_annulus", SAMPLES[-1], quantity, factor * bound)
        for name in (QUICK if quick else LAWS)
        for quantity, bound in BOUNDS.items()
    ]
