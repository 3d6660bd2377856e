"""Scenes that take turns: each in a process of its own, a few steps at a time, for as long as it takes.

What disturbs the machine meets them all alike, since what is compared was measured within a second. That, and seconds
of the processor instead of the clock, makes ratios repeatable on a machine that has other things to do.
"""

import json
import subprocess
import sys
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path

from tisph.errors import TisphError
from tisph.study.bench.stripped import STRIPPED, WHOLE
from tisph.study.store import config_text


class Remote:
    """A ``stepping`` process of ``scene``; ``facts`` are what it says of itself, once it is ready.

    ``program``: the folder of another copy of the package. ``environment``: of the process. None is what this one has.
    """

    def __init__(self, scene, program=None, environment=None):
        self._folder = tempfile.TemporaryDirectory()
        config = Path(self._folder.name) / "scene.yaml"
        config.write_text(config_text("scene", scene.config), encoding="utf-8")
        # a file, since a pipe could fill up; close() closes it
        self._messages = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115
        command = [sys.executable, "-m", "tisph.study.bench.stepping", str(config)]
        self._process = subprocess.Popen(
            command + ["--without-shifting"] * scene.without_shifting,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._messages,
            text=True,
            cwd=program,  # which is where -m looks first
            env=environment,
        )

    def facts(self):
        """Wait until it has started: number of ``particles`` and bytes of ``fields`` by name."""
        return self._answer()

    def do(self, what, times):
        """Let it do something ``times`` times; return what it says of it, ``seconds`` for each among it."""
        with suppress(BrokenPipeError):  # there will be no answer
            self._process.stdin.write(json.dumps({"do": what, "times": times}) + "\n")
            self._process.stdin.flush()
        return self._answer()

    def close(self):
        """Let it end."""
        with suppress(BrokenPipeError):  # it may have ended already
            self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()
        self._messages.close()
        self._folder.cleanup()

    def _answer(self):
        line = self._process.stdout.readline()
        if not line:
            self._process.wait()
            self._messages.seek(0)
            raise TisphError(f"a scene to be measured has stopped: {self._messages.read().strip()[-MOST_SHOWN:]}")
        return json.loads(line)


MOST_SHOWN = 500
"""Characters of what a process that failed has written to standard error."""

EVENTS = {"records": 20, "checkpoints": 3}
"""What else is measured, with the plain scene alone, and how many of each."""


def measure(group, copies, cycles):
    """Return what every scene of ``group`` is and costs, by name, from ``cycles`` turns of each.

    ``particles`` and ``fields`` as in ``facts``; ``seconds`` of a step and the time ``advanced``, one for each turn;
    for the scene ``plain`` also ``seconds`` and ``bytes`` of ``EVENTS``. ``copies``: the folder of ``copy_twice``.
    """
    names = list(group.scenes)
    with ExitStack() as running:
        remotes = {}
        for name in names:
            scene = group.scenes[name]
            remotes[name] = Remote(scene, copies / (STRIPPED if scene.stripped else WHOLE))
            running.callback(remotes[name].close)
        found = {name: {**remotes[name].facts(), "seconds": [], "advanced": []} for name in names}
        for cycle in range(cycles):
            shift = cycle % len(names)  # nobody always follows the same one
            for name in names[shift:] + names[:shift]:
                answer = remotes[name].do("steps", group.steps)
                found[name]["seconds"].append(answer["seconds"])
                found[name]["advanced"].append(answer["advanced"])
        found["plain"] |= {event: remotes["plain"].do(event, times) for event, times in EVENTS.items()}
    return found
