"""``tisph.run``, ``tisph.check`` and ``tisph.sweep``: commands, called from Python.

A run has a process of its own and leaves nothing in this one. Its progress is shown as a bar in a notebook or on a
terminal, as lines elsewhere.
"""

import _thread
import io
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from tisph import events
from tisph.config.loader import Asked, config_file, loaded, override_texts
from tisph.config.schema import Config
from tisph.errors import DOUBTFUL, INTERRUPTED, UNREACHED, ConfigError, DivergedError, TisphError
from tisph.report.drawing_process import apart_from_terminal
from tisph.results import Results

_PROGRAM = "import sys; sys.path[:] = {path!r}; from tisph.interface import main; main()"
_ERRORS = {kind.exit_status: kind for kind in (ConfigError, DivergedError)}

Show = Callable[[float, str], None]
"""Function of the part of the run that is done, 0 to 1, and of a text about its progress."""


def command(arguments: Sequence[str], show: Show) -> str:
    """Run ``tisph`` with ``arguments`` and return its printed output; ``show`` is called with its progress.

    Its errors are raised here. Ctrl-C, and the end of this process, interrupt it: it leaves the same files as after
    Ctrl-C on the command line, and then KeyboardInterrupt is raised.
    """
    process = subprocess.Popen(
        [sys.executable, "-X", "utf8", "-c", _PROGRAM.format(path=sys.path), *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        **apart_from_terminal(),
    )
    with process:
        try:
            message = _listen(process, show)
            printed = process.stdout.read() if process.stdout else ""
            process.wait()
        except BaseException:
            _end(process)
            raise
    if process.returncode:
        raise _error(process.returncode, message)
    return printed


def _listen(process: "subprocess.Popen[str]", show: Show) -> str:
    """Call ``show`` with the progress of ``process``, and return its error; without one, all it said beside events."""
    said, error = [], ""
    for line in process.stderr or ():
        event = events.read(line)
        if "progress" in event:
            show(*event["progress"])
        elif "error" in event:
            error = event["error"]
        else:
            said.append(line)
    return error or "".join(said).strip()


def _end(process: "subprocess.Popen[str]") -> None:
    """Let ``process`` write its results and end; a second Ctrl-C skips its pictures."""
    while process.poll() is None:
        try:
            process.communicate()  # it closes standard input first
        except KeyboardInterrupt:
            process.terminate()


def _error(status: int, message: str) -> TisphError:
    if status == INTERRUPTED:
        message = f"the run was interrupted from elsewhere: {message}"
    return _ERRORS.get(status, TisphError)(message or f"the run ended with status {status}")


def main() -> None:
    """Run the command line in the child process; the end of standard input, hence of the parent, interrupts it."""
    from tisph.__main__ import main as command_line

    events.write_as_json()
    threading.Thread(target=_interrupt_at_the_end_of_input, daemon=True).start()
    command_line()


def _interrupt_at_the_end_of_input() -> None:
    os.read(0, 1)  # not sys.stdin, whose lock would be held when Python ends
    _thread.interrupt_main()


@contextmanager
def shown(wanted: bool) -> Iterator[Show]:
    """Yield a function that shows the progress of a run; it does nothing unless that is ``wanted``."""
    if not wanted:
        yield lambda part, words: None
    elif _in_a_notebook():
        yield _notebook()
    elif sys.stderr.isatty():
        from tisph.report.terminal_bar import terminal_bar

        with terminal_bar() as bar:
            task = bar.add_task("", total=1.0, state="")
            yield lambda part, words: bar.update(task, completed=part, state=words.rpartition("  ")[0])
    else:
        yield events.progress


def _in_a_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and hasattr(shell, "kernel")


def _notebook() -> Show:
    from html import escape

    from IPython.display import HTML, display

    def element(part: float, words: str) -> HTML:
        return HTML(f'<progress value="{part:g}" style="width:16em"></progress> {part:.0%} {escape(words)}')

    handle = display(element(0.0, ""), display_id=True)
    return lambda part, words: handle.update(element(part, words))


def run(
    config: Asked,
    /,
    out: str | PathLike[str] | None = None,
    *,
    overwrite: bool = False,
    resume: bool = False,
    video: bool = True,
    progress: bool = False,
    until: Mapping[str, float | str] | None = None,
    at_most: str | None = None,
    vary: Mapping[str, float] | None = None,
    **overrides: Any,
) -> Results:
    """Run a config (YAML file, dict or ``Config``) into the folder ``out`` [runs/NAME] and return its results.

    ``overrides`` are values by dotted key: ``run("couette.yaml", **{"time.end": 1.0, "walls.top.velocity": 0.01})``.
    A folder that is not empty is refused without ``overwrite`` or ``resume`` (go on from the checkpoint there).
    ``until``, such as ``{"drag_coefficient": "0.1%"}``, makes finer and finer runs, in a time ``at_most`` such as
    10min, and returns the finest one, with error bars in ``results.accuracy``, which count other lengths with ``vary``,
    such as ``{"geometry.length": 1.25}``. ``progress`` shows a bar; nothing else is printed. The run has a process of
    its own. Raises a class of ``tisph.errors`` with the message of the command line; KeyboardInterrupt by Ctrl-C.
    """
    with config_file(config) as path, shown(progress) as show:
        options = [part for text in override_texts(overrides) for part in ("--set", text)]
        folder = Path("runs") / loaded(path, overrides).name if out is None else Path(out)
        options += ["--out", fspath(folder)]
        flags = {"--overwrite": overwrite, "--resume": resume, "--no-video": not video}
        options += [flag for flag, wanted in flags.items() if wanted]
        options += [part for name, goal in (until or {}).items() for part in ("--until", f"{name}={goal}")]
        options += [part for key, factor in (vary or {}).items() for part in ("--vary", f"{key}={factor}")]
        options += [] if at_most is None else ["--at-most", at_most]
        try:
            command(["run", *options, "--", path], show)
        except TisphError as error:
            if not str(error).startswith(UNREACHED):
                raise
    return Results(folder)


def sweep(
    study: str | PathLike[str] | Mapping[str, Any],
    /,
    out: str | PathLike[str] | None = None,
    *,
    processes: int | None = None,
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Run a study (YAML file or dict, as for ``tisph sweep``) into ``out`` [runs/NAME]; return the rows of its table.

    ``processes`` runs at a time [one a core], or on those of any ``concurrent.futures.Executor``. Ended runs are kept.
    """
    from tisph import runtime
    from tisph.studies.sweep import run

    count, folder = processes or runtime.available_threads(), None if out is None else Path(out)
    with config_file(study) as path, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        return [row.record for row in run(path, folder, count, executor=executor)]


def fit(
    data: str | PathLike[str],
    config: Asked,
    /,
    free: Mapping[str, tuple[float, float]],
    out: str | PathLike[str] | None = None,
    *,
    laws: Sequence[str] = (),
    sigma: float | None = None,
    **overrides: Any,
) -> dict[str, Any]:
    """Fit keys to the file ``data`` as ``tisph fit``, free={"fluid.density": (low, high)}; return ``fit.json``."""
    with config_file(config) as path, shown(False) as show:
        options = [part for key, (low, high) in free.items() for part in ("--free", f"{key}={low}..{high}")]
        options += [part for law in laws for part in ("--law", law)]
        options += [part for text in override_texts(overrides) for part in ("--set", text)]
        options += [] if sigma is None else ["--sigma", str(sigma)]
        folder = Path("runs") / f"fit-{loaded(path, overrides).name}" if out is None else Path(out)
        try:
            command(["fit", *options, "--config", path, "--out", fspath(folder), "--", fspath(data)], show)
        except TisphError as error:
            if not str(error).startswith(DOUBTFUL):
                raise
    return dict(json.loads((folder / "fit.json").read_text(encoding="utf-8")))


@dataclass(frozen=True)
class RunEstimate:
    """Estimates for a run; printed, it is the output of ``tisph check``.

    ``steps`` and ``run_time`` [seconds], of the steps alone, are estimates; ``steps_range`` and ``total_time_range``
    [seconds], of the whole run with compiling, pictures and movie, are the least and the largest expected values.
    ``l2`` estimates the relative error at the last sample, None where it is not predicted. ``resolved``: True or False
    for each sample, None where only the run can decide. ``warnings``: texts. ``numbers``: all estimates by name.
    """

    name: str
    reynolds: float
    particles: int
    steps: int
    run_time: float
    l2: float | None
    steps_range: tuple[int, int]
    total_time_range: tuple[float, float]
    resolved: tuple[bool | None, ...]
    warnings: tuple[str, ...]
    numbers: Mapping[str, Any] = field(repr=False)
    text: str = field(repr=False)
    config: Config = field(repr=False)

    def __str__(self) -> str:
        return self.text

    def picture(self, path: str | PathLike[str]) -> Path:
        """Draw the config to a PNG file, as ``tisph check --picture``, and return its path."""
        from tisph import scenes
        from tisph.report.preview import save_preview

        save_preview(Path(path), self.config, scenes.of(self.config))
        return Path(path)


def check(config: Asked, /, **overrides: Any) -> RunEstimate:
    """Return estimates for the run of a config (as for ``run``); nothing is run. ConfigError as ``tisph check``."""
    from tisph.config import load
    from tisph.schemes._forecast import described, forecast

    with config_file(config) as path:
        loaded = load(path, override_texts(overrides))
        numbers, warnings = forecast(loaded)
        return RunEstimate(
            name=loaded.name,
            reynolds=numbers["reynolds"],
            particles=numbers["particles"],
            steps=numbers["steps"],
            run_time=numbers["run_time"],
            l2=numbers["error"],
            steps_range=numbers["steps_range"],
            total_time_range=numbers["total_time_range"],
            resolved=tuple(numbers["resolved"]),
            warnings=tuple(warnings),
            numbers=numbers,
            text="\n".join(described(loaded, numbers, warnings)),
            config=loaded,
        )
