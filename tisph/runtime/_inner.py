"""Four inner parts of Taichi 1.7.4 are replaced here: launch of kernels, layout of fields, loops, and positions.

The file is used with that version alone (``_taichi.KNOWN``), since any other version, and Quadrants, may have other
inner parts; everything works without it. The results are the same to the last bit with this file and without it
(``tests/runtime/test_runtime.py``).

Launches. At each launch Taichi inspects every argument, looks its kernel up and asks for its machine code. That takes
35 us, the launch itself 1 us. A step of a few hundred particles consists of many short launches: with 12 particles
across, on one thread, a time loop is two to three times as fast with this file, in both schemes.

* ``_call_and_keep`` replaces the call of a kernel. After the first call of a kernel whose arguments are numbers, the
  object gets an attribute with the kernel's name: a function that launches the machine code. It is deleted with the
  object, whose fields do not outlive their program.
* ``_data_oriented`` replaces the decorator of classes. Taichi looks up every attribute of an object by a function in
  Python, and by another one for each base class, in case it is a kernel; with this file only kernels are looked up so.

Fields. Taichi lays fields out, and compiles code for them, whenever a new field is needed: once for each field that has
a first value. A kernel, which takes 6 to 10 ms, finds the address of each. Without this part a whole run of
couette.yaml with a full cache takes a fifth longer.

* ``_fill_later`` and ``_materialize_and_fill``: a field gets its first values as soon as a kernel or a view needs the
  layout, so that all fields are laid out at once.
* ``_address_in_tree``: the address of a field follows from the address of another field of the same tree, by the
  offsets of the layout.

Loops. Where LLVM knows the number of iterations of a loop, it unrolls the loop by eight, with a second loop for the
remainder. That is half of the machine code of the kernels here (on AMD Zen), for which each process waits, and few
loops gain by it. Without this part free_cylinder.yaml compiles for 23 to 28 s instead of 16 with an empty cache, and a
run of couette.yaml with a full one takes an eighth longer. So LLVM must not know the number: each loop of a kernel gets
a ``break`` on a condition in memory that is never true (``_build_for_that_may_end``). Where unrolling is faster, by
measurement, or keeps a local vector out of memory, the loop is written ``for k in range(unrolled(n))``, or
``range(unrolled(first), end)``.

Positions. For the message of an error that may come, Taichi draws the source lines around each expression that it
translates: a sixth of the processor time of a run of couette_minimal.yaml with a full cache. ``_position`` names file
and line alone.
"""

import ast
from collections.abc import Callable
from typing import Any

import taichi as ti
from taichi._lib import core
from taichi.lang import impl, kernel_impl, misc
from taichi.lang.ast.ast_transformer import ASTTransformer
from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext
from taichi.lang.impl import PyTaichi, get_runtime
from taichi.lang.kernel_impl import _BoundedDifferentiableMethod

from tisph.runtime import _fields

_call = _BoundedDifferentiableMethod.__call__
_address, _materialize = _fields.address, PyTaichi.materialize
_build_for, _parallelize = ASTTransformer.build_For, misc._parallelize
_depth = 0
_serial = False

_waiting: list[tuple[Any, Any]] = []
"""Fields that have no memory so far, and their first values."""

_bases: dict[int, int] = {}
"""Number of a tree of fields in Taichi's layout -> its address."""


def install() -> None:
    """Replace the parts of Taichi."""
    _BoundedDifferentiableMethod.__call__ = _call_and_keep
    ti.data_oriented = kernel_impl.data_oriented = _data_oriented
    PyTaichi.materialize = _materialize_and_fill
    _fields.address, _fields.fill = _address_in_tree, _fill_later
    misc._parallelize = _parallelize_noted
    ASTTransformer.build_For = staticmethod(_build_for_that_may_end)
    ASTTransformer.build__Leave = staticmethod(_build_leave)
    ASTTransformerContext.get_pos_info = _position


def begin() -> None:
    """Forget the fields of the previous program, and create the condition of loops in the new one."""
    _waiting.clear()
    _bases.clear()
    get_runtime().never = ti.field(ti.i32, shape=())


def _fill_later(field: Any, values: Any) -> None:
    """Store the first ``values`` of a ``field`` until it has memory, which is before any kernel sees it."""
    _waiting.append((field, values))


def _materialize_and_fill(self: Any) -> None:
    _materialize(self)
    waiting = _waiting.copy()
    _waiting.clear()
    for field, values in waiting:
        _fields.view(field)[...] = values


def _address_in_tree(field: Any) -> int:
    """Return the address of the memory of ``field``."""
    get_runtime().materialize()
    block = field.parent()
    tree, offset = block._snode_tree_id, block._offset_bytes_in_parent_cell
    if tree not in _bases:
        _bases[tree] = _address(field) - offset
    return _bases[tree] + offset


