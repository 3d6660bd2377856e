"""How Taichi 1.7.4 reads kernels, in less time, and how long that takes.

Each process translates every kernel that it launches from Python source, expression by expression, before it knows
whether the compiled kernel is in the cache, and then turns what the cache has into machine code. What Taichi does
beside that took half of the translation: it looked up and parsed the source of a function at every call of it, and drew
source lines for error messages that are never shown; and at each decorator it looked through all modules. Replaced
here, for all kernels of the process.
"""

import ast
import functools
import sys
import textwrap
import time

from taichi.lang import impl, kernel_impl
from taichi.lang._wrap_inspect import getsourcefile, getsourcelines
from taichi.lang.ast.ast_transformer import ASTTransformer
from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext, Builder
from taichi.lang.exception import TaichiCompilationError

Kernel = kernel_impl.Kernel
_materialize, _launch = Kernel.materialize, Kernel.launch_kernel
_spent = 0.0
_unlaunched = set()


def compile_seconds():
    """Return the seconds that this process has spent so far on reading, compiling and first launching kernels."""
    return _spent


def _materialize_timed(self, key=None, args=None, arg_features=None):
    if key in self.compiled_kernels:
        return
    global _spent
    began = time.perf_counter()
    _materialize(self, key, args, arg_features)
    _unlaunched.add(self)
    _spent += time.perf_counter() - began


def _launch_timed(self, compiled, *args):
    if self not in _unlaunched:
        return _launch(self, compiled, *args)
    global _spent
    began = time.perf_counter()
    try:
        return _launch(self, compiled, *args)
    finally:
        _unlaunched.discard(self)
        _spent += time.perf_counter() - began


@functools.cache
def _source(function):
    """Return file, lines, first line and text of a function."""
    lines, first = getsourcelines(function)
    return getsourcefile(function), lines, first, textwrap.dedent("".join(lines))


@functools.cache
def _shared_tree(text):
    return _parsed(text)


def _parsed(text):
    tree = ast.parse(text)
    tree.body[0].decorator_list = []
    return tree


def _tree_and_context(
    self,
    excluded_parameters=(),
    is_kernel=True,
    arg_features=None,
    args=None,
    ast_builder=None,
    is_real_function=False,
):
    """Return syntax tree and context of a kernel or function; the translation changes the tree of a kernel only."""
    file, lines, first, text = _source(self.func)
    names = kernel_impl._get_global_vars(self.func)
    if is_kernel or is_real_function:
        names |= {self.arguments[slot].name: args[slot] for slot in self.template_slot_locations}
    context = ASTTransformerContext(
        excluded_parameters=excluded_parameters,
        is_kernel=is_kernel,
        func=self,
        arg_features=arg_features,
        global_vars=names,
        argument_data=args,
        src=lines,
        start_lineno=first,
        file=file,
        ast_builder=ast_builder,
        is_real_function=is_real_function,
    )
    return _parsed(text) if is_kernel else _shared_tree(text), context


def _place(context, node):
    """Return file and line of a piece of kernel source, for the message of an error in it."""
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


@functools.cache
def _translator(kind):
    return getattr(ASTTransformer, "build_" + kind.__name__)


def _translate(self, context, node):
    """Translate a piece of kernel source; an error gets the place of the innermost statement or expression."""
    places = impl.pytaichi.src_info_stack
    places.append("")
    try:
        return _translator(node.__class__)(context, node)
    except Exception as error:
        if context.raised or not isinstance(node, (ast.stmt, ast.expr)):
            raise
        context.raised = True
        kind = type(error) if isinstance(error, TaichiCompilationError) else TaichiCompilationError
        raise kind(f"{_place(context, node)}{type(error).__name__}: {error}") from error
    finally:
        places.pop()


def _inside_class(level_of_class_stackframe):
    """Tell whether what a decorator is applied to is in the body of a class, one level below the frame of its line."""
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals


def install():
    """Put all of this in the place of Taichi's own."""
    kernel_impl._inside_class = _inside_class
    Kernel.materialize, Kernel.launch_kernel = _materialize_timed, _launch_timed
    kernel_impl._get_tree_and_ctx = _tree_and_context
    Builder.__call__ = _translate
    ASTTransformerContext.get_pos_info = _place
