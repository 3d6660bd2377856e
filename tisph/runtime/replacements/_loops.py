"""Loops that LLVM leaves as they are written.

Where it can tell how often a loop is repeated, LLVM makes eight iterations one, with another loop for the remainder:
half of the machine code of the kernels here (on AMD Zen), which each process waits for, and few loops gain by it. So a
loop of a kernel may also end early, by a number in memory that is never anything but 0, and stays as it is. Where
longer iterations are faster, by measurement, or keep a local vector out of memory, it is written
``for k in range(unrolled(n))``.
"""

import ast

import taichi as ti
from taichi._lib import core
from taichi.lang import impl, misc
from taichi.lang.ast.ast_transformer import ASTTransformer
from taichi.lang.impl import get_runtime

_build_for, _parallelize = ASTTransformer.build_For, misc._parallelize
_depth = 0
_serial = False


def install():
    """Let kernels be translated so."""
    misc._parallelize = _parallelize_noted
    ASTTransformer.build_For = staticmethod(_build_for_that_may_end)
    ASTTransformer.build__Leave = staticmethod(_build_leave)


def begin():
    """Give the program that was just started its number."""
    get_runtime().never = ti.field(ti.i32, shape=())


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
