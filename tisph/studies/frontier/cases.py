"""What ``tisph bench frontier`` runs: flows, and methods to compute them, as configs in plain dicts."""

from collections.abc import Callable
from dataclasses import dataclass

from tisph.exact import cavity
from tisph.studies import flows
from tisph.studies.frontier.methods import (
    BODY_METHODS,
    CYLINDER_METHODS,
    METHODS,
    POLYMER_METHODS,
    QUICK_BODY_METHODS,
    QUICK_METHODS,
    QUICK_POLYMER_METHODS,
    QUICK_VORTEX_METHODS,
    QUICK_WALL_METHODS,
    VORTEX_METHODS,
    WALL_METHODS,
)
from tisph.studies.suites import config_of

LENGTH = {"geometry": {"length": 2.0}}
"""That of the peers' case: two gaps."""

COUETTE = flows.merged(flows.COUETTE.config, LENGTH)
POISEUILLE = flows.merged(flows.POISEUILLE.config, LENGTH)

SERIAL = {"runtime": {"threads": 1}, "time": {"samples": None}}

VORTEX = flows.merged(config_of("two_dimensional", "taylor_green"), SERIAL)
"""On one thread, as its peers."""

MORRIS_RESISTANCE = 106.812
"""Drag on a cylinder in a channel over dynamic viscosity and superficial velocity (suites/bodies.yaml)."""

PIPE, SPIN_UP = (
    flows.merged(config_of("axisymmetric", name), {"geometry": {"length": 1.5}}, SERIAL)
    for name in ("pipe_20", "spin_up_20")
)
"""Of a radius and a viscosity of 1."""


def ended(config, time):
    """The config with an end."""
    return flows.merged(config, {"time": {"end": time}})


def l2(sample):
    """The relative L2 error of the velocity; NaN where a ``sample`` of a summary has none."""
    return sample["l2"] if sample["l2"] is not None else float("nan")


def largest_error(sample):
    """The largest of the relative L2 errors of the velocity, the shear stress and the normal stress difference."""
    return max(sample[name] for name in ("l2", "shear_stress_l2", "normal_stress_l2"))


def torque(sample):
    """The larger one of the relative errors of the velocity (L2) and the torque on the inner cylinder."""
    return max(sample["l2"], abs(sample["torque_inner"] / sample["torque_inner_exact"] - 1.0))


def extremes(sample):
    """Largest error of the extremes on the centre lines of the cavity at Re = 100, over what they should be."""
    known = cavity.extremes(100.0)
    names = {"u_extreme": "u_min", "v_min": "v_min", "v_max": "v_max"}
    return max(abs(sample[ours] / known[theirs] - 1.0) for ours, theirs in names.items())


def resistance(sample, viscosity=10.0):
    """Error of the drag of a cylinder in a channel over dynamic ``viscosity`` and superficial velocity."""
    return abs(sample["drag"] / (viscosity * sample["superficial_velocity"]) / MORRIS_RESISTANCE - 1.0)


@dataclass(frozen=True)
class Bound:
    """What is asked of the runs of a peer whose label begins with ``peer``, ``across`` particles across (None: any).

    ``speedup``: least ratio of its loop time to that of our fastest run with an error no larger. ``accuracy_ratio``:
    least ratio of its error to that of our run with as many particles, which has to be the faster one, too; None: not
    asked.
    """

    peer: str
    speedup: float
    across: int | None = None
    accuracy_ratio: float | None = None

    def of(self, row):
        """Whether it is asked of the peer's ``row`` (``Measured``)."""
        return row.method.startswith(self.peer) and self.across in (None, row.across)


@dataclass(frozen=True)
class Benchmark:
    """A flow: title, config less what a method changes, and ``methods``; ``quick_methods`` in a quick benchmark.

    ``group``: what it is shown with. ``error``: of the last sample of a run, which ``Measured.l2`` holds.

    ``finest_explicit``: most particles across with the explicit scheme, the next number takes half a minute or more.
    ``target_error``: at which the explicit and the implicit scheme are compared; ``at_explicit_errors``: whether they
    are at the error of each explicit run instead. ``bounds``: what is asked of peers; others are not judged.
    ``equal_resolution_method``: its runs are compared with peers with as many particles.
    """

    title: str
    config: dict
    methods: dict
    quick_methods: dict
    finest_explicit: int = 50
    group: str = "channel"
    error: Callable = l2
    target_error: float | None = None
    at_explicit_errors: bool = False
    bounds: tuple[Bound, ...] = ()
    equal_resolution_method: str | None = None

    def bound(self, row):
        """``Bound`` of a peer's row; None where nothing is asked for, as of one that is quoted."""
        return next((bound for bound in self.bounds if bound.of(row)), None) if not row.quoted else None


