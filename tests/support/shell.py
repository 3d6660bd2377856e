"""Words that a shell makes of pasted commands."""

import os
import shutil
import subprocess

import pytest

RECORDER = 'tisph() { printf "%s\\0" "$@"; printf "\\n"; }\n'
"""In the place of tisph: its arguments, each with a zero behind it, and the end of a line behind each command."""


def pasted(lines, folder):
    """Return the arguments of each ``tisph ...`` line as bash splits it in ``folder``, where no pattern may be loose.

    Skips the test where there is no bash.
    """
    if os.name == "nt" or not shutil.which("bash"):
        pytest.skip("no bash")
    script = RECORDER + "\n".join(lines)  # failglob: a pattern without a file is an error, as in zsh
    done = subprocess.run(["bash", "-eO", "failglob", "-c", script], cwd=folder, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    words = [line.split("\0")[:-1] for line in done.stdout.splitlines()]
    assert len(words) == len(lines), "a command wrote to a file, or ended early"
    return words
