"""Samples of a run in the files of other programs: a module a format, each with ``write(path, run)``."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from tisph.errors import ConfigError
from tisph.observers._storage import replaced

if TYPE_CHECKING:
    from tisph.results import Results

FORMATS = tuple(item.name for item in iter_modules(__path__) if not item.name.startswith("_"))
"""Names of the formats: the modules of this folder."""


def export(run: "Results", form: str, path: Path | None = None, *, frames: bool = False) -> Path:
    """Write the samples of ``run`` as ``form``, one of ``FORMATS``, and return the file's path.

    It is ``path``, or ``samples.FORM`` in the run's folder; with ``frames``, of vtkhdf only, the frames of the movie
    and ``frames.vtkhdf``. Bodies of vtkhdf are in ``..._bodies.vtkhdf`` beside it. ConfigError where there is no sample
    or frame, TisphError where the file cannot be written; then it is as it was.
    """
    if form not in FORMATS:
        raise ConfigError(f"--to {form}: must be one of {', '.join(FORMATS)}")
    if frames and form != "vtkhdf":
        raise ConfigError(f"--frames: frames of the movie are exported as vtkhdf only, not as {form}")
    what = "frames" if frames else "samples"
    if not (run._files.frames.is_file() if frames else len(run.samples)):
        raise ConfigError(f"{run.folder}: the run has no {what[:-1]} to export")
    path, module = path or run.folder / f"{what}.{form}", import_module(f"tisph.results.export.{form}")
    with replaced(path) as new:
        module.write(new, run, *([True] if frames else []))
    if form == "vtkhdf":
        module.write_bodies(path, run, frames)
    return path
