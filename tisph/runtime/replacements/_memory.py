"""Fields that are laid out all together, and whose places are known from one of them.

Taichi lays fields out, and makes code for that, whenever one of those declared since the last time is needed. Here a
field gets its first values as soon as that happens for the sake of a kernel or a view, and so it happens once. Where a
field lies follows from where another one of the same layout lies, by the numbers with which Taichi lays them out,
instead of a kernel for each (``tisph.runtime._fields.address``), 6 ms each where the cache has it.
"""

from taichi.lang.impl import PyTaichi, get_runtime

from tisph.runtime import _fields

_waiting = []
"""Fields, and what they are to hold as soon as there is memory for them."""

_bases = {}
"""Addresses of the trees that Taichi lays fields out in, by their numbers."""

_address, _materialize = _fields.address, PyTaichi.materialize


def install():
    """Let fields be filled and found so."""
    PyTaichi.materialize = _materialize_and_fill
    _fields.address, _fields.fill = _address_in_tree, _fill_later


def begin():
    """Forget the fields of an earlier program."""
    _waiting.clear()
    _bases.clear()


def _fill_later(field, values):
    """Give ``field`` its ``values`` as soon as it has memory, which is before any kernel sees it."""
    _waiting.append((field, values))


def _materialize_and_fill(self):
    _materialize(self)
    waiting = _waiting.copy()
    _waiting.clear()
    for field, values in waiting:
        _fields.view(field)[...] = values


def _address_in_tree(field):
    """Return where the memory of ``field`` begins."""
    get_runtime().materialize()
    block = field.parent()
    tree, offset = block._snode_tree_id, block._offset_bytes_in_parent_cell
    if tree not in _bases:
        _bases[tree] = _address(field) - offset
    return _bases[tree] + offset
