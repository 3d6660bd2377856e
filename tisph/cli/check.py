"""``tisph check``: validate a config and say what its run would be, without running it."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from tisph.cli.terminal import ConfigFile, Overrides
from tisph.errors import ConfigError
from tisph.measures.resolution import resolution
from tisph.schemes._estimate import (
    DISORDERED_CELL_RE_OF_ORDER_2,
    DISORDERED_SOLVENT_CELL_RE,
    STABLE_CELL_RE,
    STIFF_POLYMER,
    polymer_stiffness,
)

HIGHEST_MACH = 0.1
"""Density varies by about Mach^2: above this the fluid is no longer nearly incompressible."""

HIGHEST_CELL_REYNOLDS = {"wcsph": STABLE_CELL_RE, "implicit": 400.0}
"""Cell Reynolds number U spacing / nu up to which disordered runs of the stability matrix are stable, by scheme. With
the explicit one they vary in density at 125 and lose the start of the flow at 400; the implicit one is stopped at 1250.
"""

HIGHEST_CELL_REYNOLDS_2D = 10.0
"""The same of the explicit scheme in two-dimensional flow: at 40 vortices lose a fifth of U in twenty rotations."""

LARGE_ERROR = 0.1
"""Estimated error at the last sample above which there is a warning."""

LONG = 86400.0
"""Seconds of an estimated run time above which there is a warning."""

BESIDE_LOOP, FRAME = {True: (3.0, 20.0), False: (5.0, 40.0)}, 0.025
"""Seconds of a run beside its loop and its movie, least and most, by whether the flow is parallel: kernels may have
been compiled before, and pictures may have many bodies. Seconds of a frame of the movie, at most. Of all configs a run
took 3 to 13, and 5 to 29, seconds of processor time."""

ERROR_FACTORS = {True: 3.0, False: 10.0}
"""Largest factor between a stated error and that of the run, by whether the sample is resolved."""

LOOP_FACTORS = 0.3, 2.5
"""Least and largest time of a step over its estimate: by threads, processor and iterations of the solvers."""

ROUNDING = math.floor, math.ceil

PROGRAM = "0.2 to 0.4 GB"
"""Memory of a run with few particles; measured, of all configs."""

LEAST_SOLVENT_FRACTION = 0.1
"""Below, little viscosity is left at the scale of the spacing, where the polymer stress does not resist."""


def check(config: ConfigFile, overrides: Overrides = None) -> None:
    """Validate a config; print its numbers and cost.

    Nothing is run and nothing is written.

    \b
    Examples:
      tisph check configs/couette.yaml
      tisph check configs/couette.yaml --set discretisation.particles_across=100
    """
    from tisph.config import load

    loaded = load(config, overrides or ())
    for line in described(loaded, *forecast(loaded)):
        print(line)


def described(config: Any, numbers: dict[str, Any], warnings: Sequence[str]) -> Iterator[str]:
    """Lines that say what the run of ``config`` is, from its ``forecast``."""
    walls = [config.members["walls"].type] if "walls" in config.members else []
    yield f"{config.name}: valid ({', '.join([config.scene, config.scheme.type, *walls])})"
    scene = _scene(config)
    samples = _sample_lines(scene, numbers["samples"])
    for label, text in [*scene.parameters(), *_run_lines(config, numbers), *samples]:
        yield f"  {label:22} {text}"
    for text in warnings:
        yield f"  warning: {text}"


def forecast(config: Any) -> tuple[dict[str, Any], list[str]]:
    """``estimates`` and warnings of a run before it runs; raises ConfigError where its result would be worthless."""
    numbers = estimates(config)
    if numbers["lost"]:  # before the layer at its walls is resolved it is mixed away
        raise ConfigError(
            f"discretisation: the cell Reynolds number U spacing / nu is {numbers['cell_reynolds']:.3g}, and up to the "
            f"last sample at t = {config.time.samples[-1]:g} the layer at the walls is too thin for the explicit "
            "scheme; give more particles across, a later sample, or scheme implicit"
        )
    return numbers, list(_warnings(config, numbers))


def estimates(config: Any) -> dict[str, Any]:
    """Numbers of a run before it runs, in the config's units; memory in bytes, run time in seconds."""
    from tisph import schemes
    from tisph.config import checks

    scene = _scene(config)
    particles = scene.particles
    resolved, reason = schemes.resolve(config)
    run = schemes.estimates(resolved, scene)
    fewest, most = run["samples"][-1].steps_range(run["steps"])
    frames = config.output.video.frames if config.output.video else 0
    step_time, (least, largest) = run["run_time"] / run["steps"], BESIDE_LOOP[scene.parallel]
    return {
        "reynolds": scene.reynolds,
        "cell_reynolds": scene.reference_velocity * scene.spacing / scene.solvent_viscosity,
        "viscous_time": scene.viscous_time,
        "particles": particles,
        "memory": checks.estimated_bytes(particles, config, resolved.scheme.type == "implicit"),
        "scheme": reason,
        "error": run["samples"][-1].l2,
        "steps_range": (fewest, most),
        "total_time_range": (
            least + fewest * step_time * LOOP_FACTORS[0],
            largest + most * step_time * LOOP_FACTORS[1] + frames * FRAME,
        ),
        "resolved": [_resolved(scene, sample)[0] for sample in run["samples"]],
        **run,
    }


