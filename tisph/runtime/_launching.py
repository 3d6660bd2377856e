"""How kernels are launched again, in less time.

Taichi 1.7.4 looks at every argument, finds its kernel and asks for its code at each launch: 35 us, of which the launch
itself takes 1. A kernel of an object whose arguments are numbers is found once here. What launches it again takes the
place of the method in the object, with which it ends: fields of an object do not outlive the program that they are of.
"""

import taichi as ti
from taichi.lang.impl import get_runtime
from taichi.lang.kernel_impl import _BoundedDifferentiableMethod

_call = _BoundedDifferentiableMethod.__call__


def install():
    """Let every kernel of an object be found once."""
    _BoundedDifferentiableMethod.__call__ = _call_and_keep


def _call_and_keep(self, *args, **kwargs):
    result = _call(self, *args, **kwargs)
    kept = vars(self._kernel_owner)
    if self.__name__ not in kept and not kwargs:  # what somebody else has put there stays
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
