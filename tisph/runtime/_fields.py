"""Fields as the host sees them: numbers that they start with, and their memory.

Taichi compiles a kernel for each field that is filled, copied from or to an array, or read by one value: a tenth of a
second each at first, and a third of that when found in the cache. Here nothing is compiled but what finds the address.
"""

import ctypes
from math import prod

import numpy as np

from tisph.runtime._taichi import ti

_real = None
_program = 0


def begin(precision):
    """Begin with a new program: fields that there were are gone."""
    global _real, _program
    _real = {"f64": ti.f64, "f32": ti.f32}[precision]
    _program += 1


def real():
    """Return the floating-point type chosen at the start."""
    return _real


def holding(field, values):
    """Return ``field``, which holds ``values`` before any kernel sees it."""
    fill(field, values)
    return field


def fill(field, values):
    """Give ``field`` its first ``values``."""
    view(field)[...] = values


def scalar(value):
    """Return a 0-D field holding ``value``: a number that kernels read but that is not compiled in."""
    return holding(ti.field(_real, shape=()), value)


def integer(value):
    """Return a 0-D field holding the whole number ``value``; a loop reads it once, into a local."""
    return holding(ti.field(ti.i32, shape=()), value)


def view(field):
    """Return the memory of a dense field as a NumPy array, to read from and write to; a vector is its last axis.

    The memory is gone after ``stop`` and the next ``start``: do not keep the array.
    """
    program, array = getattr(field, "_kept_view", (None, None))
    if program != _program:
        array = array_at(address(field), field)
        field._kept_view = _program, array
    return array


def array_at(place, field):
    """Return the NumPy array of a ``field`` whose memory begins at the address ``place``."""
    within = (field.n, field.m)[: field.ndim] if isinstance(field, ti.MatrixField) else ()
    shape, kind = (*field.shape, *within), _numpy_type(field.dtype)
    memory = ctypes.c_char * (prod(shape) * kind.itemsize)
    return np.frombuffer(memory.from_address(place), kind).reshape(shape)


def _numpy_type(kind):
    """Return NumPy's type of ``kind``, such as ``ti.f64``, which tells its letter and its bits."""
    name = str(kind)
    return np.dtype(f"{name[0]}{int(name[1:]) // 8}")


@ti.kernel
def address(field: ti.template()) -> ti.u64:
    """Return where the memory of ``field`` begins."""
    return ti.get_addr(field, ti.static([0] * len(field.shape)))


@ti.func
def unrolled(number):
    """Return ``number``; of ``for k in range(unrolled(number))`` the compiler may make several iterations one."""
    return number
