"""``tisph.run``: the command line's run, from Python, in a process of its own: nothing of it is left in this one.

The progress of a run is shown as a bar in a notebook or on a terminal, as lines elsewhere.
"""

import _thread
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from tisph.config.loader import Asked, config_file, loaded, override_texts
from tisph.errors import INTERRUPTED, ConfigError, DivergedError, TisphError
from tisph.report.drawing_process import apart_from_terminal
from tisph.results import Results

_PROGRAM = "import sys; sys.path[:] = {path!r}; from tisph.interface.running import main; main()"
_PROGRESS = re.compile(r" *(\d+)%  (.*)")
_ERRORS = {kind.exit_status: kind for kind in (ConfigError, DivergedError)}

Show = Callable[[float, str], None]
"""Takes how much of a run is done, 0 to 1, and how far it is in words."""


def command(arguments: Sequence[str], show: Show) -> str:
    """Run ``tisph`` with ``arguments`` and return what it prints; ``show`` is told how far it is.

    Its errors are raised here. Ctrl-C, and the end of this process, interrupt it: it leaves what Ctrl-C leaves on the
    command line, and then KeyboardInterrupt goes on.
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
            words = _listen(process, show)
            printed = process.stdout.read() if process.stdout else ""
            process.wait()
        except BaseException:
            _end(process)
            raise
    if process.returncode:
        raise _error(process.returncode, words)
    return printed


def _listen(process: "subprocess.Popen[str]", show: Show) -> list[str]:
    """Return the lines that ``process`` writes to standard error, but for those of its progress."""
    words = []
    for line in process.stderr or ():
        progress = _PROGRESS.fullmatch(line.rstrip("\n"))
        if progress:
            show(int(progress[1]) / 100, progress[2])
        else:
            words.append(line)
    return words


def _end(process: "subprocess.Popen[str]") -> None:
    """Let ``process`` write what it knows and end; a second Ctrl-C here leaves out its pictures."""
    while process.poll() is None:
        try:
            process.communicate()  # it closes standard input first
        except KeyboardInterrupt:
            process.terminate()


def _error(status: int, words: list[str]) -> TisphError:
    text = "".join(words)
    message = text[max(text.find("error: "), 0) :].removeprefix("error: ").strip()
    if status == INTERRUPTED:
        message = f"the run was interrupted from elsewhere: {message}"
    return _ERRORS.get(status, TisphError)(message or f"the run ended with status {status}")


def main() -> None:
    """Be that process: the command line, which is interrupted where standard input ends, as it does with its parent."""
    from tisph.__main__ import main as command_line

    threading.Thread(target=_interrupt_at_the_end_of_input, daemon=True).start()
    command_line()


def _interrupt_at_the_end_of_input() -> None:
    os.read(0, 1)  # not sys.stdin, whose lock would be held when Python ends
    _thread.interrupt_main()


@contextmanager
def shown(wanted: bool) -> Iterator[Show]:
    """Yield a function that shows how far a run is; it does nothing unless that is ``wanted``."""
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
        yield lambda part, words: print(f"{part:4.0%}  {words}", file=sys.stderr, flush=True)


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
