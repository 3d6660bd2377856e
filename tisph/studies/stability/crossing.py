"""Sub-matrices of flows in which particles cross each other's ways: that turn, between walls of any shape."""

from tisph.studies.stability.flows import FLOWS
from tisph.studies.stability.grids import BOTH, SubMatrix, grid

TURNING = tuple(name for name, flow in FLOWS.items() if flow.turns and not flow.memory)
"""Flows that turn, in a periodic square."""

MEMORY = tuple(name for name, flow in FLOWS.items() if flow.memory)
"""Flows of liquids with polymer that are no channel's."""

COURANTS = (1 / 6, 1.0, 10 / 3)
"""Steps between walls of any shape: Courant numbers 0.05, the default and 1."""


def turning():
    """Two turns of the vortices or a layer that has rolled up, and twenty.

    At a Reynolds number of 10000 layers are thinner than a spacing, and an implicit run takes minutes: there is one.
    """
    vortices, layers = TURNING
    short, long, implicit = {"t_star": [2.0]}, {"t_star": [20.0]}, {"scheme": ["implicit 4"]}
    middle, disorder, rows = (100.0, 1000.0), {"jitter": [0.3]}, ("flow", "scheme")
    every = {"jitter": (0.0, 0.3), "scheme": BOTH, **short}
    fast = {"reynolds": [10000.0]}
    return [
        SubMatrix(
            "flow that turns: Re x jitter x scheme",
            grid(flow=TURNING, reynolds=(1.0, *middle), **every)
            + grid(flow=[vortices], **fast, **every)
            + grid(flow=[layers], **fast, jitter=every["jitter"], **short)
            + grid(flow=[layers], **fast, **short, **implicit),
            ("reynolds",),
            (*rows, "jitter"),
        ),
        SubMatrix(
            "flow that turns: Re x resolution",
            grid(flow=[vortices], reynolds=middle, across=(12, 25, 50), **disorder, **short, **implicit)
            + grid(flow=[layers], reynolds=middle, across=(25, 50), **disorder, **short, **implicit),
            ("reynolds",),
            (*rows, "across"),
        ),
        SubMatrix(
            "flow that turns: steps",
            grid(flow=TURNING, reynolds=middle, step=(0.25, 1.0, 2.0, 3.0), **disorder, **short, **implicit),
            ("step",),
            (*rows, "reynolds"),
        ),
        SubMatrix(
            "flow that turns: long runs",
            grid(flow=TURNING, reynolds=middle, scheme=BOTH, **disorder, **long)
            + grid(flow=[vortices], **fast, **disorder, **long, **implicit)
            + grid(flow=[vortices], reynolds=(*middle, *fast["reynolds"]), **long, **implicit),
            ("reynolds", "t_star"),
            (*rows, "jitter"),
        ),
    ]


def walls():
    """Three lengths over speed between cylinders, twenty in cavities, two around bodies, which at Re = 1 get steady."""
    annuli, lids, bodies = ("annulus0.2", "annulus0.5"), ("regular_lid", "sharp_lid"), ("cylinder2", "cylinder5")
    rough = {"jitter": [0.3], "scheme": ["implicit 4"]}
    few, more, short = {"across": [12]}, {"across": [16]}, {"t_star": [3.0]}
    slow, middle, fast = ({"reynolds": [reynolds]} for reynolds in (1.0, 100.0, 1000.0))
    re, rows = ("reynolds",), ("flow", "across", "jitter")
    even = {"jitter": [0.0], "scheme": ["implicit 4"]}
    return [
        SubMatrix(
            "walls: radius ratio x Re",
            grid(flow=annuli, reynolds=(1.0, 100.0), **few, **rough, **short)
            + grid(flow=annuli[1:], **fast, **few, **rough, **short)
            + grid(flow=annuli[1:], **middle, **more, **rough, **short)
            + grid(flow=annuli[1:], **middle, **few, **even, **short)
            + grid(flow=["annulus0.9"], **middle, **few, **rough, t_star=[1.0]),
            re,
            rows,
        ),
        SubMatrix(
            "walls: cavities",
            grid(flow=lids, **slow, **few, **rough, t_star=[2.0])
            + grid(flow=lids, **middle, **few, **rough, t_star=[20.0])
            + grid(flow=lids, **fast, **few, **rough, t_star=[20.0]),
            re,
            rows,
        ),
        SubMatrix(
            "walls: gap at a body",
            grid(flow=("cylinder1.5", *bodies), reynolds=(1.0, 100.0), **more, **rough, t_star=[2.0]),
            re,
            rows,
        ),
        SubMatrix(
            "walls: steps",
            grid(flow=("annulus0.5", "sharp_lid"), **middle, **few, step=COURANTS, **rough, **short)
            + grid(flow=bodies[:1], **middle, **more, step=COURANTS, **rough, t_star=[2.0]),
            ("step",),
            ("flow",),
        ),
    ]


def memory():
    """Five lengths over speed between cylinders from rest, two in a cavity, one of layers that roll up."""
    *annuli, lid, layer = MEMORY
    both = {"jitter": (0.0, 0.3), "scheme": ["implicit 4"]}
    few, slow = {"across": [12]}, {"reynolds": [1.0]}
    return SubMatrix(
        "polymer in two dimensions",
        grid(flow=annuli, **slow, **few, **both, t_star=[5.0])
        + grid(flow=[lid], **slow, **few, **both, t_star=[2.0])
        + grid(flow=[layer], reynolds=[100.0], **both, t_star=[1.0]),
        ("jitter",),
        ("flow", "t_star"),
    )


def refused():
    """What cannot be had: order 2 where the flow turns."""
    return SubMatrix("refused", grid(flow=TURNING, scheme=["implicit 2"]), ("scheme",), ("flow",))