def _scene(config: Any) -> Any:
    from tisph import scenes

    return scenes.of(config)


def _run_lines(config: Any, numbers: dict[str, Any]) -> list[tuple[str, str]]:
    """What the run is: particles, steps, cost."""
    from tisph.config.checks import format_bytes

    length, time = config.units.length, config.units.time
    explicit, reliable = numbers["sound_speed"], numbers["samples"][-1].steps_reliable
    largest = "" if explicit else "about " if config.parallel else "at most "
    digits = 4 if explicit else 2
    step = f"{largest}{numbers['time_step']:.{digits}g} {time}, set by the {numbers['binding_limit']} limit"
    steps = _range(numbers["steps_range"])
    guessed = "" if reliable else "; how the particles will flow is not known beforehand"
    number = (
        f"{config.rows} across, {config.columns} along" if any(config.periodic) else f"{config.particles_across} across"
    )
    spacing = f"{config.spacing:.6g} {length} ({number})"
    lines = [("scheme", numbers["scheme"])]
    if numbers["sound_speed"]:
        lines.append(("Mach number", f"{numbers['mach']:.4g}  (peak speed / c)"))
        lines.append(("sound speed c", f"{numbers['sound_speed']:.6g} {length}/{time}"))
    lines += [
        ("particle spacing", spacing),
        ("fluid particles", str(numbers["particles"])),
        ("time step", step),
        ("steps", f"{steps} from t = {config.start_time:g} to {config.time.end:g} {time}{guessed}"),
        ("memory", f"about {format_bytes(numbers['memory'])} for the particles, beside that of the program, {PROGRAM}"),
        (
            "run time",
            f"{_times(numbers['total_time_range'])} in all on an idle machine, with compiling, pictures and movie",
        ),
    ]
    return lines


def _sample_lines(scene: Any, samples: Sequence[Any]) -> Iterator[tuple[str, str]]:
    """Of every ``SampleEstimate`` whether the sample is resolved, and steps and error as far as they are known."""
    for sample in samples:
        steps = _range(sample.steps_range(sample.steps))
        resolved, state = _resolved(scene, sample)
        parts = [state, f"{steps} steps", *_error_text(sample, ERROR_FACTORS[resolved is True])]
        yield f"at t = {sample.t:g} {scene.units.time}", "; ".join(parts)
    if any(sample.rms is None for sample in samples):
        yield "errors", "no estimate before the run where none is stated; tisph run --estimate-error states one"


def _resolved(scene: Any, sample: Any) -> tuple[bool | None, str]:
    """Tell whether a sample will be resolved, and say so; None where its run decides that."""
    resolved, reason = resolution(scene, sample.t)
    if not resolved and not scene.has_free_bodies:
        return False, f"not resolved: {reason}"
    decisive = [*(["gaps and speeds of bodies"] if scene.has_free_bodies else []), *sample.judged_by]
    if not decisive:
        return True, "resolved"
    unknown = f"whether it is resolved only the run can tell ({', '.join(decisive)})"
    return None, unknown if resolved else f"probably not resolved: {reason}"


def _error_text(sample: Any, factor: float) -> Iterator[str]:
    if sample.rms is not None:
        kind, error, unit = ("rms", sample.rms, " U") if sample.l2 is None else ("L2", sample.l2, "")
        least = "up to" if sample.at_most else f"{error / factor:.0e} to"
        yield f"{kind} error {least} {factor * error:.0e}{unit}"


