"""Which cells there are: the full sub-matrices that matter, and a covering set of all axes."""

from functools import cache

from tisph.equation_of_state import SCALE_RATIO
from tisph.studies.stability import crossing
from tisph.studies.stability.cells import SCHEMES, Cell
from tisph.studies.stability.covering import covering_set
from tisph.studies.stability.crossing import TURNING
from tisph.studies.stability.flows import FAR, FLOWS, digits
from tisph.studies.stability.grids import BOTH, SubMatrix, exists, grid

REYNOLDS = (0.0125, 1.0, 50.0, 500.0, 1000.0, 10000.0)
JITTERS = (0.0, 0.1, 0.3)
TREATMENTS = ("consistent_image", "comoving_image", "virtual_image", "fixed_image", "adami")
STEPS = (1.0, 1.5, 2.0, 3.0, 4.0)
SOUNDS = (5.0, SCALE_RATIO, 40.0)

FLOW_THROUGHS = 200
"""Lengths of the channel that something at the reference velocity goes in a long run."""

POLYMERS = tuple(name for name in FLOWS if Cell(flow=name).has_polymer)
EXPLICIT_POLYMERS = tuple(name for name in POLYMERS if Cell(flow=name).weissenberg not in FAR)

ELASTICITIES = (1e-3, 1e-2, 0.1, 1.0, 1e3)
"""At 1e-2 and below, 16 across, polymer answers a jump before the layer of the solvent is a spacing deep
(docs/implicit.md, limits)."""

LARGEST_REYNOLDS = 1000.0
"""Of these: steps, which go with the strain, are about as many as the Reynolds number, and a cell has not that long."""

WAVES = 3
"""Times that an elastic wave crosses the gap: it takes sqrt(E) viscous times, E the elasticity number."""

AXES = {
    "flow": tuple(name for name in FLOWS if not Cell(flow=name).crosses and Cell(flow=name).weissenberg not in FAR),
    "reynolds": REYNOLDS,
    "jitter": (0.1, 0.0, 0.3),
    "across": (25, 8, 50),
    "scheme": tuple(SCHEMES),
    "treatment": TREATMENTS,
    "step": (1.0, 1.5, 2.0),
    "sound": (SCALE_RATIO, 5.0, 40.0),
    "precision": ("f64", "f32"),
    "aspect": (2.0, 0.5, 10.0),
}
"""Values of every axis of the covering set, of channels; where it is free to choose it takes the first."""


def sub_matrices(quick=False, only=None):
    """All sub-matrices, or a few short cells of every kind, in a fixed order; cells may be in several of them.

    ``only``: those with this text in their title; ValueError where there is none.
    """
    parts = _quick() if quick else _full()
    chosen = [part for part in parts if only is None or only in part.title]
    if not chosen:
        titles = ", ".join(part.title for part in parts)
        raise ValueError(f"no sub-matrix has {only!r} in its title; there are {titles}")
    return chosen


def cells(chosen):
    """Every cell of sub-matrices once, each after the calm cell that it is compared with."""
    return list(dict.fromkeys(each for part in chosen for cell in part.cells for each in (cell.calm, cell)))


def covered(values):
    """Whether the covering set has these values together; liquids with memory have sub-matrices of their own."""
    memory = values.get("flow") in POLYMERS and values.get("scheme", "explicit") != "explicit"
    return exists(values) and not memory


@cache  # the covering set is a second of work
def _full():
    every = {"reynolds": REYNOLDS, "jitter": JITTERS, "scheme": SCHEMES}
    two = {"jitter": (0.0, 0.3), "scheme": BOTH}
    re, rows = ("reynolds",), ("scheme", "jitter")
    return [
        SubMatrix("Re x jitter x scheme, Couette", grid(**every), re, rows),
        SubMatrix("Re x jitter x scheme, Poiseuille", grid(flow=["poiseuille"], aspect=[1.0], **every), re, rows),
        SubMatrix("Re x resolution", grid(reynolds=REYNOLDS[2:], across=(8, 25, 50), **two), re, ("across", *rows)),
        SubMatrix("explicit steps", grid(jitter=JITTERS, step=STEPS, sound=SOUNDS), ("step",), ("sound", "jitter")),
        SubMatrix("implicit steps", grid(jitter=JITTERS, step=STEPS, scheme=list(SCHEMES)[1:]), ("step",), rows),
        SubMatrix("single precision", grid(reynolds=REYNOLDS, precision=["f32"], **two), re, rows),
        SubMatrix(
            "wall treatments",
            grid(reynolds=(50.0, 1000.0), treatment=TREATMENTS, **two),
            ("treatment",),
            ("reynolds", *rows),
        ),
        SubMatrix(
            "Oldroyd-B", grid(flow=EXPLICIT_POLYMERS, reynolds=REYNOLDS[:3], jitter=JITTERS), re, ("flow", "jitter")
        ),
        SubMatrix("long runs", _long_runs(), ("flow", "reynolds", "t_star"), rows),
        SubMatrix("covering set", tuple(Cell(**row) for row in covering_set(AXES, covered))),
        *_polymer(),
        *crossing.turning(),
        *crossing.walls(),
        crossing.memory(),
        crossing.refused(),
    ]


