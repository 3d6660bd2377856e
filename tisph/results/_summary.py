"""``summary.json`` with a type: what ``docs/reference/files.md`` says of its keys holds here, too."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal, TypeVar

Value = float | int | bool | str | None
"""None where there is no such number, such as an error without a reference."""

T = TypeVar("T")


@dataclass(frozen=True)
class SampleErrors:
    """One sample at time ``t``; ``sample["NAME"]`` is any number of it, also those that only its scene has.

    ``l2`` is relative, ``rms`` and ``linf`` are over the reference velocity, ``t_star`` is ``t`` over the time scale.
    ``measures`` has all numbers by name, in the units of the config.
    """

    t: float
    t_star: float
    step: int
    resolved: bool
    reason: str | None
    l2: float | None
    rms: float | None
    linf: float | None
    measures: Mapping[str, Value] = field(repr=False)

    def __getitem__(self, name: str) -> Value:
        return self.measures[name]


@dataclass(frozen=True)
class Cost:
    """Steps, seconds of the clock (``_s``), and the largest memory [MB] of a run."""

    steps: int | None
    wall_total_s: float | None
    wall_import_s: float | None
    wall_compile_s: float | None
    wall_loop_s: float | None
    wall_output_s: float | None
    particle_steps_per_s: float | None
    peak_memory_mb: float | None


@dataclass(frozen=True)
class Provenance:
    """What else the numbers depend on: versions by package, machine, threads, precision, seed, config, commit."""

    versions: Mapping[str, str]
    platform: str | None
    processor: str | None
    threads: int | None
    precision: str | None
    seed: int | None
    config_hash: str | None
    commit: str | None


@dataclass(frozen=True)
class Summary:
    """What a run says of itself; one that was killed, or still runs, has the status ``failed`` and no samples here.

    ``message`` says what went wrong, ``numbers`` are those of the whole run by name, ``momentum`` is the balance along
    x [mass velocity per length out of the plane], ``error_estimate`` is there after ``--estimate-error``.
    """

    name: str
    status: Literal["done", "diverged", "interrupted", "failed"]
    message: str | None
    samples: tuple[SampleErrors, ...]
    numbers: Mapping[str, Value]
    momentum: Mapping[str, float | None]
    cost: Cost
    provenance: Provenance
    error_estimate: Mapping[str, Any] | None


def typed(data: Mapping[str, Any], name: str) -> Summary:
    """Return the contents of a ``summary.json``, of the run ``name`` where it does not say so.

    ValueError where it is none.
    """
    if not isinstance(data, dict) or "status" not in data or any("t" not in each for each in data.get("samples", [{}])):
        raise ValueError("it is no summary of a run")
    return Summary(
        name=data.get("name", name),
        status=data["status"],
        message=data.get("message"),
        samples=tuple(_known(SampleErrors, {**sample, "measures": sample}) for sample in data["samples"]),
        numbers=data.get("numbers", {}),
        momentum=data.get("momentum", {}),
        cost=_known(Cost, data.get("cost", {})),
        provenance=_known(Provenance, {"versions": {}, **data.get("provenance", {})}),
        error_estimate=data.get("error_estimate"),
    )


def _known(kind: type[T], data: Mapping[str, Any]) -> T:
    return kind(**{each.name: data.get(each.name) for each in fields(kind)})  # type: ignore[arg-type]
