"""A stand-in for the processes of ``tisph run``: they leave the numbers that a test chooses, and compute nothing."""

import json
import multiprocessing
import time
from pathlib import Path

from ruamel.yaml import YAML

from tisph.studies.processes import Result


class FakeRuns:
    """Takes the place of ``tisph.studies.processes.start``: records the configs that it is asked for.

    ``summary(config)`` gives the summary that a run leaves, or the text of the error with which it stops.
    """

    def __init__(self, summary):
        self.summary = summary
        self.configs = []
        self.running = 0
        self.most_at_once = 0

    def __call__(self, arguments, messages):
        path, folder = Path(arguments[1]), Path(arguments[3])
        config = YAML(typ="safe", pure=True).load(path)
        self.configs.append(config)
        self.running += 1
        self.most_at_once = max(self.most_at_once, self.running)
        return FakeProcess(self, self.summary(config), folder, messages)


class FakeProcess:
    """One of them; it ends when it is looked at for the second time."""

    def __init__(self, runs, outcome, folder, messages):
        self.runs, self.outcome, self.folder, self.messages = runs, outcome, folder, messages
        self.looks = 0
        self.status = None
        self.terminated = False

    @property
    def exitcode(self):
        self.looks += 1
        if self.looks > 1:
            self.join()
        return self.status

    def terminate(self):
        self.terminated = True

    def join(self):
        if self.status is None:
            self.runs.running -= 1
            self.status = self._end()

    def _end(self):
        if self.terminated:
            return 130
        self.folder.mkdir(exist_ok=True)
        if isinstance(self.outcome, str):
            self.messages.write_text(f" 10%  t = 0.1 s  step 100\nerror: {self.outcome}\n", encoding="utf-8")
            return 3
        (self.folder / "summary.json").write_text(json.dumps(self.outcome), encoding="utf-8")
        return 0


def sleeper():
    """A process that does not end by itself."""
    process = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(600,))
    process.start()
    return process


def make_result(folder=None, speed=0.5, **errors):
    """Result of a run with the given l2 errors, keyed t18 for t* = 0.018."""
    samples = [
        {"t_star": float(key[1:]) / 1000, "l2": value, "max_transverse_velocity": 1e-7, "density_variation": 2e-5}
        for key, value in errors.items()
    ]
    numbers = {"mach": 0.1, "sound_speed": 10 * speed, "reference_velocity": speed}
    return Result(folder, {"status": "done", "samples": samples, "numbers": numbers})
