"""What a run is held to where the flow crosses: an even spread of the particles, no gain of energy, a small error.

Between walls, which drive it, energy may be gained. Where there are bodies and no reference, the error is what the
balance of forces leaves open once they have become steady.
"""

from tisph.studies.stability.flows import FLOWS

HOLE, NEAREST = 1.15, 0.55
"""Radius of the largest hole in a stable run, and the least distance of two particles, in spacings."""

GAIN = 1e-3
"""Part by which the kinetic energy, which is only lost, may exceed that of a quarter of the run before: so much does a
mean over particles that are spread unevenly scatter."""

ERROR = {"explicit": (1e-2, 2), "implicit 4": (1e-3, 3)}
"""By scheme: what 25 particles across may err by in every length over speed of the start, in root mean square over that
speed, and the order in the spacing with which it has to fall. For comparison: PySPH's EDAC has 1.5e-2 at t* = 0.5."""


LEAST_ACROSS, ORDER = 12, 3
"""Particles across at which a flow between walls may have its ``Flow.largest`` error, and the order of its fall."""

UNBALANCED = "unbalanced"
"""The error where there is no reference: forces on all bodies and walls, which do not move on, over the largest."""

STEADY = 1e-2
"""Part of the largest force by which none may have changed since the sample before, for it to be steady: forces scatter
by 3e-3 while particles pass a cylinder of 6 spacings."""


def look(cell, sample, summary):
    """Return of a ``sample`` of a run what is judged."""
    return {
        "error": _unbalanced(sample, summary) if cell.measure == UNBALANCED else sample.get(cell.measure),
        "density_variation": sample["density_variation"],
        "hole": sample["largest_hole"],
        "nearest": sample["nearest_two"],
        "energy": sample.get("kinetic_energy"),
    }


def _unbalanced(sample, summary):
    """None where the forces are not yet those of the sample before."""
    at = summary["samples"].index(sample)
    drags, before = (_drags(summary["samples"][place]) for place in (at, max(at - 1, 0)))
    largest = max(map(abs, drags))
    moved = max(abs(one - other) for one, other in zip(drags, before, strict=True))
    return abs(sum(drags)) / largest if at and moved <= STEADY * largest else None


def _drags(sample):
    names = [name for name in sample if name.startswith("drag") and not name.startswith("drag_pressure")]
    return [sample[name] for name in names]


def faults(plan, looks):
    """Yield in words what ``looks``, in the order of time, break; of holes and pairs at any of them."""
    before, last = looks[-2:]
    if last["error"] is not None and last["error"] > _largest_error(plan.cell, plan.t_star):
        yield f"error {last['error']:.1e} U"
    hole, nearest = max(each["hole"] for each in looks), min(each["nearest"] for each in looks)
    if hole > HOLE:
        yield f"a hole is {hole:.3g} spacings wide"
    if nearest < NEAREST:
        yield f"two particles are {nearest:.3g} spacings apart"
    if not plan.cell.has_walls and last["energy"] > before["energy"] * (1.0 + GAIN):
        yield f"energy grows by {last['energy'] / before['energy'] - 1.0:.1e}"


def _largest_error(cell, t_star):
    if cell.has_walls:
        return FLOWS[cell.flow].largest * (LEAST_ACROSS / cell.across) ** ORDER
    rate, order = ERROR[cell.scheme]
    return rate * max(t_star, 1.0) * (25 / cell.across) ** order