class _KernelMethod:
    """Descriptor of a ``kernel`` in a class: an object's attribute is the kernel bound to the object."""

    def __init__(self, kernel: Any):
        self.kernel = kernel

    def __get__(self, owner: object | None, kind: type | None = None) -> Any:
        if owner is None:
            return self.kernel
        bound = _BoundedDifferentiableMethod(owner, self.kernel)
        bound.__name__ = self.kernel.__name__
        return bound


def _data_oriented(kind: Any) -> Any:
    """Mark a class and its subclasses in place of Taichi's decorator; static kernels are not supported."""
    for name, method in list(vars(kind).items()):
        if getattr(method, "_is_classkernel", False):
            method._is_staticmethod = False
            setattr(kind, name, _KernelMethod(method))
    kind._data_oriented, kind.__init_subclass__ = True, classmethod(_data_oriented)
    return kind


def _call_and_keep(self: Any, *args: Any, **kwargs: Any) -> Any:
    result = _call(self, *args, **kwargs)
    kept = vars(self._kernel_owner)
    own = getattr(type(self._kernel_owner), self.__name__)._primal is self._primal  # no kernel of a base class
    if own and self.__name__ not in kept and not kwargs:  # an attribute set elsewhere stays
        launch = _launcher(self._primal, self._kernel_owner, args)
        if launch is not None:
            kept[self.__name__] = launch
    return result


def _launcher(kernel: Any, owner: object, args: tuple[Any, ...]) -> Callable[..., None] | None:
    """Return a function that launches ``kernel`` with other numbers for ``args``.

    None for a kernel that returns a value, prints, or has other arguments than numbers.
    """
    annotations = [argument.annotation for argument in kernel.arguments[1:]]
    numbers_alone = all(annotation in _SETTERS for annotation in annotations)
    if kernel.return_type is not None or not numbers_alone or get_runtime().target_tape:
        return None
    compiled = kernel.compiled_kernels[kernel.ensure_compiled(owner, *args)]
    if kernel.has_print:
        return None
    program, context = get_runtime().prog, compiled.make_launch_context()
    code = program.compile_kernel(program.config(), program.get_device_caps(), compiled)
    setters = [(*_SETTERS[annotation], (place,)) for place, annotation in enumerate(annotations)]

    def launch(*numbers: float) -> None:
        for (setter, kind, place), number in zip(setters, numbers, strict=True):
            setter(context, place, kind(number))
        program.launch_kernel(code, context)

    return launch


_Context = ti._lib.core.KernelLaunchContext

_SETTERS: dict[Any, tuple[Any, type]] = {
    float: (_Context.set_arg_float, float),
    ti.i32: (_Context.set_arg_int, int),
}
"""Annotation of an argument -> method that sets it, and its type in Python."""


def _parallelize_noted(threads: int) -> None:
    """Set the number of threads of the next loop, as ``ti.loop_config`` does, and note whether that is one."""
    global _serial
    _serial = threads == 1
    _parallelize(threads)


def _build_for_that_may_end(context: Any, node: Any) -> Any:
    """Translate a loop; a loop that is shared among threads cannot end early, the loops inside it can.

    A static loop is no loop of the kernel: its iterations follow one another at the level of the loop.
    """
    global _depth, _serial
    if ASTTransformer.get_decorator(context, node.iter) == "static":
        return _build_for(context, node)
    can_end, _serial = _depth > 0 or _serial, False
    _depth += 1
    try:
        if _is_call(node.iter, "range"):
            if _is_call(node.iter.args[0], "unrolled"):
                node = _changed(node, [*node.iter.args[0].args, *node.iter.args[1:]], node.body)
            elif can_end:
                node = _changed(node, node.iter.args, [*node.body, ast.copy_location(_Leave(), node.iter)])
        return _build_for(context, node)
    finally:
        _depth -= 1


def _is_call(node: Any, name: str) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name


def _changed(node: Any, limits: list[Any], body: list[Any]) -> ast.For:
    """Return the loop over a ``range`` of ``limits``, with this ``body``; created once for each loop."""
    if not hasattr(node, "kept"):
        call = ast.copy_location(ast.Call(node.iter.func, limits, []), node.iter)
        node.kept = ast.copy_location(ast.For(node.target, call, body, node.orelse), node)
    return node.kept


class _Leave(ast.stmt):
    """The end of an iteration: leave the loop if it is to end early."""


def _build_leave(context: Any, _: Any) -> None:
    builder, nowhere = context.ast_builder, core.DebugInfo("")
    ends = impl.subscript(builder, get_runtime().never) != 0
    impl.begin_frontend_if(builder, ends, nowhere)
    builder.begin_frontend_if_true()
    builder.insert_break_stmt(nowhere)
    builder.pop_scope()
    builder.begin_frontend_if_false()
    builder.pop_scope()


def _position(self: Any, node: Any) -> str:
    """Return file and line of a ``node`` of kernel source, for the message of an error in it."""
    return f'File "{self.file}", line {node.lineno + self.lineno_offset}, in {self.func.func.__name__}:\n'
