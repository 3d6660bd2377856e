"""Samples of a run in the files of other programs: a module a format, each with ``write(path, run)``."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from tisph.errors import ConfigError
from tisph.observers._files import replaced

if TYPE_CHECKING:
    from tisph.results import Results

FORMATS = tuple(item.name for item in iter_modules(__path__) if not item.name.startswith("_"))
"""Names of the formats: the modules of this folder."""


def export(run: "Results", form: str, path: Path | None = None) -> Path:
    """Write the samples of ``run`` as ``form``, one of ``FORMATS``, and return the file's path.

    It is ``path``, or ``samples.FORM`` in the run's folder. ConfigError where there is no sample, TisphError where the
    file cannot be written; then it is as it was.
    """
    if form not in FORMATS:
        raise ConfigError(f"--to {form}: must be one of {', '.join(FORMATS)}")
    if not len(run.samples):
        raise ConfigError(f"{run.folder}: the run has no sample to export")
    path = path or run.folder / f"samples.{form}"
    with replaced(path) as new:
        import_module(f"tisph.results.export.{form}").write(new, run)
    return path
