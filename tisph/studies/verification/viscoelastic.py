"""Oldroyd-B fluids in the verification suite: start-up from rest, in which velocity and stress overshoot.

The base has Weissenberg number 1, by the wall's velocity, and a tenth of the viscosity from the solvent. Scheme
``auto`` takes the implicit one; the explicit one has rows of its own.
"""

from tisph.studies import flows
from tisph.studies.flows import across, jitter, merged, oldroyd_b
from tisph.studies.verification.criteria import at_most, closes, order, same_velocities, share, steps_at_most

FLOWS = {"oldroyd_b_couette": flows.OLDROYD_B_COUETTE, "oldroyd_b_poiseuille": flows.OLDROYD_B_POISEUILLE}

BOUNDS = {"l2": 1e-4, "shear_stress_l2": 3e-4, "normal_stress_l2": 3e-4, "wall_shear": 2e-4}
HIGH_BOUNDS = {"l2": 1e-5, "shear_stress_l2": 3e-5, "normal_stress_l2": 3e-5}
EXPLICIT_BOUNDS = {"l2": 2e-2, "shear_stress_l2": 2e-2, "normal_stress_l2": 4e-2, "wall_shear": 1e-2}

COARSE_BOUNDS = {**BOUNDS, "wall_shear": 2e-3}
"""25 across, where the layer of the jump is one spacing thick when the first wave has crossed a tenth of the gap."""

MOST_STEPS = 150
"""To two relaxation times."""

AUTO = {"scheme": {"type": "auto"}}
HIGH = {"scheme": {"type": "auto", "accuracy": "high"}}

SMOOTH = merged(HIGH, {"initial": {"state": "exact", "time": 0.5}, "time": {"tolerance": 1e-9}})
"""Start from the exact flow, whose first wave has crossed half of the gap, with steps that leave the error in space."""

SMOOTH_END = (0.8,)
RESOLUTIONS = (25, 50, 100)
ORDER, EXPLICIT_ORDER = 3.5, 1.7

VARIANTS = {
    "relaxation_0.1": oldroyd_b(relaxation_time=0.1),
    "relaxation_5": oldroyd_b(relaxation_time=5.0),
    "solvent_0.5": oldroyd_b(relaxation_time=0.2, solvent_fraction=0.5),
}

LITTLE_SOLVENT = oldroyd_b(solvent_fraction=0.01)
LITTLE_SAMPLES, LITTLE_BOUND = (0.5, 1.0, 2.0, 20.0), 2e-3

JITTER = 0.2
JITTER_SHARES = {"l2": 2.0, "shear_stress_l2": 2.0, "normal_stress_l2": 2.5}
"""Most that it may make of an error of the lattice. Of the normal stress it makes 2.1 times after the jump of a wall,
whose first moments particles off the lattice know less well."""

SHORT = (0.1,)
"""t*, long enough for a polymer to show."""


def runs(quick):
    """Configs by run name: a flow's own name for 50 across and ``auto``, and with what differs behind it.

    Quick ones are one flow of each scheme; driven flow by ``auto`` is in ``rheologies.py``.
    """
    if quick:
        return {
            "oldroyd_b_couette_25": flows.OLDROYD_B_COUETTE.at(AUTO, across(25), samples=(0.5, 1.0)),
            "oldroyd_b_poiseuille_explicit_25": flows.OLDROYD_B_POISEUILLE.at(across(25), samples=(0.5, 1.0)),
        }
    found = {}
    for name, flow in FLOWS.items():
        found |= {name: flow.at(AUTO), f"{name}_high": flow.at(HIGH), f"{name}_jitter": flow.at(AUTO, jitter(JITTER))}
        found |= {f"{name}_{variant}": flow.at(AUTO, change) for variant, change in VARIANTS.items()}
        found[f"{name}_solvent_0.01"] = flow.at(AUTO, LITTLE_SOLVENT, samples=LITTLE_SAMPLES)
        for number in RESOLUTIONS:
            found[f"{name}_smooth_{number}"] = merged(flow.at(across(number), samples=SMOOTH_END), SMOOTH)
        found |= {f"{name}_explicit": flow.at(), f"{name}_explicit_25": flow.at(across(25))}
    return found | _without_polymer()


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    if quick:
        return [
            *_quick("oldroyd_b_couette_25", COARSE_BOUNDS),
            *_quick("oldroyd_b_poiseuille_explicit_25", EXPLICIT_BOUNDS),
        ]
    found = [criterion for name, flow in FLOWS.items() for criterion in _full(name, flow)]
    return [*found, same_velocities("oldroyd_b_without_polymer", "newtonian", 1e-12)]


def _full(name, flow):
    found = [*_accuracy(name, flow.samples, BOUNDS), closes(name, 0.01), steps_at_most(name, MOST_STEPS, t_star=2.0)]
    found += _accuracy(f"{name}_high", flow.samples, HIGH_BOUNDS)
    found += [
        share(f"{name}_jitter", name, t_star, bound, quantity)
        for t_star in flow.samples
        for quantity, bound in JITTER_SHARES.items()
    ]
    for variant in VARIANTS:
        found += _accuracy(f"{name}_{variant}", flow.samples, BOUNDS)
    found += [at_most(f"{name}_solvent_0.01", t_star, "l2", LITTLE_BOUND) for t_star in LITTLE_SAMPLES]
    smooth = {f"{name}_smooth_{number}": number for number in RESOLUTIONS}
    found += [order(f"{name}_smooth", smooth, SMOOTH_END[0], ORDER, quantity) for quantity in HIGH_BOUNDS]
    return found + _explicit(name, flow)


def _explicit(name, flow):
    """What the explicit scheme is held to."""
    case = f"{name}_explicit"
    resolutions = {f"{case}_25": 25, case: 50}
    orders = [
        order(case, resolutions, t_star, EXPLICIT_ORDER, quantity)
        for quantity in ("l2", "shear_stress_l2")
        for t_star in flow.samples
    ]
    return [*_accuracy(case, flow.samples, EXPLICIT_BOUNDS), closes(case, 0.01), *orders]


def _quick(case, bounds):
    return [*_accuracy(case, (0.5, 1.0), bounds), closes(case, 0.01)]


def _accuracy(case, samples, bounds):
    """Bounds of velocity and stresses at every sample."""
    return [at_most(case, t_star, quantity, bound) for t_star in samples for quantity, bound in bounds.items()]


def _without_polymer():
    """The same fluid as an Oldroyd-B fluid whose viscosity is all the solvent's, and as a Newtonian one; explicit."""
    driven = flows.OLDROYD_B_POISEUILLE
    newtonian = merged(driven.config, across(25))
    newtonian["fluid"] = {"density": 1.0, "kinematic_viscosity": 1.0}
    return {
        "oldroyd_b_without_polymer": driven.at(across(25), oldroyd_b(solvent_fraction=1.0), samples=SHORT),
        "newtonian": flows.sampled(newtonian, SHORT),
    }
