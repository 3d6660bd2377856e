"""Translation of kernels that draws no source lines for messages of errors that there are not; for tests alone.

Taichi draws the lines around each expression before it translates it, for the message that an error in it would have,
and writes down which lines have led to each field. A run does so once; tests make hundreds of schemes in a process,
and each scheme is translated anew. Here a message with file and line is made only when there is an error.
"""

import ast
import functools

from taichi.lang import impl, snode
from taichi.lang.ast.ast_transformer import ASTTransformer
from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext, Builder
from taichi.lang.exception import TaichiCompilationError


def install():
    """Put this in the place of Taichi's own, and let fields be declared without a look at the stack."""
    impl.get_traceback = snode.get_traceback = lambda stacklevel=1: ""
    Builder.__call__ = _translate
    ASTTransformerContext.get_pos_info = _position


def _position(context, node):
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
        raise kind(f"{_position(context, node)}{type(error).__name__}: {error}") from error
    finally:
        places.pop()
