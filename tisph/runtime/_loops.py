"""What a kernel says about its loops beside what Taichi has for it."""

from tisph.runtime._taichi import ti


@ti.func
def unrolled(number):
    """Return ``number``; of ``for k in range(unrolled(number))`` the compiler may make several iterations one."""
    return number
