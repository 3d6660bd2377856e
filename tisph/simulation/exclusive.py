"""One simulation at a time in a process: Taichi has one program, and whoever starts another destroys its fields."""

import weakref

from tisph import runtime
from tisph.errors import TisphError

INSTEAD = "tisph.run has a process of its own for each run"

_open = None


def claim(simulation):
    """Let ``simulation`` have Taichi; TisphError where another simulation, or a program of somebody else, has it.

    A simulation that is finished, or that nobody holds any more, gives way; the finished one keeps its last state.
    """
    global _open
    other = _open() if _open else None
    if other is not None and other.finished:
        other.close()
    elif other is not None:
        raise TisphError(
            f"the simulation {other.config.name!r} is open, at t = {other.time:g}, and there can be one in a process: "
            f"end it with its close(), or use tisph.run: {INSTEAD}"
        )
    if runtime.foreign_program():
        raise TisphError(
            "another Taichi program is in this process, and its fields would be destroyed: call ti.reset() if they are "
            f"of no use any more, or use tisph.run: {INSTEAD}"
        )
    _open = weakref.ref(simulation)


def require(simulation):
    """Raise TisphError where there is nothing left of ``simulation`` to step."""
    if simulation.scheme is None:
        raise TisphError("the simulation is closed; its last state is all that is left of it")
    if runtime.program() is not simulation.program:
        raise TisphError("the fields of this simulation are gone: ti.init or ti.reset was called since it began")


def release(simulation):
    """Give Taichi back, if it is that of ``simulation``."""
    global _open
    if _open is not None and _open() is simulation:
        _open = None
        if not runtime.foreign_program():
            runtime.stop()
