"""The folder of results: when it may be used, and that it can be written."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from filelock import Timeout

from tisph.errors import ConfigError
from tisph.folder import LOCK, Folder, held

RESULTS = tuple(path.name for path in Folder(".").files())
"""What a run may leave, and all that ``--overwrite`` removes: other files in the folder are not touched."""


@contextmanager
def claimed(folder: Path, *, overwrite: bool, resume: bool) -> Iterator[None]:
    """Make ``folder`` ready for results and keep other runs out of it; ConfigError where that cannot be.

    Without ``overwrite`` or ``resume`` it must be new or empty; ``resume`` needs a checkpoint in it.
    """
    if overwrite and resume:
        raise ConfigError("--overwrite and --resume exclude each other")
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
            _remove_results(folder)
        yield


def _remove_results(folder: Path) -> None:
    for name in RESULTS:
        try:
            (folder / name).unlink(missing_ok=True)
        except OSError as error:
            raise ConfigError(f"--overwrite: {folder / name} cannot be removed: {error.strerror}") from None
