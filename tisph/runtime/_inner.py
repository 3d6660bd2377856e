"""Three inner parts of Taichi 1.7.4 are replaced here: the launch of kernels, the layout of fields, and loops.

The file is used with that version alone (``_taichi.KNOWN``), since any other version, and Quadrants, may have other
inner parts; everything works without it. The results are the same to the last bit with this file and without it
(``tests/runtime/test_runtime.py``).

Launches. At each launch Taichi inspects every argument, looks its kernel up and asks for its machine code. That takes
35 us, while the launch itself takes 1. A step of a few hundred particles consists of many short launches: with 12
particles across, on one thread, a time loop is two to three times as fast with this file, in both schemes.

* ``_call_and_keep`` replaces the call of a kernel. After the first call of a kernel whose arguments are numbers, a
  function that has found its kernel and its code takes the place of the method in the object. The function ends with
  the object, whose fields do not outlive the program that they belong to.
* ``_data_oriented`` replaces the decorator of classes. For the sake of its kernels Taichi has every attribute of an
  object looked up by a function in Python, and by another one for each class that the object's class inherits from;
  with this file only kernels are looked up so.

Fields. Taichi lays fields out, and makes code for them, whenever a field declared since the last time is needed: once
for each number that a field holds from the start, and a kernel of 6 to 10 ms finds the address of each. Without this
part a whole warm run of couette.yaml takes a fifth longer.

* ``_fill_later`` and ``_materialize_and_fill``: a field gets its first values as soon as a kernel or a view needs the
  layout, so that all fields are laid out at once.
* ``_address_in_tree``: the address of a field follows from the address of another field of the same tree, by the
  offsets of the layout.

Loops. Where LLVM can tell how often a loop is repeated, it makes eight iterations one, with another loop for the
remainder: half of the machine code of the kernels here (on AMD Zen), which each process waits for, and few loops gain
by it. Without this part free_cylinder.yaml compiles for 23 to 28 s instead of 16 with an empty cache, and a warm run of
couette.yaml takes an eighth longer. So a loop of a kernel may also end early, by a number in memory that is never
anything but 0 (``_build_for_that_may_end``), and stays as it is. Where longer iterations are faster, by measurement, or
keep a local vector out of memory, the loop is written ``for k in range(unrolled(n))``.
"""

import ast

import taichi as ti
from taichi._lib import core
from taichi.lang import impl, kernel_impl, misc
from taichi.lang.ast.ast_transformer import ASTTransformer
from taichi.lang.impl import PyTaichi, get_runtime
from taichi.lang.kernel_impl import _BoundedDifferentiableMethod

from tisph.runtime import _fields

_call = _BoundedDifferentiableMethod.__call__
_address, _materialize = _fields.address, PyTaichi.materialize
_build_for, _parallelize = ASTTransformer.build_For, misc._parallelize
_depth = 0
_serial = False

_waiting = []
"""Fields, and the values that they get as soon as there is memory for them."""

_bases = {}
"""Addresses of the trees that Taichi lays fields out in, by their numbers."""


def install():
    """Put all parts in their places."""
    _BoundedDifferentiableMethod.__call__ = _call_and_keep
    ti.data_oriented = kernel_impl.data_oriented = _data_oriented
    PyTaichi.materialize = _materialize_and_fill
    _fields.address, _fields.fill = _address_in_tree, _fill_later
    misc._parallelize = _parallelize_noted
    ASTTransformer.build_For = staticmethod(_build_for_that_may_end)
    ASTTransformer.build__Leave = staticmethod(_build_leave)


def begin():
    """Forget the fields of an earlier program, and give the one that was just started its number of loops."""
    _waiting.clear()
    _bases.clear()
    get_runtime().never = ti.field(ti.i32, shape=())


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


class _OfObjects:
    """A ``kernel`` in the body of a class: what its objects have of it."""

    def __init__(self, kernel):
        self.kernel = kernel

    def __get__(self, owner, kind=None):
        if owner is None:
            return self.kernel
        bound = _BoundedDifferentiableMethod(owner, self.kernel)
        bound.__name__ = self.kernel.__name__
        return bound


