"""``ti``: the package that is installed, imported in one place."""

import importlib

from tisph.runtime import _package

ti = importlib.import_module(_package.NAME)  # it reads the environment


def kernel_class():
    """Return the class of kernels, and the name of its dictionary of those that have been translated."""
    if _package.NAME == "taichi":
        return importlib.import_module("taichi.lang.kernel_impl").Kernel, "compiled_kernels"
    return importlib.import_module("quadrants.lang.kernel").Kernel, "materialized_kernels"
