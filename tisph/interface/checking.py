"""``tisph.check``: what a run would be, without running it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tisph.config.loader import Asked, config_file, override_texts


@dataclass(frozen=True)
class RunEstimate:
    """What a run would be; printed, it is what ``tisph check`` prints.

    ``steps`` and ``run_time`` [seconds], of the steps alone, are estimates; ``steps_range`` and ``total_time_range``
    [seconds], of the whole run with compiling, pictures and movie, are the least and the largest to be expected. ``l2``
    estimates the relative error at the last sample, None where it is not predicted. ``resolved``: of each sample True
    or False, None where only the run can tell. ``warnings``: texts. ``numbers``: all estimates by name.
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

    def __str__(self) -> str:
        return self.text


def check(config: Asked, /, **overrides: Any) -> RunEstimate:
    """Check a config (as for ``run``) and return what its run would be; nothing is run, written or printed.

    It imports Taichi and starts no program of it. ConfigError has the message of ``tisph check``.
    """
    from tisph.cli.check import described, forecast
    from tisph.config import load

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
        )
