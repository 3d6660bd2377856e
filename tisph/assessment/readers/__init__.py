"""The frames of a file, whatever wrote it: one module a format, with ``SUFFIXES`` and ``read(path, select)``.

``select`` names the group of particles to read, where a format has groups; None leaves the choice to the reader.
"""

import zipfile
import zlib
from pathlib import Path

from tisph.assessment.readers import arrays, hdf5, json_text, lammps, text, vtk_files, xyz
from tisph.errors import ConfigError

READERS = (arrays, hdf5, json_text, lammps, text, vtk_files, xyz)

HDF5 = b"\x89HDF\r\n\x1a\n"


def frames(path, select=None):
    """Return the frames of the file ``path``: by what it begins with where that says it, else by its ending.

    Raises ConfigError where it cannot be read.
    """
    path = Path(path)
    try:
        with open(path, "rb") as file:
            begins = file.read(32)
        if found := _reader(path, begins).read(path, select):
            return found
        raise ConfigError(f"{path}: is empty")
    except UnicodeDecodeError:
        known = ", ".join(suffix for reader in READERS for suffix in reader.SUFFIXES if suffix)
        raise ConfigError(f"{path}: is no text, and its ending {path.suffix} is none of {known}") from None
    except (OSError, EOFError, NotImplementedError, zipfile.BadZipFile, zlib.error) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _reader(path, begins):
    if begins.startswith((lammps.BEGINS.encode(), lammps.CHUNKS.encode())):
        return lammps
    if begins.startswith(HDF5) and path.suffix != ".vtkhdf":
        return hdf5
    return next((reader for reader in READERS if path.suffix.lower() in reader.SUFFIXES), text)
