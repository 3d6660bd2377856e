"""Fields as the host sees them: their first values and their memory.

Taichi compiles a kernel for each field that is filled, copied to or from an array, or read by one value: 0.1 s for each
at first, and a third of that with a full cache. Here only the kernel that finds an address is compiled.
"""

import ctypes
from math import prod
from typing import Any

import numpy as np

from tisph.runtime._taichi import ti

_real = None
_program = 0


def begin(precision: str) -> None:
    """Set the ``precision``, "f64" or "f32", of a new program; fields of the previous one are gone."""
    global _real, _program
    _real = {"f64": ti.f64, "f32": ti.f32}[precision]
    _program += 1


def real() -> Any:
    """Return the floating-point type chosen at the start."""
    return _real


def holding(field: Any, values: Any) -> Any:
    """Return ``field`` with ``values``, which it has before any kernel sees it."""
    fill(field, values)
    return field


def fill(field: Any, values: Any) -> None:
    """Set the first ``values`` of a ``field``."""
    view(field)[...] = values


def scalar(value: float) -> Any:
    """Return a 0-D field holding ``value``: a number that kernels read but that is not compiled in."""
    return holding(ti.field(_real, shape=()), value)


def integer(value: int) -> Any:
    """Return a 0-D field holding the whole number ``value``; a loop reads it once, into a local."""
    return holding(ti.field(ti.i32, shape=()), value)


def view(field: Any) -> np.ndarray:
    """Return the memory of a dense field as a NumPy array, to read from and write to; a vector is its last axis.

    The memory is gone after ``stop`` and the next ``start``: do not keep the array.
    """
    kept: tuple[int, np.ndarray] | None = getattr(field, "_kept_view", None)
    if kept is None or kept[0] != _program:
        components = (field.n, field.m)[: field.ndim] if isinstance(field, ti.MatrixField) else ()
        shape, name = (*field.shape, *components), str(field.dtype)  # such as f64
        kind = np.dtype(f"{name[0]}{int(name[1:]) // 8}")
        memory = ctypes.c_char * (prod(shape) * kind.itemsize)
        array = np.frombuffer(memory.from_address(address(field)), kind).reshape(shape)
        kept = field._kept_view = _program, array
    return kept[1]


@ti.kernel
def address(field: ti.template()) -> ti.u64:
    """Return the address of the memory of ``field``."""
    return ti.get_addr(field, ti.static([0] * len(field.shape)))


@ti.func
def unrolled(number):
    """Return ``number``, the first limit of a ``range`` of whose iterations the compiler may make several one."""
    return number
