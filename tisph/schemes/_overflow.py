"""The message where fields overflow: more particles, images or neighbours than they have space for."""

from tisph.errors import DivergedError


def clustered(what, step, time):
    """Return the DivergedError that there are too many of ``what`` in a step."""
    return DivergedError(f"x, y: too many {what}, at step {step}, t = {time:.6g}: the particles have clustered")
