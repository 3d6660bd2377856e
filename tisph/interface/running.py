"""``tisph.run``: the command line's run, from Python."""

from os import PathLike, fspath
from pathlib import Path
from typing import Any

from tisph.config.loader import Asked, config_file, loaded, override_texts
from tisph.interface.bar import shown
from tisph.interface.process import command
from tisph.results import Results


def run(
    config: Asked,
    /,
    out: str | PathLike[str] | None = None,
    *,
    overwrite: bool = False,
    resume: bool = False,
    video: bool = True,
    progress: bool = False,
    **overrides: Any,
) -> Results:
    """Run a config (YAML file, dict or ``Config``) into the folder ``out`` [runs/NAME] and return its results.

    ``overrides`` are values by dotted key: ``run("couette.yaml", **{"time.end": 1.0, "walls.top.velocity": 0.01})``.
    A folder that is not empty is refused without ``overwrite`` or ``resume`` (go on from the checkpoint there).
    ``progress`` shows a bar; nothing else is printed. The run has a process of its own, so that a Taichi program here
    is not touched. Raises ``tisph.errors.ConfigError``, ``DivergedError`` or ``TisphError`` with the message of the
    command line, and KeyboardInterrupt, once there is a checkpoint, after Ctrl-C.
    """
    with config_file(config) as path, shown(progress) as show:
        options = [part for text in override_texts(overrides) for part in ("--set", text)]
        folder = Path("runs") / loaded(path, overrides).name if out is None else Path(out)
        options += ["--out", fspath(folder)]
        flags = {"--overwrite": overwrite, "--resume": resume, "--no-video": not video}
        options += [flag for flag, wanted in flags.items() if wanted]
        command(["run", *options, "--", path], show)
    return Results(folder)
