"""What is said where particles have no room in the fields that are there for them."""

from tisph.errors import DivergedError


def clustered(what, step, time):
    """Return the DivergedError that there are too many of ``what`` in a step."""
    return DivergedError(f"x, y: too many {what}, at step {step}, t = {time:.6g}: the particles have clustered")