def _warnings(config: Any, numbers: dict[str, Any]) -> Iterator[str]:
    """Texts of what may go wrong with a valid config, whose ``estimates`` are given."""
    scene = _scene(config)
    yield from _unresolved(config, scene)
    if (numbers["error"] or 0.0) > LARGE_ERROR:
        last = config.time.samples[-1]
        yield f"the L2 error at the last sample, t = {last:g}, may be as large as {numbers['error']:.1g}"
    if numbers["run_time"] > LONG:
        yield f"the run may take {_range(numbers['steps_range'])} steps, {_times(numbers['total_time_range'])}"
    if numbers["mach"] > HIGHEST_MACH * (1 + 1e-9):
        yield f"the Mach number is above {HIGHEST_MACH:g}; expect compressibility errors"
    highest = HIGHEST_CELL_REYNOLDS["wcsph" if numbers["sound_speed"] else "implicit"]
    if numbers["sound_speed"] and not scene.parallel:
        highest = HIGHEST_CELL_REYNOLDS_2D
    if scene.polymer:
        highest = DISORDERED_SOLVENT_CELL_RE
    if numbers["cell_reynolds"] > highest:
        enough = math.ceil(config.particles_across * numbers["cell_reynolds"] / highest)
        yield (
            f"the cell Reynolds number U spacing / nu is {numbers['cell_reynolds']:.3g}; above {highest:g} a flow of "
            f"disordered particles may break up: give {enough} particles across or more"
        )
    order_2 = config.scheme.type == "implicit" and config.scheme.operators.order == 2
    if order_2 and config.initial.jitter and numbers["cell_reynolds"] > DISORDERED_CELL_RE_OF_ORDER_2:
        highest = DISORDERED_CELL_RE_OF_ORDER_2
        yield f"above a cell Reynolds number of {highest:g} order 2 may fail for disordered particles: take order 4"
    if not numbers["sound_speed"]:
        yield from _stiff(config, scene)
    if numbers["sound_speed"] and scene.polymer and scene.polymer.solvent_fraction < LEAST_SOLVENT_FRACTION:
        yield (
            f"fluid.rheology.solvent_fraction is below {LEAST_SOLVENT_FRACTION:g}; the solvent's viscosity is what "
            "damps the shortest waves of the polymer stress"
        )


def _stiff(config: Any, scene: Any) -> Iterator[str]:
    """Warning of an impulsive start where polymer relaxes before the layer of the solvent is a spacing thick."""
    if not scene.parallel or not scene.polymer or not any(scene.wall_jumps):
        return
    number = polymer_stiffness(config, scene)
    if number > STIFF_POLYMER:
        enough = math.ceil(config.particles_across * math.sqrt(number / STIFF_POLYMER))
        yield (
            "the polymer stress grows at an impulsively started wall before the layer of the solvent is one spacing "
            "thick; errors of disordered particles last until it is many spacings thick: "
            f"give {enough} particles across or more, or wait"
        )


def _unresolved(config: Any, scene: Any) -> Iterator[str]:
    """Samples that are not resolved, and why the first one after the start of the run, which is as the config says."""
    reasons = {t: resolution(scene, t)[1] for t in config.time.samples if t > config.start_time}
    early = [t for t, reason in reasons.items() if reason]
    if early:
        likely = " (as bodies stand at the start)" if scene.has_free_bodies else ""
        yield f"samples not resolved{likely}: {len(early)} of {len(reasons)}; at t = {early[0]:g} {reasons[early[0]]}"


def _range(numbers: tuple[float, float]) -> str:
    """Two positive numbers as text, rounded away from one another to two digits, or three; one where they are equal."""
    low, high = numbers
    if low == high:
        return f"{low:g}"
    digits = 2 if high > 1.2 * low else 3
    units = [10.0 ** (math.floor(math.log10(end)) + 1 - digits) for end in numbers]
    low, high = (way(round(end / unit, 6)) * unit for way, end, unit in zip(ROUNDING, numbers, units, strict=True))
    return f"{low:g} to {high:g}"


def _times(seconds: tuple[float, float]) -> str:
    (least, unit), (most, of_most) = (_duration(each).split() for each in seconds)
    return f"{least} to {most} {unit}" if unit == of_most else f"{least} {unit} to {most} {of_most}"


def _duration(seconds: float) -> str:
    for name, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {name}"
    return f"{seconds:.2g} s"
