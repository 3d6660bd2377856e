"""``tisph check``: validate a config and say what its run would be, without running it."""

import itertools
from typing import Any

import typer

from tisph.cli.options import ConfigFile, Overrides

SECONDS_PER_PARTICLE_STEP = 150e-9
"""Rough cost of one particle and step on two threads; only for the estimate that is printed."""

HIGHEST_MACH = 0.1
"""Density varies by about Mach^2: above this the liquid is no longer nearly incompressible."""

HIGHEST_CELL_REYNOLDS = 10.0
"""Runs with a jitter of 0.1 to 0.4 failed from about 20 on, none below."""


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
    typer.echo(f"{loaded.name}: valid ({loaded.scene}, {loaded.scheme.type}, {loaded.walls.treatment.type})")
    numbers = estimates(loaded)
    for label, text in _lines(loaded, numbers):
        typer.echo(f"  {label:22} {text}")
    if numbers["mach"] > HIGHEST_MACH * (1 + 1e-9):
        typer.echo(f"  warning: the Mach number is above {HIGHEST_MACH:g}; expect compressibility errors")
    if numbers["cell_reynolds"] > HIGHEST_CELL_REYNOLDS:
        typer.echo(
            f"  warning: the cell Reynolds number U spacing / nu is {numbers['cell_reynolds']:.3g}; above "
            f"{HIGHEST_CELL_REYNOLDS:g} a disordered flow may push particles through a wall"
        )


def estimates(config: Any) -> dict[str, Any]:
    """Numbers of a run before it runs, in the config's units; memory in bytes, run time in seconds."""
    from tisph.config import memory
    from tisph.equation_of_state import sound_speed
    from tisph.schemes._time_step import effective_viscosity, time_step_limits

    speed, viscosity, gap = config.reference_velocity, config.kinematic_viscosity, config.geometry.gap
    smoothing_length = config.discretisation.smoothing_ratio * config.spacing
    sound = sound_speed(
        config.scheme.equation_of_state,
        reference_velocity=speed,
        kinematic_viscosity=viscosity,
        gap=gap,
        density=config.fluid.density,
    )
    limits = time_step_limits(
        config.time.cfl,
        smoothing_length=smoothing_length,
        sound_speed=sound,
        reference_velocity=speed,
        kinematic_viscosity=effective_viscosity(viscosity, config.scheme.artificial_viscosity, smoothing_length, sound),
    )
    binding = min(limits, key=lambda name: limits[name])
    steps = step_count(config.start_time, [*config.time.samples, config.time.end], limits[binding])
    particles = config.particles_across * config.columns
    return {
        "reynolds": speed * gap / viscosity,
        "mach": speed / sound,
        "cell_reynolds": speed * config.spacing / viscosity,
        "sound_speed": sound,
        "viscous_time": gap**2 / viscosity,
        "particles": particles,
        "time_step": limits[binding],
        "binding_limit": binding,
        "steps": steps,
        "memory": memory.estimated_bytes(particles, config.support),
        "run_time": particles * steps * SECONDS_PER_PARTICLE_STEP,
    }


def step_count(start: float, targets: list[float], longest: float) -> int:
    """Steps no longer than ``longest`` from ``start`` through every target (ascending), each hit exactly."""
    from tisph.schemes._plan import steps_between

    pairs = itertools.pairwise([start, *targets])
    return sum(steps_between(before, after, longest) for before, after in pairs if after > before)


def _lines(config: Any, numbers: dict[str, Any]) -> list[tuple[str, str]]:
    from tisph.config.memory import format_bytes

    length, time = config.units.length, config.units.time
    step = f"{numbers['time_step']:.4g} {time}, set by the {numbers['binding_limit']} limit"
    spacing = f"{config.spacing:.6g} {length} ({config.particles_across} across, {config.columns} along)"
    return [
        ("Reynolds number", f"{numbers['reynolds']:.6g}  (U H / nu)"),
        ("Mach number", f"{numbers['mach']:.4g}  (U / c)"),
        ("wall speed U", f"{config.reference_velocity:.6g} {length}/{time}"),
        ("sound speed c", f"{numbers['sound_speed']:.6g} {length}/{time}"),
        ("kinematic viscosity nu", f"{config.kinematic_viscosity:.6g} {length}^2/{time}"),
        ("viscous time H^2/nu", f"{numbers['viscous_time']:.6g} {time}"),
        ("particle spacing", spacing),
        ("fluid particles", str(numbers["particles"])),
        ("time step", step),
        ("steps", f"{numbers['steps']} from t = {config.start_time:g} to {config.time.end:g} {time}"),
        ("memory", f"about {format_bytes(numbers['memory'])}"),
        ("run time", f"about {_duration(numbers['run_time'])} (estimate, without compiling and video)"),
    ]


def _duration(seconds: float) -> str:
    for name, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {name}"
    return f"{seconds:.2g} s"