def _polymer():
    """Oldroyd-B liquids with the implicit scheme: every Weissenberg and elasticity number, solvent fraction, order."""
    title, rough, slow = "Oldroyd-B, implicit:", {"reynolds": [1.0], "jitter": [0.3]}, {"flow": ["oldroyd1"]}
    two, implicit = {"flow": ("oldroyd1", "oldroyd10"), "reynolds": [1.0]}, {"scheme": ["implicit 4"]}
    little = grid(**two, jitter=(0.0, 0.3), across=[16], solvent=(0.5, 0.1, 0.01), **implicit)
    coarse = grid(**slow, **rough, across=(8, 12, 16, 50), **implicit)
    steps = grid(**slow, **rough, across=[16], step=(1.0, 4.0), scheme=list(SCHEMES)[1:])
    waves = tuple(_wave(flow, elasticity) for elasticity in ELASTICITIES for flow in POLYMERS)
    waves = tuple(cell for cell in waves if cell.reynolds <= LARGEST_REYNOLDS)
    return [
        SubMatrix(f"{title} Wi x elasticity", waves, ("flow",), ("elasticity",)),
        SubMatrix(f"{title} solvent x jitter", little, ("solvent",), ("flow", "jitter")),
        SubMatrix(f"{title} resolution", coarse, ("across",), ("flow",)),
        SubMatrix(f"{title} steps x order", steps, ("step",), ("scheme",)),
    ]


def _wave(flow, elasticity):
    """Return the cell of a flow in which waves cross the gap ``WAVES`` times."""
    reynolds = digits(Cell(flow=flow).weissenberg / elasticity)
    return Cell(flow, reynolds, 0.3, 16, "implicit 4", t_star=max(1.0, round(WAVES * elasticity**0.5)))


def _long_runs():
    """To t* = 2, and as many lengths of the channel as ``FLOW_THROUGHS``, which at Re = 1000 t* = 1 has anyway."""
    through = FLOW_THROUGHS * Cell().aspect / 50.0
    ends = [("couette", 1.0, 2.0), ("couette", 50.0, through), ("poiseuille", 1.0, 2.0), ("poiseuille", 50.0, 2.0)]
    axes = {"jitter": (0.0, 0.1), "scheme": SCHEMES}
    return tuple(
        cell for flow, re, t_star in ends for cell in grid(flow=[flow], reynolds=[re], t_star=[t_star], **axes)
    )


def _quick():
    re, rows = ("reynolds", "t_star"), ("scheme", "jitter")
    slow = grid(reynolds=(1.0, 50.0), jitter=JITTERS, scheme=BOTH)
    fast = {"reynolds": [1000.0], "jitter": JITTERS, "t_star": [0.01], "scheme": BOTH}
    two = {"jitter": (0.0, 0.3)}
    return [
        SubMatrix("Re x jitter x scheme, Couette", slow + grid(**fast), re, rows),
        SubMatrix("Re x jitter x scheme, Poiseuille", grid(flow=["poiseuille"], **fast), re, rows),
        SubMatrix(
            "Re x resolution",
            grid(reynolds=[1000.0], across=(8, 25), jitter=JITTERS, t_star=[0.01]),
            re,
            ("across", "jitter"),
        ),
        SubMatrix("explicit steps", grid(**two, step=(1.5, 2.0), t_star=[0.25]), ("step",), ("jitter",)),
        SubMatrix("implicit steps", grid(**two, step=(1.5, 2.0), scheme=list(SCHEMES)[1:]), ("step",), rows),
        SubMatrix("single precision", grid(**two, precision=["f32"], scheme=BOTH, t_star=[0.25]), re, rows),
        SubMatrix(
            "Oldroyd-B", grid(flow=["oldroyd1"], reynolds=[1.0], scheme=BOTH, **two), re, ("flow", "scheme", "jitter")
        ),
        SubMatrix(
            "flow that turns",
            grid(flow=TURNING, reynolds=[1000.0], jitter=[0.3], t_star=[0.5], scheme=["implicit 4"])
            + grid(flow=TURNING[:1], reynolds=[1000.0], jitter=[0.3], t_star=[0.5]),
            re,
            ("flow", "scheme"),
        ),
        SubMatrix(
            "walls: of any shape",
            grid(flow=["annulus0.5"], across=[12], jitter=[0.3], t_star=[0.5], scheme=["implicit 4"])
            + grid(flow=["cylinder2"], across=[16], jitter=[0.3], t_star=[0.2], scheme=["implicit 4"]),
            re,
            ("flow",),
        ),
        crossing.refused(),
    ]
