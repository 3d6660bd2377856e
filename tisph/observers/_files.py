"""Files that are whole or not there: what a run leaves can be read, whatever ends it."""

import contextlib
import io
import os

import h5py

from tisph.errors import ConfigError, TisphError
from tisph.folder import partial

DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError)
"""What reading a damaged file raises: h5py has no error of its own."""


@contextlib.contextmanager
def written(path):
    """Raise one TisphError that names ``path`` where the system does not let it be written."""
    try:
        yield
    except OSError as error:
        raise TisphError(f"{path}: cannot be written: {error.strerror or error}") from error


@contextlib.contextmanager
def replaced(path):
    """Yield the path of a new file, which takes the place of ``path`` once it is complete.

    Until then, and where that fails, ``path`` is what it was; TisphError where the system is why.
    """
    new = partial(path)
    with written(path):
        try:
            yield new
            os.replace(new, path)
        except BaseException:
            with contextlib.suppress(OSError):
                new.unlink()
            raise


@contextlib.contextmanager
def readable(path):
    """Raise one ConfigError that names ``path`` where what it holds cannot be read."""
    try:
        yield
    except DAMAGE as error:
        raise ConfigError(f"{path}: cannot be read ({error}); run again with --overwrite") from error


@contextlib.contextmanager
def hdf5_file(path, mode="w"):
    """Yield ``path`` as HDF5 file to write, new or (``r+``) as it is; OSError, once closed, where a write failed."""
    with _Disk(path, "w+" if mode == "w" else "r+") as disk:
        with h5py.File(disk, mode) as hdf5:
            yield hdf5
        if disk.error:
            raise disk.error


class _Disk(io.FileIO):
    """A file that keeps its first failure for later: HDF5 crashes the process where it sees a write fail."""

    error = None

    def write(self, data):
        """Write all of ``data`` as long as nothing has failed."""
        rest = memoryview(data).cast("B")
        try:
            while rest and not self.error:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.error = error
        return len(data)

    def truncate(self, size=None):
        """Set the size of the file."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
