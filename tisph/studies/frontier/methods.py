"""Methods by which flows of ``tisph bench frontier`` are computed: changes of a config, and particles across."""

from tisph.studies import flows

EXPLICIT = {"scheme": {"type": "wcsph"}}
STANDARD = flows.merged(EXPLICIT, {"scheme": {"operators": "standard"}}, flows.treatment("adami"))
LONG_STEPS = flows.merged(EXPLICIT, {"time": {"cfl": 0.4}})
SECOND_ORDER = flows.merged(flows.implicit(order=2), {"scheme": {"largest_strain": 1.0}, "time": {"tolerance": 1e-4}})
SINGLE = {"discretisation": {"precision": "f32"}}


def auto(accuracy):
    """Change to the implicit scheme with steps of an accuracy."""
    return {"scheme": {"type": "auto", "accuracy": accuracy}}


def implicit(**resolutions):
    """Methods of order 4 with steps of each accuracy, and the numbers of particles across."""
    return {f"implicit 4, {accuracy}": (auto(accuracy), across) for accuracy, across in resolutions.items()}


METHODS = {
    "explicit": (EXPLICIT, (12, 25, 34, 50, 100)),
    "explicit, CFL 0.4": (LONG_STEPS, (25, 34, 50)),
    "explicit, f32": (flows.merged(EXPLICIT, SINGLE), (25, 50, 100)),
    "explicit, standard": (STANDARD, (25, 50, 100)),
    **implicit(fast=(6, 8, 10, 12, 16, 25), balanced=(12, 25, 50, 100, 200), high=(12, 25, 50, 100)),
    "implicit 4, f32": (flows.merged(auto("balanced"), SINGLE), (12, 25, 50, 100)),
    "implicit 2": (SECOND_ORDER, (25, 50, 100, 200)),
}
"""Change of the config, and the numbers of particles across, by the name of a method."""

QUICK_METHODS = {"explicit": (EXPLICIT, (25, 34)), **implicit(fast=(8, 12), balanced=(25, 50))}

POLYMER_METHODS = {
    "explicit": (EXPLICIT, (12, 25, 50)),
    **implicit(fast=(10, 12, 16, 25), balanced=(12, 25, 50), high=(25, 50)),
}
QUICK_POLYMER_METHODS = {"explicit": (EXPLICIT, (25,)), **implicit(fast=(10, 12), balanced=(12, 25))}

COURANT_1 = {"scheme": {"type": "implicit"}, "time": {"cfl": 1.0}}

VORTEX_METHODS = {
    "explicit": (EXPLICIT, (25, 50)),
    "implicit 4, CFL 1": (COURANT_1, (16, 20, 25, 50)),
    **implicit(fast=(12, 16, 25, 50, 100), balanced=(25, 50, 100), high=(25, 50, 100)),
}
QUICK_VORTEX_METHODS = {
    "explicit": (EXPLICIT, (25,)),
    "implicit 4, CFL 1": (COURANT_1, (16, 20)),
    **implicit(fast=(12, 25), balanced=(25, 50)),
}

COARSE = (10, 12, 16, 25)
WALL_METHODS = implicit(fast=COARSE, balanced=(12, 25, 50), high=(25,))
QUICK_WALL_METHODS = implicit(fast=(10, 12), balanced=(12, 16))

CYLINDER_METHODS = implicit(fast=(10, 12, 16), balanced=(12, 16, 25))
"""Of a fluid with polymer, which the explicit scheme does not serve between cylinders."""

BODY_METHODS = implicit(fast=(12, 16, 20), balanced=(12, 20, 40), high=(20,))
"""The period, half as long again, has at least 18 particles."""

QUICK_BODY_METHODS = implicit(fast=(12, 16), balanced=(12, 20))
