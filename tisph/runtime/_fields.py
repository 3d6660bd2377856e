"""Fields as the host sees them: numbers that they start with, and their memory.

Taichi compiles a kernel for each field that is filled, copied from or to an array, or read by one value, and more for
each time that it gives memory to the fields declared since the last one: a tenth of a second each at first, and a third
of that when found in the cache. Here nothing is compiled but what finds the address.
"""

import ctypes
from math import prod

import numpy as np
import taichi as ti
from taichi.lang import impl, snode
from taichi.lang.impl import PyTaichi, get_runtime
from taichi.lang.util import to_numpy_type

_waiting = []
"""Fields, and what they are to hold as soon as there is memory for them: for all together, at the first kernel."""

_bases = {}
"""Addresses of the trees that Taichi lays fields out in, by their numbers."""

_materialize = PyTaichi.materialize


def install():
    """Let fields have their first values before any kernel sees them, and be declared without a look at the stack.

    Taichi writes down for each number of a field, 16 for a vector of 16, which lines have led to it.
    """
    PyTaichi.materialize = _materialize_and_set
    impl.get_traceback = snode.get_traceback = lambda stacklevel=1: ""


def forget():
    """Forget the fields that there were."""
    _waiting.clear()
    _bases.clear()


def _materialize_and_set(self):
    _materialize(self)
    waiting = _waiting.copy()
    _waiting.clear()
    for field, values in waiting:
        view(field)[...] = values


def real():
    """Return the floating-point type chosen at the start."""
    return get_runtime().default_fp


def holding(field, values):
    """Return ``field``, which holds ``values`` before any kernel sees it."""
    _waiting.append((field, values))
    return field


def scalar(value):
    """Return a 0-D field holding ``value``: a number that kernels read but that is not compiled in."""
    return holding(ti.field(real(), shape=()), value)


def integer(value):
    """Return a 0-D field holding the whole number ``value``; a loop reads it once, into a local."""
    return holding(ti.field(ti.i32, shape=()), value)


def view(field):
    """Return the memory of a dense field as a NumPy array, to read from and write to; a vector is its last axis.

    The memory is gone after ``stop`` and the next ``start``: do not keep the array.
    """
    program = get_runtime()
    kept = getattr(field, "_kept_view", None)
    if kept is None or kept[0] is not program.prog:
        program.materialize()
        kept = field._kept_view = program.prog, _view(field)
    return kept[1]


def _view(field):
    block = field.parent()
    tree, offset = block._snode_tree_id, block._offset_bytes_in_parent_cell
    if tree not in _bases:
        _bases[tree] = _address(field) - offset
    within = (field.n, field.m)[: field.ndim] if isinstance(field, ti.MatrixField) else ()
    shape, kind = (*field.shape, *within), to_numpy_type(field.dtype)
    memory = ctypes.c_char * (prod(shape) * np.dtype(kind).itemsize)
    return np.frombuffer(memory.from_address(_bases[tree] + offset), kind).reshape(shape)


@ti.kernel
def _address(field: ti.template()) -> ti.u64:
    return ti.get_addr(field, ti.static([0] * len(field.shape)))
