"""SPHERIC benchmark 3: the sharp lid at Re = 1000 from rest to the steady state, and Re = 10000, which is not resolved.

Width and speed of the lid are 1. Extremes: O. Botella and R. Peyret, Computers & Fluids 27 (1998) 421-433.
"""

import math

from tisph.studies.flows import across, at_times, merged
from tisph.studies.verification.cavity import SHARP
from tisph.studies.verification.criteria import at_most, bounded

LATE, COARSE = 60.0, "cavity_re10000_100"

EXTREMES = {50: 2e-2, 70: 1e-2, 100: 5e-3}
"""Largest error of the extremes, which exists in steady flow alone, by the number of particles across."""


def runs():
    """Configs by run name, as plain dicts."""
    cases = {f"cavity_re1000_{number}": (1e-3, number, range(10, 61, 10)) for number in EXTREMES}
    return {
        name: merged(SHARP, {"fluid": {"kinematic_viscosity": viscosity}}, across(number), at_times(times))
        for name, (viscosity, number, times) in {**cases, COARSE: (1e-4, 100, (0.5, 1.0, 2.0))}.items()
    }


def criteria():
    """Bounds of the runs, in the order of the table."""
    found = []
    for number, bound in EXTREMES.items():
        name = f"cavity_re1000_{number}"
        found.append(at_most(name, LATE, "energy_change", 3e-4))  # as measures/steady.py has it
        found += [at_most(name, LATE, f"{kind} off exact", bound) for kind in ("u_extreme", "v_max", "v_min")]
    return [*found, bounded(COARSE, "samples called resolved", 0, _called_resolved)]


def _called_resolved(result):
    """Count the samples that claim to be resolved, up to the end or to where the run was stopped; NaN without a run."""
    ended = result.summary["status"] in ("done", "diverged")
    return sum(sample["resolved"] for sample in result.summary["samples"]) if ended else math.nan
