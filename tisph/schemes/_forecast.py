"""Forecast of a run from its config: numbers, warnings, and the text of ``tisph check``.

Steps, errors and seconds of the steps are estimates of the scheme (``_estimate.py``). Here stand the limits beyond
which runs were found to fail, with a warning for each.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from tisph import scenes, schemes
from tisph.config import schema
from tisph.config.schema import Config
from tisph.errors import ConfigError
from tisph.measures.heat import dimensionless_numbers
from tisph.measures.resolution import STEEPEST, resolution
from tisph.scenes._automatic import FINEST, MORE
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.schemes._estimate import (
    DISORDERED_CELL_RE_OF_ORDER_2,
    DISORDERED_SOLVENT_CELL_RE,
    STABLE_CELL_RE,
    STIFF_POLYMER,
    polymer_stiffness,
)

HIGHEST_MACH = 0.1
"""Mach number above which there is a warning: density varies by about its square."""

HIGHEST_CELL_REYNOLDS = {"wcsph": STABLE_CELL_RE, "implicit": 400.0}
"""Cell Reynolds number U spacing / nu up to which disordered runs of the stability matrix are stable, by scheme. At 125
explicit runs vary in density, at 400 their start-up flow is wrong; at 1250 implicit runs stop with an error."""

HIGHEST_CELL_REYNOLDS_2D = 10.0
"""Highest cell Reynolds number of the explicit scheme in two-dimensional flow: at 40 vortices lose a fifth of their
velocity in twenty rotations."""

LARGE_ERROR = 0.1
"""Estimated error at the last sample above which there is a warning."""

LONG = 86400.0
"""Seconds of an estimated run time above which there is a warning."""

BESIDE_LOOP, FRAME = {True: 8.0, False: 13.0}, 0.012
"""Time [s] of a run beside its loop and its movie, by whether the flow is parallel, and of a frame of the movie. The
runs of all configs took 3 to 13 s of processor time in parallel flow, and 5 to 29 s in other flows."""

ERROR_FACTORS = {True: 3.0, False: 10.0}
"""Largest factor between the stated error and the error of the run, by whether the sample is resolved."""

TIME_FACTOR = 2.0
"""Largest factor between the time of a run and its estimate: by threads, processor, kernels compiled before, steps."""

PROGRAM = "0.2 to 0.4 GB"
"""Memory of a run with few particles, measured for all configs."""

LEAST_SOLVENT_FRACTION = 0.1
"""Solvent fraction below which there is a warning: at the scale of the spacing only the solvent damps the velocity."""


def forecast(config: Config) -> tuple[dict[str, Any], list[str]]:
    """Return the ``estimates`` of a run and warnings; raises ConfigError where its result would be worthless."""
    numbers = estimates(config)
    if numbers["lost"]:  # the layer at the walls is mixed into the flow before it is resolved
        raise ConfigError(
            f"discretisation: the cell Reynolds number U spacing / nu is {numbers['cell_reynolds']:.3g}, and up to the "
            f"last sample at t = {config.time.samples[-1]:g} the layer at the walls is too thin for the explicit "
            "scheme; give more particles across, a later sample, or scheme implicit"
        )
    return numbers, list(_warnings(config, numbers))


def estimates(config: Config) -> dict[str, Any]:
    """Return numbers of a run before it runs, in the config's units; memory in bytes, run time in seconds."""
    scene = scenes.of(config)
    resolved, reason = schemes.resolve(config)
    run = schemes.estimates(resolved, scene)
    frames = config.output.video.frames if config.output.video else 0
    wanted = scene.wanted_spacing
    total_time = BESIDE_LOOP[scene.parallel] + run["run_time"] + frames * FRAME
    return {
        "reynolds": scene.reynolds,
        "cell_reynolds": scene.reference_velocity * scene.spacing / scene.solvent_viscosity,
        "viscous_time": scene.viscous_time,
        "particles": scene.particles,
        "smallest_spacing": wanted.smallest,
        "particles_if_finest": round(scene.region.area / wanted.smallest**2) if wanted.varies else scene.particles,
        "memory": schema.estimated_bytes(scene.particles, config, resolved.scheme.type == "implicit"),
        "scheme": reason,
        "error": run["samples"][-1].l2,
        "steps_range": run["samples"][-1].steps_range(run["steps"]),
        "total_time": total_time,
        "total_time_range": (total_time / TIME_FACTOR, total_time * TIME_FACTOR),
        "resolved": [_resolved(scene, sample)[0] for sample in run["samples"]],
        **run,
    }


