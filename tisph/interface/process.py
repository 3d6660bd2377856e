"""The command line in a process of its own: nothing of it is left in this one, whatever happens there."""

import _thread
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence

from tisph.errors import INTERRUPTED, ConfigError, DivergedError, TisphError
from tisph.report.drawing_process import apart_from_terminal

_PROGRAM = "import sys; sys.path[:] = {path!r}; from tisph.interface.process import main; main()"
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
