"""Whose Taichi program is in this process: there is one at most, and whoever starts another ends it."""

from tisph.runtime._taichi import ti


def mark():
    """Let the program that was just started be known as one of this package."""
    ti.lang.impl.get_runtime().mark = object()


def program():
    """Return what tells the present program of this package from all others; None where there is none."""
    return getattr(ti.lang.impl.get_runtime(), "mark", None)


def foreign_program():
    """Tell whether there is a program that this package has not started."""
    runtime = vars(ti.lang.impl.get_runtime())
    running = runtime.get("prog", runtime.get("_prog"))  # the second is what Quadrants calls it
    return running is not None and program() is None