def _warnings(config: Config, numbers: dict[str, Any]) -> Iterator[str]:
    """Yield the warnings for a valid config with these ``estimates``."""
    scene: Scene = scenes.of(config)
    # a sample at the start of the run has the initial state of the config
    reasons = {t: resolution(scene, t)[1] for t in config.time.samples if t > config.start_time}
    early = [t for t, reason in reasons.items() if reason]
    if early:
        likely = " (as bodies stand at the start)" if scene.has_free_bodies else ""
        count = f"{len(early)} of {len(reasons)}"
        yield f"samples not resolved{likely}: {count}; at t = {early[0]:g} {reasons[early[0]]}"
    if (numbers["error"] or 0.0) > LARGE_ERROR:
        last = config.time.samples[-1]
        yield f"the L2 error at the last sample, t = {last:g}, may be as large as {numbers['error']:.1g}"
    if scene.steepness > STEEPEST:
        text = f"before the flow is steady, the polymer's stretch will change {math.exp(scene.steepness):.2g}-fold"
        yield f"{text} within a spacing; resolved up to {math.exp(STEEPEST):.2g}-fold"
    if numbers["run_time"] > LONG:
        steps = _about(numbers["steps"], numbers["steps_range"], " steps")
        yield f"the run takes {steps}, {_total_time(numbers)}"
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
    if not numbers["sound_speed"] and isinstance(scene, Channel) and scene.polymer and any(scene.wall_jumps):
        number = polymer_stiffness(config, scene)
        if number > STIFF_POLYMER:
            enough = math.ceil(config.particles_across * math.sqrt(number / STIFF_POLYMER))
            yield (
                "the polymer stress grows at an impulsively started wall before the layer of the solvent is one "
                "spacing thick; errors of disordered particles last until it is many spacings thick: "
                f"give {enough} particles across or more, or wait"
            )
    if numbers["sound_speed"] and scene.polymer and scene.polymer.solvent_fraction < LEAST_SOLVENT_FRACTION:
        yield (
            f"fluid.rheology.solvent_fraction is below {LEAST_SOLVENT_FRACTION:g}; only the solvent's viscosity damps "
            "the shortest waves of the polymer stress"
        )


def _resolved(scene: Scene, sample: Any) -> tuple[bool | None, str]:
    """Return whether a sample will be resolved, None where only its run decides, and the words for it."""
    resolved, reason = resolution(scene, sample.t)
    if not resolved and not scene.has_free_bodies:
        return False, f"not resolved: {reason}"
    decisive = [*(["gaps and speeds of bodies"] if scene.has_free_bodies else []), *sample.judged_by]
    if not decisive:
        return True, "resolved"
    unknown = f"whether it is resolved only the run can tell ({', '.join(decisive)})"
    return None, unknown if resolved else f"probably not resolved: {reason}"


def described(config: Config, numbers: dict[str, Any], warnings: Sequence[str]) -> Iterator[str]:
    """Yield the lines that describe the run of ``config``, from its ``forecast``."""
    walls = [config.members["walls"].type] if "walls" in config.members else []
    yield f"{config.name}: valid ({', '.join([config.scene, config.scheme.type, *walls])})"
    scene = scenes.of(config)
    files = config.at_walls("traced").items()
    shapes = [(f"{key}.file", traced.described(config.units.length)) for key, traced in files]
    known = [*scene.parameters(), *dimensionless_numbers(scene), *shapes]
    for label, text in [*known, *_run_lines(config, numbers), *_sample_lines(scene, numbers["samples"])]:
        yield f"  {label:22} {text}"
    for text in warnings:
        yield f"  warning: {text}"


