"""The folder of results: when it may be used, and that it can be written."""

import tempfile
from pathlib import Path

from tisph.errors import ConfigError

CHECKPOINT = "checkpoint.h5"

RESULTS = (
    "config.resolved.yaml",
    "summary.json",
    "samples.h5",
    "frames.h5",
    CHECKPOINT,
    "history.csv",
    "profiles.png",
    "history.png",
    "last_good.h5",
    "last_good.png",
    "movie.mp4",
    "run.log",
)
"""What a run may leave, and all that ``--overwrite`` removes: other files in the folder are not touched."""


def prepare(folder: Path, *, overwrite: bool, resume: bool) -> None:
    """Make ``folder`` ready for results; ConfigError where it is not empty or cannot be written.

    Without ``overwrite`` or ``resume`` it must be new or empty; ``resume`` needs a checkpoint in it.
    """
    if overwrite and resume:
        raise ConfigError("--overwrite and --resume exclude each other")
    if resume and not (folder / CHECKPOINT).is_file():
        raise ConfigError(f"--resume: there is no {CHECKPOINT} in {folder}, nothing to go on from")
    try:
        if folder.is_dir() and any(folder.iterdir()) and not (overwrite or resume):
            raise ConfigError(
                f"--out {folder}: the folder is not empty; choose another one, or add --overwrite or --resume"
            )
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        for name in RESULTS if overwrite else ():
            (folder / name).unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(f"--out {folder}: cannot be written: {reason}") from None
