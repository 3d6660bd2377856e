"""tisph: a Taichi particle simulator (SPH) for laminar, wall-bounded flow.

    import tisph

    print(tisph.check("couette.yaml"))                      # size, steps and errors of the run
    results = tisph.run("couette.yaml", **{"time.end": 2.7})    # into runs/couette
    results = tisph.open("runs/couette")                    # again, without running
    results.summary.samples[-1].l2                          # error against the exact solution
    results.samples[-1]["u"], results.history.to_pandas()   # arrays, in the units of the config
    with tisph.Simulation("couette.yaml") as simulation:    # in this process, step by step; nothing is written
        for state in simulation.every(0.5):
            state.t, state.x, state.u, state.error

In a notebook ``results`` on a line of its own shows movie, plots and errors. Failures raise an exception of
``tisph.errors``. docs/tutorials/ are the tour, docs/reference/files.md defines each number.
"""

from typing import TYPE_CHECKING, Any

from tisph.version import __version__ as __version__  # isort: skip (it notes when the process began)
from tisph import errors as errors

if TYPE_CHECKING:
    from tisph.interface import check, fit, run, sweep
    from tisph.observers.protocol import every
    from tisph.results import Results
    from tisph.results import open_run as open
    from tisph.simulation.simulation import Simulation

__all__ = ["Results", "Simulation", "check", "every", "fit", "open", "run", "sweep"]

_PLACES = {
    "run": ("tisph.interface", "run"),
    "check": ("tisph.interface", "check"),
    "sweep": ("tisph.interface", "sweep"),
    "fit": ("tisph.interface", "fit"),
    "open": ("tisph.results", "open_run"),
    "Results": ("tisph.results", "Results"),
    "Simulation": ("tisph.simulation.simulation", "Simulation"),
    "every": ("tisph.observers.protocol", "every"),
}
"""Public name -> module and name in it. It is imported at its first use, so that commands start quickly."""


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'tisph' has no attribute {name!r}")
    from importlib import import_module

    place, there = _PLACES[name]
    value = globals()[name] = getattr(import_module(place), there)
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__", "errors"]
