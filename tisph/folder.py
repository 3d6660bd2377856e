"""The results folder: the list of the files that a run may leave, and its lock against other processes."""

import json
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from tisph.errors import ConfigError

LOCK = ".lock"

MADE = ("report.html", "samples.csv", "samples.npz", "samples.extxyz", "frames.vtkhdf", "frames_bodies.vtkhdf")
"""Files that other commands make from a run, in its folder: out of date after the next run."""


def partial(path: Path) -> Path:
    """Return the path of the file that is written to replace ``path``."""
    return path.with_name(f"{path.name}.partial")


def spare(path: Path) -> Path:
    """Return the path of a copy of the file ``path`` while that is being replaced."""
    return path.with_name(f"{path.name}.spare")


class Folder:
    """Paths of a run's files in ``root``."""

    def __init__(self, root: str | Path):
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

    def read_summary(self) -> dict[str, Any]:
        """Return the contents of ``summary.json``; status ``failed`` and no samples where there is no such file."""
        if not self.summary.is_file():
            return {"status": "failed", "samples": []}
        return json.loads(self.summary.read_text(encoding="utf-8"))

    def files(self) -> list[Path]:
        """Return the paths of all files, also of the partial files of a killed run."""
        paths = [path for name, path in vars(self).items() if name != "root"]
        spares = map(spare, (self.samples, self.vtk, self.vtk_bodies, self.frames))
        return [*paths, *map(partial, paths), *spares, *map(self.root.joinpath, MADE)]


@contextmanager
def held(root: Path) -> Iterator[None]:
    """Create the folder ``root`` if needed, and lock it against other processes; filelock's Timeout if it is locked.

    The lock ends with the context or the process. The lock's file is removed while it is still locked: a process that
    has opened it by then notices that it is gone (``filelock`` from 3.24 on).
    """
    from filelock import FileLock

    root.mkdir(parents=True, exist_ok=True)
    lock = FileLock(root / LOCK, timeout=0)
    with _interrupts_alone(), lock:
        own = os.stat(root / LOCK)
        try:
            yield
        finally:
            with suppress(OSError):  # the folder may be deleted or replaced by now; Windows keeps open files
                if os.path.samestat(own, os.stat(root / LOCK)):
                    os.unlink(root / LOCK)


@contextmanager
def _interrupts_alone() -> Iterator[None]:
    """Raise KeyboardInterrupt for a group of errors with one: after a second interrupt, while the folder is locked."""
    try:
        yield
    except BaseException as error:
        if _has_interrupt(error):
            raise KeyboardInterrupt from None
        raise


def _has_interrupt(error: BaseException) -> bool:
    return isinstance(error, KeyboardInterrupt) or any(map(_has_interrupt, getattr(error, "exceptions", ())))


RESULTS = tuple(path.name for path in Folder(".").files())
"""Names of all files that a run may leave. ``--overwrite`` removes them, and no other file."""


@contextmanager
def claimed(folder: Path, *, overwrite: bool, resume: bool) -> Iterator[None]:
    """Prepare ``folder`` for results and lock it against other runs; ConfigError where that is not possible.

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
        if overwrite:
            for name in RESULTS:
                try:
                    (folder / name).unlink(missing_ok=True)
                except OSError as error:
                    raise ConfigError(f"--overwrite: {folder / name} cannot be removed: {error.strerror}") from None
        yield
