"""NumPy's archives: arrays by name, and those of PySPH, which have its particles as Python objects."""

import io
import pickle
import zipfile

import numpy as np
from numpy.lib import format as npy

from tisph.assessment.readers.frame import pysph_frame, split
from tisph.errors import ConfigError

SUFFIXES = (".npz",)

_HARMLESS = {
    (module, name)
    for core in ("numpy.core", "numpy._core")
    for module, names in (
        (f"{core}.multiarray", ("_reconstruct", "scalar")),
        (f"{core}.numeric", ("_frombuffer",)),
        ("numpy", ("ndarray", "dtype")),
        ("_codecs", ("encode",)),
    )
    for name in names
}
"""What an array, a number or a text is made of in a pickle: nothing that could run a program of the file's choice."""


class _Unpickler(pickle.Unpickler):
    def find_class(self, module, name):
        if (module, name) not in _HARMLESS:
            raise pickle.UnpicklingError(f"{module}.{name} is not read")
        return super().find_class(module, name)


def read(path, select=None):
    """Frames of the arrays, as ``frame.split`` has them."""
    with zipfile.ZipFile(path) as archive:
        arrays = {name.removesuffix(".npy"): _array(archive.read(name), path) for name in archive.namelist()}
    if "particles" in arrays and isinstance(arrays["particles"], dict):
        return [pysph_frame(arrays["particles"], arrays.get("solver_data", {}).get("t"), select, path)]
    return split(arrays, path)


def _array(content, path):
    stream = io.BytesIO(content)
    version = npy.read_magic(stream)
    _, _, kind = npy.read_array_header_1_0(stream) if version == (1, 0) else npy.read_array_header_2_0(stream)
    if not kind.hasobject:
        return np.load(io.BytesIO(content), allow_pickle=False)
    try:
        found = _Unpickler(stream).load()
    except pickle.UnpicklingError as error:
        raise ConfigError(f"{path}: holds Python objects that are not read: {error}") from None
    return found.item() if found.ndim == 0 else found
