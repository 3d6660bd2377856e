"""What a run is held to where the flow turns: an even spread of the particles, no gain of energy, and a small error."""

HOLE, NEAREST = 1.15, 0.55
"""Radius of the largest hole in a stable run, and the least distance of two particles, in spacings."""

GAIN = 1e-3
"""Part by which the kinetic energy, which is only lost, may exceed that of a quarter of the run before: so much does a
mean over particles that are spread unevenly scatter."""

ERROR = {"explicit": (1e-2, 2), "implicit 4": (1e-3, 3)}
"""By scheme: what 25 particles across may err by in every length over speed of the start, in root mean square over that
speed, and the order in the spacing with which it has to fall. For comparison: PySPH's EDAC has 1.5e-2 at t* = 0.5."""


def look(cell, sample):
    """Return of a sample what is judged."""
    return {
        "error": sample[cell.measure] if cell.measure else None,
        "density_variation": sample["density_variation"],
        "hole": sample["largest_hole"],
        "nearest": sample["nearest_two"],
        "energy": sample["kinetic_energy"],
    }


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
    if last["energy"] > before["energy"] * (1.0 + GAIN):
        yield f"energy grows by {last['energy'] / before['energy'] - 1.0:.1e}"


def _largest_error(cell, t_star):
    rate, order = ERROR[cell.scheme]
    return rate * max(t_star, 1.0) * (25 / cell.across) ** order
