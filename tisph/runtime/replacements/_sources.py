"""Sources of kernels, read and parsed once.

Each process translates every kernel that it launches from its Python source before it knows whether the compiled kernel
is in the cache. Taichi looks up and parses the source of a function at every call of it in a kernel; here that is
done once for each function.
"""

import ast
import functools
import textwrap

from taichi.lang import kernel_impl
from taichi.lang._wrap_inspect import getsourcefile, getsourcelines
from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext


def install():
    """Put this in the place of Taichi's own."""
    kernel_impl._get_tree_and_ctx = _tree_and_context


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
