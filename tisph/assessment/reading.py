"""The frames of a file, whatever wrote it."""

import importlib
import pkgutil
import zipfile
from pathlib import Path

from tisph.assessment import readers
from tisph.errors import ConfigError

HDF5 = b"\x89HDF\r\n\x1a\n"


def frames(path, select=None):
    """Return the frames of the file ``path``: by what it begins with where that says it, else by its ending.

    Raises ConfigError where it cannot be read.
    """
    path = Path(path)
    try:
        with open(path, "rb") as file:
            begins = file.read(16)
        return _reader(path, begins).read(path, select)
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is no text, and its ending {path.suffix} is none of {_endings()}") from None
    except (OSError, zipfile.BadZipFile) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _reader(path, begins):
    if begins.startswith(b"ITEM: "):
        return _member("lammps")
    if begins.startswith(HDF5) and path.suffix != ".vtkhdf":
        return _member("hdf5")
    found = [module for module in _members() if path.suffix.lower() in module.SUFFIXES]
    return found[0] if found else _member("text")


def _members():
    return [_member(item.name) for item in pkgutil.iter_modules(readers.__path__)]


def _member(name):
    return importlib.import_module(f"{readers.__name__}.{name}")


def _endings():
    return ", ".join(suffix for module in _members() for suffix in module.SUFFIXES if suffix)
