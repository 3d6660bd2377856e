"""The results folder: its list of files, its lock, and files that are written completely or not at all."""

import io
import json
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from tisph.errors import ConfigError, TisphError

LOCK = ".lock"

MADE = ("report.html", "samples.csv", "samples.npz", "samples.extxyz", "frames.vtkhdf", "frames_bodies.vtkhdf")
"""Files that other commands make in the folder of a run: out of date with the next run."""


def partial(path: Path) -> Path:
    """Return the path at which the next version of the file ``path`` is written."""
    return path.with_name(f"{path.name}.partial")


def spare(path: Path) -> Path:
    """Return the path at which the previous version of the file ``path`` stays for a moment."""
    return path.with_name(f"{path.name}.spare")


class Folder:
    """Paths of a run's files in ``root``."""

    def __init__(self, root: str | os.PathLike[str]):
        self.root = Path(root)
        self.config = self.root / "config.resolved.yaml"
        self.summary = self.root / "summary.json"
        self.samples = self.root / "samples.h5"
        self.vtk = self.root / "samples.vtkhdf"
        self.vtk_bodies = self.root / "samples_bodies.vtkhdf"
        self.bodies = self.root / "bodies.h5"
        self.history = self.root / "history.csv"
        self.frames = self.root / "frames.h5"
        self.movie = self.root / "movie.mp4"
        self.movie_gif = self.root / "movie.gif"
        self.poster = self.root / "poster.jpg"
        self.profiles_picture = self.root / "profiles.png"
        self.history_picture = self.root / "history.png"
        self.log = self.root / "run.log"
        self.checkpoint = self.root / "checkpoint.h5"
        self.last_good = self.root / "last_good.h5"
        self.last_good_picture = self.root / "last_good.png"
        self.accuracy = self.root / "accuracy.json"
        self.accuracy_picture = self.root / "accuracy.png"

    def read_summary(self) -> dict[str, Any]:
        """Return the contents of ``summary.json``; status ``failed`` without samples where there is no such file."""
        if not self.summary.is_file():
            return {"status": "failed", "samples": []}
        return json.loads(self.summary.read_text(encoding="utf-8"))

    def files(self) -> list[Path]:
        """Return the paths of all files, and of their partial and spare versions, which a killed run may leave."""
        paths = [path for name, path in vars(self).items() if name != "root"]
        spares = map(spare, (self.samples, self.vtk, self.vtk_bodies, self.frames))
        return [*paths, *map(partial, paths), *spares, *map(self.root.joinpath, MADE)]


@contextmanager
def held(root: Path, name: str = LOCK) -> Iterator[None]:
    """Create the folder ``root`` if necessary and lock it; filelock's Timeout if another process holds the lock.

    ``name`` of the lock's file: another name locks a part of the folder. The lock ends with the context or the process.
    The lock's file is removed while it is still locked: a process that has opened it by then notices that it is gone
    (``filelock`` from 3.24 on).
    """
    from filelock import FileLock

    root.mkdir(parents=True, exist_ok=True)
    lock = FileLock(root / name, timeout=0)
    with _interrupts_alone(), lock:
        own = os.stat(root / name)
        try:
            yield
        finally:
            with suppress(OSError):  # the folder may be gone, or be another one by now; Windows keeps open files
                if os.path.samestat(own, os.stat(root / name)):
                    os.unlink(root / name)


@contextmanager
def _interrupts_alone() -> Iterator[None]:
    """Raise KeyboardInterrupt for a group of errors with one: a second interrupt at the lock."""

    def has_interrupt(error: BaseException) -> bool:
        return isinstance(error, KeyboardInterrupt) or any(map(has_interrupt, getattr(error, "exceptions", ())))

    try:
        yield
    except BaseException as error:
        if has_interrupt(error):
            raise KeyboardInterrupt from None
        raise


RESULTS = tuple(path.name for path in Folder(".").files())
"""Names of the files that ``--overwrite`` removes; other files in the folder are not touched."""


@contextmanager
def claimed(folder: Path, *, overwrite: bool, resume: bool) -> Iterator[None]:
    """Prepare ``folder`` for results and lock it against other runs; ConfigError where that is impossible.

    Without ``overwrite`` or ``resume`` it must be new or empty; ``resume`` needs a checkpoint in it.
    """
    if overwrite and resume:
        raise ConfigError("--overwrite and --resume exclude each other")
    from filelock import Timeout

    checkpoint = Folder(folder).checkpoint
    if resume and not checkpoint.is_file():
        raise ConfigError(f"--resume: there is no {checkpoint.name} in {folder}, nothing to go on from")
    with ExitStack() as stack:
        try:
            stack.enter_context(held(folder))
            used = any(entry.name != LOCK for entry in folder.iterdir())
        except Timeout:
            raise ConfigError(
                f"--out {folder}: is in use, another run is writing there; choose another folder"
            ) from None
        except (OSError, ValueError, NotImplementedError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ConfigError(f"--out {folder}: cannot be written: {reason}") from None
        if used and not (overwrite or resume):
            raise ConfigError(
                f"--out {folder}: the folder is not empty; choose another one, or add --overwrite or --resume"
            )
        for name in RESULTS if overwrite else ():
            try:
                (folder / name).unlink(missing_ok=True)
            except OSError as error:
                raise ConfigError(f"--overwrite: {folder / name} cannot be removed: {error.strerror}") from None
        yield


@contextmanager
def extended(folder: Path) -> Iterator[None]:
    """Lock the ``folder`` of a run to add files to it; ConfigError while its run, or another command, writes there."""
    from filelock import Timeout

    with ExitStack() as stack:
        try:
            stack.enter_context(held(folder))
        except Timeout:
            text = "its run is still going on, or another command is writing there; wait until it has ended"
            raise ConfigError(f"{folder}: is in use: {text}") from None
        yield


DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError)
"""Errors that reading a damaged file raises: h5py has no error of its own."""


@contextmanager
def written(path: Path) -> Iterator[None]:
    """Raise one TisphError that names ``path`` where the system refuses to write it."""
    try:
        yield
    except OSError as error:
        raise TisphError(f"{path}: cannot be written: {error.strerror or error}") from error


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield the path of a new file, which replaces ``path`` once it is complete.

    Until then, and after a failure, ``path`` is as before. TisphError where the system refuses to write.
    """
    new = partial(path)
    with written(path):
        try:
            yield new
            os.replace(new, path)
        except BaseException:
            with suppress(OSError):
                new.unlink()
            raise


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Raise one ConfigError that names ``path`` where its contents cannot be read."""
    try:
        yield
    except DAMAGE as error:
        raise ConfigError(f"{path}: cannot be read ({error}); run again with --overwrite") from error


@contextmanager
def hdf5_file(path: Path, mode: str = "w") -> Iterator[Any]:
    """Yield ``path`` as an HDF5 file, new or (``r+``) existing; OSError, once it is closed, where a write failed."""
    import h5py  # no command waits for it that opens no such file

    with _Disk(path, "w+" if mode == "w" else "r+") as disk:
        with h5py.File(disk, mode) as hdf5:
            yield hdf5
        if disk.error:
            raise disk.error


class _Disk(io.FileIO):
    """A file that stores its first failure: HDF5 crashes the process when a write fails."""

    error: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of ``data`` as long as nothing has failed."""
        rest = memoryview(data).cast("B")
        try:
            while rest and not self.error:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.error = error
        return len(data)

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return 0
