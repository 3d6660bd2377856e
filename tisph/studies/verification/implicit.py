"""The implicit scheme in the verification suite: start-up Couette flow as in ``couette.py``, driven flow, extremes.

Bounds are about a third of the explicit scheme's errors early on and a hundredth later, at a hundredth of its steps.
"""

from tisph.studies import flows
from tisph.studies.flows import across, implicit, jitter, merged, sampled, treatment, walls
from tisph.studies.verification.couette import BASE, SHORT
from tisph.studies.verification.criteria import at_most, order, same_bits, steps_at_most

START_UP = {0.018: 5e-4, 0.027: 3e-4, 0.2: 3e-5}
"""L2 bounds by t*, on a lattice; half as much again with disorder."""

TREATMENTS = ("comoving_image", "virtual_image", "consistent_image")

FROM_EXACT = {"initial": {"state": "exact", "time": 1.0, "jitter": 0.2}}
CREEPING = {
    "fluid": {"density": 1000.0, "kinematic_viscosity": 1e-6},
    "geometry": {"gap": 1e-3, "length": 2e-3},
    "walls": {"top": {"velocity": 1.25e-5}},
}
"""Re = 0.0125: J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214-226, section 4.1."""

FAST = merged(jitter(0.2), {"fluid": {"kinematic_viscosity": 5e-4}})
"""Re = 1000, where a layer at t* = 0.01 is five spacings deep."""


def runs(quick):
    """Configs by run name; quick ones in a short channel."""
    times = tuple(START_UP)
    base = merged(BASE, SHORT if quick else {}, implicit(), treatment("consistent_image"))
    creeping = merged(CREEPING, {"geometry": {"length": 4e-4}} if quick else {})
    found = {
        "implicit": sampled(base, times),
        "implicit_jitter_0.2": sampled(merged(base, jitter(0.2)), (*times, 1.0)),
        "implicit_exact_25": sampled(merged(base, FROM_EXACT, across(25)), (0.018,)),
        "implicit_exact_50": sampled(merged(base, FROM_EXACT), (0.018,)),
        "implicit_poiseuille": flows.POISEUILLE.at(implicit(), jitter(0.2)),
        "implicit_creeping": sampled(merged(base, creeping), (1.0,)),
        "implicit_repeat": sampled(merged(base, jitter(0.2)), (*times, 1.0)),
    }
    if quick:
        return found
    found["implicit_jitter_0.1"] = sampled(merged(base, jitter(0.1)), (*times, 1.0))
    for name in TREATMENTS[:2]:
        found[f"implicit_{name}"] = sampled(merged(base, treatment(name), jitter(0.2)), times)
    for number in (25, 50, 100):
        change = merged(implicit(2), jitter(0.1), across(number))
        found[f"implicit_order_2_{number}"] = sampled(merged(base, change), (0.027,))
    found["implicit_re_1000"] = sampled(merged(base, FAST), (0.009, 0.1))
    found["implicit_two_walls"] = sampled(merged(base, jitter(0.2), walls(0.5, -0.5)), (0.2,))
    return found


def criteria(quick):
    """What the runs are held to."""
    found = [
        *_start_up("implicit", 1.0),
        steps_at_most("implicit", 150, t_star=0.027),
        *_start_up("implicit_jitter_0.2", 1.5),
        at_most("implicit_jitter_0.2", 1.0, "l2", 1e-6),
        *(at_most("implicit_jitter_0.2", t_star, "density_variation", 5e-3) for t_star in (0.2, 1.0)),
        at_most("implicit_exact_50", 0.018, "l2", 5e-6),
        order("implicit_exact_25/50", {"implicit_exact_25": 25, "implicit_exact_50": 50}, 0.018, 3.5),
        at_most("implicit_poiseuille", 0.1, "l2", 1e-5),
        at_most("implicit_creeping", 1.0, "l2", 1e-4),
        steps_at_most("implicit_creeping", 300, t_star=1.0),
        same_bits("implicit_repeat", "implicit_jitter_0.2"),
    ]
    if quick:
        return found
    resolutions = {f"implicit_order_2_{number}": number for number in (25, 50, 100)}
    return [
        *found,
        *_start_up("implicit_jitter_0.1", 1.5),
        at_most("implicit_jitter_0.1", 1.0, "l2", 1e-6),
        *(check for name in TREATMENTS[:2] for check in _start_up(f"implicit_{name}", 1.5)),
        order("implicit_order_2_25/50/100", resolutions, 0.027, 1.85),
        at_most("implicit_re_1000", 0.1, "l2", 1e-4),
        at_most("implicit_two_walls", 0.2, "l2", 3e-5),
    ]


def _start_up(case, factor):
    return [at_most(case, t_star, "l2", factor * bound) for t_star, bound in START_UP.items()]
