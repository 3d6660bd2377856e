"""``tisph.check``: what a run would be, without running it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tisph.config.from_python import Asked, config_file, override_texts


@dataclass(frozen=True)
class RunEstimate:
    """What a run would be; printed, it is what ``tisph check`` prints.

    ``run_time`` [seconds] is an estimate without compiling and video, ``l2`` one of the relative error at the last
    sample, None where there is none. ``warnings`` say what may go wrong, ``numbers`` are all estimates by name.
    """

    name: str
    reynolds: float
    particles: int
    steps: int
    run_time: float
    l2: float | None
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
            warnings=tuple(warnings),
            numbers=numbers,
            text="\n".join(described(loaded, numbers, warnings)),
        )