def _run_lines(config: Config, numbers: dict[str, Any]) -> list[tuple[str, str]]:
    """Return label and text of scheme, particles, steps and cost of the run."""
    length, time = config.units.length, config.units.time
    explicit, reliable = numbers["sound_speed"], numbers["samples"][-1].steps_reliable
    largest = "" if explicit else "about " if config.parallel else "at most "
    digits = 4 if explicit else 2
    step = f"{largest}{numbers['time_step']:.{digits}g} {time}, set by the {numbers['binding_limit']} limit"
    steps = _about(numbers["steps"], numbers["steps_range"])
    guessed = "" if reliable else "; how the particles will flow is not known beforehand"
    number = f"{config.particles_across} across"
    if any(config.periodic):
        number = f"{config.rows} across, {config.columns} along"
    spacing, particles, finest = f"{config.spacing:.6g}", str(numbers["particles"]), numbers["smallest_spacing"]
    if finest < config.spacing:
        spacing, number = f"{finest:.6g} to {spacing}", f"{number} where it is largest"
        particles += f"; {numbers['particles_if_finest']} with the smallest spacing everywhere"
    lines = [("scheme", numbers["scheme"])]
    if explicit:
        lines.append(("Mach number", f"{numbers['mach']:.4g}  (peak speed / c)"))
        lines.append(("sound speed c", f"{numbers['sound_speed']:.6g} {length}/{time}"))
    refine = []
    if config.discretisation.refine == "auto":
        least = f"{config.spacing / FINEST:.4g} {length}"
        text = f"about {MORE:g} times the particles, spacings of {least} or more, and up to {FINEST:g} times the steps"
        refine.append(("refine auto", f"numbers here are those of a first run; the run that follows has {text}"))
    return [
        *lines,
        ("particle spacing", f"{spacing} {length} ({number})"),
        ("fluid particles", particles),
        *refine,
        ("time step", step),
        ("steps", f"{steps} from t = {config.start_time:g} to {config.time.end:g} {time}{guessed}"),
        (
            "memory",
            f"about {schema.format_bytes(numbers['memory'])} for the particles, beside that of the program, {PROGRAM}",
        ),
        (
            "run time",
            f"{_total_time(numbers)} in all on two idle cores, with compiling, pictures and movie",
        ),
    ]


def _sample_lines(scene: Scene, samples: Sequence[Any]) -> Iterator[tuple[str, str]]:
    """Yield label and text of every ``SampleEstimate``: whether it is resolved, steps and error, as far as known."""
    for sample in samples:
        steps = _about(sample.steps, sample.steps_range(sample.steps), " steps")
        resolved, state = _resolved(scene, sample)
        parts = [state, steps, *_error_text(sample, ERROR_FACTORS[resolved is True])]
        yield f"at t = {sample.t:g} {scene.units.time}", "; ".join(parts)
    if any(sample.rms is None for sample in samples):
        yield "errors", "no estimate before the run where none is stated; tisph run --estimate-error states one"


def _error_text(sample: Any, factor: float) -> Iterator[str]:
    if sample.rms is not None:
        kind, error, unit = ("rms", sample.rms, " U") if sample.l2 is None else ("L2", sample.l2, "")
        least = "up to" if sample.at_most else f"{error / factor:.0e} to"
        yield f"{kind} error {least} {factor * error:.0e}{unit}"


def _about(number: float, reach: tuple[float, float], unit: str = "") -> str:
    """Return a positive number and its least and largest value as text of two or three digits; an exact one alone."""
    low, high = reach
    if low == high:
        return f"{number:g}{unit}"
    digits = 2 if high > 1.2 * low else 3
    shown = [f"{float(f'{each:.{digits}g}'):.12g}" for each in (number, low, high)]
    return f"about {shown[0]}{unit} ({shown[1]} to {shown[2]})"


def _total_time(numbers: dict[str, Any]) -> str:
    """Return the time of the whole run, in the unit that suits it."""
    seconds, (low, high) = numbers["total_time"], numbers["total_time_range"]
    units = ("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0), ("seconds", 1.0)
    unit, size = next((name, size) for name, size in units if seconds >= 2 * size or size == 1.0)
    return _about(seconds / size, (low / size, high / size), f" {unit}")
