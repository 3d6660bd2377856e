"""What ``tisph bench frontier`` runs: flows, and ways to compute them, as configs in plain dicts."""

from dataclasses import dataclass

from tisph.verification.flows import merged

COUETTE = {
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 2.0},
    "walls": {"top": {"velocity": 0.5}},
}
POISEUILLE = merged(COUETTE, {"walls": {"top": {"velocity": 0.0}}, "drive": {"acceleration": 0.02}})

FLOWS = {
    "couette_2.7": ("Couette, Re = 50, t = 2.7", merged(COUETTE, {"time": {"end": 2.7}})),
    "couette_20": ("Couette, Re = 50, t = 20", merged(COUETTE, {"time": {"end": 20.0}})),
    "poiseuille_10": ("Poiseuille, t = 10", merged(POISEUILLE, {"time": {"end": 10.0}})),
}
"""Title and config without a scheme, by key."""

EXPLICIT = {"scheme": {"type": "wcsph"}}
STANDARD = {"scheme": {"type": "wcsph", "operators": "standard"}, "walls": {"treatment": {"type": "adami"}}}
SINGLE = {"discretisation": {"precision": "f32"}}


def auto(accuracy):
    """Change to the implicit scheme with steps of an accuracy."""
    return {"scheme": {"type": "auto", "accuracy": accuracy}}


SECOND_ORDER = {"scheme": {"type": "implicit", "operators": {"order": 2}, "largest_strain": 1.0}}

WAYS = {
    "explicit": (EXPLICIT, (25, 34, 50, 100)),
    "explicit, CFL 0.4": (merged(EXPLICIT, {"time": {"cfl": 0.4}}), (34,)),
    "explicit, f32": (merged(EXPLICIT, SINGLE), (50,)),
    "explicit, standard": (STANDARD, (25, 50)),
    "implicit 4, fast": (auto("fast"), (10, 12, 16, 25)),
    "implicit 4, balanced": (auto("balanced"), (12, 25, 50, 100)),
    "implicit 4, high": (auto("high"), (25, 50, 100)),
    "implicit 4, f32": (merged(auto("balanced"), SINGLE), (50,)),
    "implicit 2": (merged(SECOND_ORDER, {"time": {"tolerance": 1e-4}}), (50, 100)),
}
"""Change of the config, and the numbers of particles across, by the name of a way."""

QUICK_WAYS = {
    "explicit": (EXPLICIT, (25, 34)),
    "implicit 4, fast": (auto("fast"), (12,)),
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
        return merged(FLOWS[self.flow][1], self.change, {"discretisation": {"particles_across": self.across}})


def points(quick):
    """All points, flow by flow."""
    ways = QUICK_WAYS if quick else WAYS
    flows = ["couette_2.7"] if quick else FLOWS
    return [
        Point(flow, way, across, change)
        for flow in flows
        for way, (change, resolutions) in ways.items()
        for across in resolutions
        if not (flow != "couette_2.7" and way.startswith("explicit") and across > 50)  # a minute each
    ]
