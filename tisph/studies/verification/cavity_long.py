"""SPHERIC benchmark 3: the sharp lid at Re = 1000 from rest to the steady state, and Re = 10000, which is not resolved.

Width and speed of the lid are 1. The extremes are from O. Botella and R. Peyret, Computers & Fluids 27 (1998) 421-433:
least u on the vertical centre line -0.3885698, largest and least v on the horizontal one 0.3769447 and -0.5270771.
"""

import math

from tisph.studies.flows import across, at_times, merged
from tisph.studies.verification.cavity import SHARP
from tisph.studies.verification.criteria import at_least, at_most, bounded

TIMES = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
"""t* of the samples."""

CHANGE = 3e-4
"""Largest relative change of the kinetic energy per time in which the lid moves by the width."""

EXTREMES = {50: 2e-2, 70: 1e-2, 100: 5e-3}
"""Largest error of the extremes, by the number of particles across."""

COARSE, COARSE_TIMES = "cavity_re10000_100", (0.5, 1.0, 2.0)
"""Boundary layers of a depth of one spacing. The times are short, as the mark does not depend on them."""


def runs():
    """Configs by run name, as plain dicts."""
    found = {f"cavity_re1000_{number}": _config(1e-3, number, TIMES) for number in EXTREMES}
    return found | {COARSE: _config(1e-4, 100, COARSE_TIMES)}


def criteria():
    """Bounds of the runs, in the order of the table."""
    found = []
    for number, bound in EXTREMES.items():
        name = f"cavity_re1000_{number}"
        found += [at_least(name, TIMES[-1], "steady", 1), at_most(name, TIMES[-1], "energy_change", CHANGE)]
        found += [at_most(name, TIMES[-1], f"{kind} off exact", bound) for kind in ("u_extreme", "v_max", "v_min")]
    return [*found, bounded(COARSE, "samples called resolved", 0, _called_resolved)]


def _config(viscosity, number, times):
    return merged(SHARP, {"fluid": {"kinematic_viscosity": viscosity}}, across(number), at_times(times))


def _called_resolved(result):
    """Count the samples that claim to be resolved, up to the end or to where the run was stopped; NaN without a run."""
    ended = result.summary["status"] in ("done", "diverged")
    return sum(sample["resolved"] for sample in result.summary["samples"]) if ended else math.nan