SLOWER = (Bound("LAMMPS", 10.0), Bound("PySPH", 100.0))

BENCHMARKS = {
    "couette_2.7": Benchmark(
        "Couette, Re = 50, t = 2.7", ended(COUETTE, 2.7), METHODS, QUICK_METHODS, 100, target_error=1e-3, bounds=SLOWER
    ),
    "couette_20": Benchmark(
        "Couette, Re = 50, t = 20", ended(COUETTE, 20.0), METHODS, {}, 50, target_error=1e-4, bounds=SLOWER
    ),
    "poiseuille_10": Benchmark("Poiseuille, t = 10", ended(POISEUILLE, 10.0), METHODS, {}, 50),
    "oldroyd_b_couette": Benchmark(
        "Oldroyd-B Couette, t = 2: u, S_xy, N1",
        flows.merged(flows.OLDROYD_B_COUETTE.at(LENGTH), SERIAL),
        POLYMER_METHODS,
        QUICK_POLYMER_METHODS,
        group="oldroyd_b",
        error=largest_error,
        at_explicit_errors=True,
    ),
    "oldroyd_b_poiseuille": Benchmark(
        "Oldroyd-B Poiseuille, t = 2: u, S_xy, N1",
        flows.merged(flows.OLDROYD_B_POISEUILLE.at(LENGTH), SERIAL),
        POLYMER_METHODS,
        {},
        group="oldroyd_b",
        error=largest_error,
        at_explicit_errors=True,
    ),
    "oldroyd_b_cylinders": Benchmark(
        "Oldroyd-B, cylinders, t = 1: u, torque",
        ended(flows.merged(config_of("two_dimensional_polymers", "oldroyd_b_annulus_25"), SERIAL), 1.0),
        CYLINDER_METHODS,
        {},
        group="oldroyd_b",
        error=torque,
    ),
    "taylor_green_2": Benchmark(
        "Taylor-Green vortex, Re = 100, t = 2",
        ended(VORTEX, 2.0),
        VORTEX_METHODS,
        QUICK_VORTEX_METHODS,
        group="taylor_green",
        bounds=(Bound("PySPH EDAC", 500.0, across=50, accuracy_ratio=200.0),),
        equal_resolution_method="implicit 4, balanced",
    ),
    "circular_couette_2": Benchmark(
        "Circular Couette start-up, Re = 50, t = 2",
        ended(flows.merged(config_of("circular_couette", "annulus_25_start"), SERIAL), 2.0),
        WALL_METHODS,
        QUICK_WALL_METHODS,
        group="circular_couette",
    ),
    "cavity_10": Benchmark(
        "Cavity, Re = 100, t = 10: extremes",
        ended(flows.merged(config_of("cavity", "cavity_25"), SERIAL), 10.0),
        WALL_METHODS,
        QUICK_WALL_METHODS,
        group="cavity",
        error=extremes,
        bounds=(Bound("PySPH", 100.0),),
    ),
    "cylinder": Benchmark(
        "Cylinders in a channel: drag",
        flows.merged(config_of("bodies", "morris"), SERIAL),
        BODY_METHODS,
        QUICK_BODY_METHODS,
        group="cylinder",
        error=resistance,
    ),
    **{
        f"{name}_{end:g}": Benchmark(f"{title}, t = {end:g}", ended(config, end), BODY_METHODS, methods, group="pipe")
        for name, title, config, end, methods in (
            ("pipe", "Pipe (published: 0.7 to 3 %)", PIPE, 0.05, QUICK_BODY_METHODS),
            ("pipe", "Pipe (published: 0.7 to 3 %)", PIPE, 0.2, {}),
            ("spin_up", "Spin-up in a pipe", SPIN_UP, 0.2, {}),
        )
    },
}
"""Every flow by its key."""

GROUPS = tuple(dict.fromkeys(flow.group for flow in BENCHMARKS.values()))
"""Names of their groups, each of which is a picture of its own."""


@dataclass(frozen=True)
class Point:
    """One flow computed by one method: a point of the picture."""

    flow: str
    method: str
    across: int
    change: dict

    @property
    def name(self):
        """Name of its runs, less the number of the round."""
        method = "".join(letter if letter.isalnum() or letter == "." else "_" for letter in self.method)
        return f"{self.flow}_{method}_{self.across}"

    @property
    def config(self):
        """Its config."""
        return flows.merged(BENCHMARKS[self.flow].config, self.change, flows.across(self.across))


def points(group, quick):
    """All points of a group, flow by flow."""
    return [
        Point(key, method, across, change)
        for key, flow in BENCHMARKS.items()
        if flow.group == group
        for method, (change, resolutions) in (flow.quick_methods if quick else flow.methods).items()
        for across in resolutions
        if not (method.startswith("explicit") and across > flow.finest_explicit)
    ]