def _data_oriented(kind):
    """Mark a class, and those that inherit from it, in the place of Taichi's decorator; no static kernels."""
    for name, method in list(vars(kind).items()):
        if getattr(method, "_is_classkernel", False):
            method._is_staticmethod = False
            setattr(kind, name, _OfObjects(method))
    kind._data_oriented, kind.__init_subclass__ = True, classmethod(_data_oriented)
    return kind


def _call_and_keep(self, *args, **kwargs):
    result = _call(self, *args, **kwargs)
    kept = vars(self._kernel_owner)
    own = getattr(type(self._kernel_owner), self.__name__)._primal is self._primal  # not that of a class above
    if own and self.__name__ not in kept and not kwargs:  # what somebody else has put there stays
        launch = _launcher(self._primal, self._kernel_owner, args)
        if launch is not None:
            kept[self.__name__] = launch
    return result


def _launcher(kernel, owner, args):
    """Return what launches ``kernel`` with other numbers for ``args``; None where there is more to do than that."""
    setters = [_SETTERS.get(argument.annotation) for argument in kernel.arguments[1:]]
    if kernel.return_type is not None or None in setters or get_runtime().target_tape:
        return None
    compiled = kernel.compiled_kernels[kernel.ensure_compiled(owner, *args)]
    if kernel.has_print:
        return None
    program, context = get_runtime().prog, compiled.make_launch_context()
    code = program.compile_kernel(program.config(), program.get_device_caps(), compiled)
    places = [(setter, (place,), kind) for place, (setter, kind) in enumerate(setters)]

    def launch(*numbers):
        for (setter, place, kind), number in zip(places, numbers, strict=True):
            setter(context, place, kind(number))
        program.launch_kernel(code, context)

    return launch


_Context = ti._lib.core.KernelLaunchContext

_SETTERS = {float: (_Context.set_arg_float, float), ti.i32: (_Context.set_arg_int, int)}
"""What puts an argument into its place, by its type."""


def _parallelize_noted(threads):
    """Do what ``ti.loop_config`` asks for, before the loop that it is about."""
    global _serial
    _serial = threads == 1
    _parallelize(threads)


def _build_for_that_may_end(context, node):
    """Translate a loop; one that is shared among threads cannot end early, those inside it can.

    A static one is no loop of the kernel: what is in it comes once after the other, at the level that it is at.
    """
    global _depth, _serial
    if ASTTransformer.get_decorator(context, node.iter) == "static":
        return _build_for(context, node)
    can_end, _serial = _depth > 0 or _serial, False
    _depth += 1
    try:
        if _is_call(node.iter, "range"):
            if _is_call(node.iter.args[0], "unrolled"):
                node = _changed(node, node.iter.args[0].args, node.body)
            elif can_end:
                node = _changed(node, node.iter.args, [*node.body, ast.copy_location(_Leave(), node.iter)])
        return _build_for(context, node)
    finally:
        _depth -= 1


def _is_call(node, name):
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name


def _changed(node, limits, body):
    """Return the loop as one over a ``range`` of these ``limits``, with this ``body``; made once for each loop."""
    if not hasattr(node, "kept"):
        call = ast.copy_location(ast.Call(node.iter.func, limits, []), node.iter)
        node.kept = ast.copy_location(ast.For(node.target, call, body, node.orelse), node)
    return node.kept


class _Leave(ast.stmt):
    """The end of an iteration: leave the loop if it is to end early."""


def _build_leave(context, _):
    builder, nowhere = context.ast_builder, core.DebugInfo("")
    ends = impl.subscript(builder, get_runtime().never) != 0
    impl.begin_frontend_if(builder, ends, nowhere)
    builder.begin_frontend_if_true()
    builder.insert_break_stmt(nowhere)
    builder.pop_scope()
    builder.begin_frontend_if_false()
    builder.pop_scope()
