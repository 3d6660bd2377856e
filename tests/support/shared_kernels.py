"""A kernel that an object asks for is that of an earlier one, where all that Taichi read of that one is the same.

Taichi translates a kernel anew for each object that has it, and finds afterwards that it knows the result; in tests,
which make hundreds of objects of few sorts, that took a third of the time and more. A translation depends on what it
reads: attributes of the object and of those it leads to, and names of modules. Each read is written down here with its
value. An object with the same fields, numbers and functions in the same places gets the kernel that there is; where
something else was read, such as an object in a list, nothing is shared.
"""

import types

import fast_translation
import numpy as np
from taichi.lang.ast.ast_transformer import ASTTransformer
from taichi.lang.field import Field
from taichi.lang.kernel_impl import Kernel
from taichi.lang.matrix import Matrix

from tisph.runtime import ti

NUMBERS = int, float, str, bool, type(None), np.generic
SINGLE = type, types.ModuleType, types.FunctionType, types.BuiltinFunctionType, Field

_attribute, _name, _materialize = ASTTransformer.build_Attribute, ASTTransformer.build_Name, Kernel.materialize

known = {}
"""Of each kernel with its types of arguments: the ``Reads`` that there were, the first ones first."""

reading = None


class Reads:
    """What was read from the objects ``roots``, and from those that they led to, and the ``kernel`` that came of it."""

    def __init__(self, roots):
        self.roots, self.objects = [_seen(root) for root in roots], list(roots)
        self.attributes, self.names, self.complete, self.kernel = {}, {}, True, None

    def attribute(self, owner, name, value):
        """Write down that the attribute of an ``owner`` was read."""
        place = next((k for k, known in enumerate(self.objects) if known is owner), None)
        if place is None:
            self.complete &= not _leads_on(owner)
            return
        if _leads_on(value) and not any(known is value for known in self.objects):
            self.objects.append(value)
        other = next((k for k, known in enumerate(self.objects) if known is value), None)
        self.attributes[place, name] = other, _seen(value)
        self.complete &= _seen(value) is not None

    def fit(self, roots):
        """Tell whether all of it would be read from other ``roots``."""
        if [_seen(root) for root in roots] != self.roots:
            return False
        found = dict(enumerate(roots))
        for (place, name), (other, seen) in self.attributes.items():
            value = getattr(found[place], name, None)
            if _seen(value) != seen or (other is not None and found.setdefault(other, value) is not value):
                return False
        return all(names.get(name) is value for names, name, value in self.names.values())


def _leads_on(value):
    return hasattr(type(value), "_data_oriented")


def _seen(value):
    """What tells a value from another; None where nothing does."""
    if _leads_on(value):
        return "object", type(value)
    if isinstance(value, types.MethodType):
        return "method", value.__func__
    if isinstance(value, NUMBERS):
        return type(value), value
    if isinstance(value, Matrix):
        return "matrix", repr(value.to_list())
    if isinstance(value, (tuple, list)):
        parts = [_seen(part) for part in value]
        return None if None in parts or any(map(_leads_on, value)) else (type(value), parts)
    single = isinstance(value, SINGLE) or callable(value) or isinstance(value, ti._lib.core.DataType)
    return ("single", id(getattr(value, "__wrapped__", value)), value) if single else None


def _read_attribute(context, node):
    result = _attribute(context, node)
    if reading is not None:
        reading.attribute(node.value.ptr, node.attr, result)
    return result


def _read_name(context, node):
    result = _name(context, node)
    names = context.func.func.__globals__
    if reading is not None and node.id in names and not any(node.id in scope for scope in context.local_scopes):
        reading.names[id(names), node.id] = names, node.id, names[node.id]
    return result


def _find_or_materialize(self, key=None, args=None, arg_features=None):
    global reading
    if key in self.compiled_kernels:
        return
    roots = [args[slot] for slot in self.template_slot_locations]
    kinds = [feature for slot, feature in enumerate(arg_features or ()) if slot not in self.template_slot_locations]
    others = known.setdefault((self, repr(kinds)), [])
    same = next((reads for reads in others if reads.fit(roots)), None)
    if same is not None:
        self.runtime.materialize()
        self.compiled_kernels[key] = same.kernel
        return
    outer, reading = reading, Reads(roots)  # Taichi launches kernels of its own when it lays out fields for this one
    reads = reading
    try:
        _materialize(self, key, args, arg_features)
    finally:
        reading = outer
    reads.kernel = self.compiled_kernels[key]
    if reads.complete:
        others.append(reads)


def install():
    """Put this in the place of Taichi's own."""
    ASTTransformer.build_Attribute, ASTTransformer.build_Name = staticmethod(_read_attribute), staticmethod(_read_name)
    Kernel.materialize = _find_or_materialize
    fast_translation._translator.cache_clear()


def uninstall():
    """Take it back, and forget all kernels: they are of the program that ends."""
    ASTTransformer.build_Attribute, ASTTransformer.build_Name = staticmethod(_attribute), staticmethod(_name)
    Kernel.materialize = _materialize
    fast_translation._translator.cache_clear()
    known.clear()
