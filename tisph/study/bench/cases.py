"""What ``tisph bench frontier`` runs: flows, and ways to compute them, as configs in plain dicts."""

from dataclasses import dataclass

from tisph.verification import flows

LENGTH = {"geometry": {"length": 2.0}}
"""That of the peers' case: two gaps."""

COUETTE = flows.merged(flows.COUETTE.config, LENGTH)
POISEUILLE = flows.merged(flows.POISEUILLE.config, LENGTH)

FLOWS = {
    "couette_2.7": ("Couette, Re = 50, t = 2.7", flows.merged(COUETTE, {"time": {"end": 2.7}})),
    "couette_20": ("Couette, Re = 50, t = 20", flows.merged(COUETTE, {"time": {"end": 20.0}})),
    "poiseuille_10": ("Poiseuille, t = 10", flows.merged(POISEUILLE, {"time": {"end": 10.0}})),
}
"""Title and config with a scheme that every way replaces, by key."""

EXPLICIT = {"scheme": {"type": "wcsph"}}
STANDARD = flows.merged(EXPLICIT, {"scheme": {"operators": "standard"}}, flows.treatment("adami"))
LONG_STEPS = flows.merged(EXPLICIT, {"time": {"cfl": 0.4}})
SECOND_ORDER = flows.merged(flows.implicit(order=2), {"scheme": {"largest_strain": 1.0}, "time": {"tolerance": 1e-4}})
SINGLE = {"discretisation": {"precision": "f32"}}


def auto(accuracy):
    """Change to the implicit scheme with steps of an accuracy."""
    return {"scheme": {"type": "auto", "accuracy": accuracy}}


WAYS = {
    "explicit": (EXPLICIT, (12, 25, 34, 50, 100)),
    "explicit, CFL 0.4": (LONG_STEPS, (25, 34, 50)),
    "explicit, f32": (flows.merged(EXPLICIT, SINGLE), (25, 50, 100)),
    "explicit, standard": (STANDARD, (25, 50, 100)),
    "implicit 4, fast": (auto("fast"), (6, 8, 10, 12, 16, 25)),
    "implicit 4, balanced": (auto("balanced"), (12, 25, 50, 100, 200)),
    "implicit 4, high": (auto("high"), (12, 25, 50, 100)),
    "implicit 4, f32": (flows.merged(auto("balanced"), SINGLE), (12, 25, 50, 100)),
    "implicit 2": (SECOND_ORDER, (25, 50, 100, 200)),
}
"""Change of the config, and the numbers of particles across, by the name of a way."""

FINEST_EXPLICIT = {"couette_2.7": 100, "couette_20": 50, "poiseuille_10": 50}
"""Most particles across with the explicit scheme: the next number takes half a minute or more, 200 several minutes."""

QUICK_WAYS = {
    "explicit": (EXPLICIT, (25, 34)),
    "implicit 4, fast": (auto("fast"), (8, 12)),
    "implicit 4, balanced": (auto("balanced"), (25, 50)),
}


@dataclass(frozen=True)
class Point:
    """One flow computed in one way: a point of the picture."""

    flow: str
    way: str
    across: int
    change: dict

    @property
    def name(self):
        """Name of its runs, less the number of the round."""
        way = "".join(letter if letter.isalnum() or letter == "." else "_" for letter in self.way)
        return f"{self.flow}_{way}_{self.across}"

    @property
    def config(self):
        """Its config."""
        return flows.merged(FLOWS[self.flow][1], self.change, flows.across(self.across))


def points(quick):
    """All points, flow by flow."""
    return [
        Point(flow, way, across, change)
        for flow in (["couette_2.7"] if quick else FLOWS)
        for way, (change, resolutions) in (QUICK_WAYS if quick else WAYS).items()
        for across in resolutions
        if not (way.startswith("explicit") and across > FINEST_EXPLICIT[flow])
    ]
