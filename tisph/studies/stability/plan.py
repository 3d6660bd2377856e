"""How long the run of a cell is, and what is known of it beforehand: cost, error, warnings, refusal."""

from dataclasses import dataclass

from tisph.config import load
from tisph.errors import ConfigError
from tisph.studies.stability.cells import FINISHED, STABLE, Cell
from tisph.studies.stability.flows import FINER
from tisph.studies.store import config_text

BUDGET = 6.0
REQUIRED_BUDGET = {STABLE: 400.0, FINISHED: 40.0}
"""Seconds of one thread after which a cell ends, by ``_seconds``; the second, by requirement, for flows with 25
particles across or curved walls, so that what is required of t* = 1, in double precision, is seen there."""

STEP_SECONDS = {"explicit": 6e-5, "implicit 2": 1.5e-3, "implicit 4": 2e-3}
PARTICLE_SECONDS = {"explicit": 1.2e-7, "implicit 2": 1e-6, "implicit 4": 2.5e-6}
"""Rough time of a step, and of a particle in it, on one thread. Measured once and not again: the ends of the runs, and
with them all results, must not depend on the machine."""


@dataclass(frozen=True)
class Plan:
    """The run of a cell: its config, its end t*, its estimated ``seconds``, and what ``tisph check`` says of it.

    ``predicted``: the error that it states, ``refusal``: why it is refused, both None where there is none;
    ``warnings``: texts.
    """

    cell: Cell
    config: dict
    t_star: float
    seconds: float = 0.0
    predicted: float | None = None
    warnings: tuple[str, ...] = ()
    refusal: str | None = None


def plan(cell, forecast, folder):
    """Return the ``Plan`` of a cell; ``folder`` is for a config file to be checked.

    ``forecast(config)`` returns the numbers and the warnings of ``tisph check``.
    """
    t_star = cell.t_star
    try:
        numbers, warnings = _checked(cell, t_star, forecast, folder)
        seconds, budget = _seconds(cell, numbers), _budget(cell)
        if seconds > budget:
            t_star = float(f"{t_star * budget / seconds:.1e}")
            numbers, warnings = _checked(cell, t_star, forecast, folder)
    except ConfigError as error:
        return Plan(cell, cell.config(t_star), t_star, refusal=str(error).partition(": ")[2])
    stated = getattr(numbers["samples"][-1], cell.measure, None) if cell.measure else None
    return Plan(cell, cell.config(t_star), t_star, _seconds(cell, numbers), stated, tuple(warnings))


def _checked(cell, t_star, forecast, folder):
    """What is said of the last sample, by which the cell is judged."""
    config = cell.config(t_star)
    last = {**config, "time": {**config["time"], "samples": config["time"]["samples"][-1:]}}
    path = folder / "config.yaml"
    path.write_text(config_text(cell.name, last), encoding="utf-8")
    return forecast(load(path))


def _seconds(cell, numbers):
    one = STEP_SECONDS[cell.scheme] + numbers["particles"] * PARTICLE_SECONDS[cell.scheme]
    return numbers["steps"] * one


def _budget(cell):
    if cell.measure == FINER:
        return REQUIRED_BUDGET[STABLE]  # it has to end when the run that it is compared with does
    compared = (cell.across == 25 or cell.curved_walls) and (cell.precision == "f64" or cell.requirement == FINISHED)
    return REQUIRED_BUDGET.get(cell.requirement, BUDGET) if compared else BUDGET
