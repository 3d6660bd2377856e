"""Conditions between keys that hold in every scene: samples inside the run, a movie that can be read, a size to fit."""

from collections.abc import Iterator
from typing import Any

from tisph import registry
from tisph.config import memory, resolution
from tisph.config.base import Problem, refusals
from tisph.config.fields import nearest


def raise_problems(config: Any) -> None:
    """Raise one ValidationError with all problems of the validated config, if there are any."""
    found = []
    for key, text, *others in problems(config):
        place, *blamed = map(_place, (key, *others))
        found.append((place, text, _value(config, place), *blamed))
    if found:
        raise refusals(found)


def _place(key: str) -> tuple[str | int, ...]:
    return tuple(int(part) if part.isdigit() else part for part in key.split("."))


def problems(config: Any) -> Iterator[Problem]:
    """Every condition between keys that the config breaks, those of its scene among them."""
    yield from config.problems()
    yield from _times(config)
    yield from _video(config)
    yield from _members(config)
    yield from _scheme(config)
    too_large = list(_size(config))
    yield from too_large or resolution.problems(config)


def _value(config: Any, location: tuple[str | int, ...]) -> Any:
    for part in location:
        config = config[part] if isinstance(part, int) else getattr(config, part)
    return config


def _times(config: Any) -> Iterator[Problem]:
    start, end, samples = config.start_time, config.time.end, config.time.samples
    if config.singular and config.time.tolerance != "auto":
        text = "is not allowed where walls meet that slide past each other: what passes there has no error to speak of"
        yield "time.tolerance", f"{text}; give time.cfl, or scheme.accuracy"
    if not end > start:
        yield "time.end", f"must be after the start of the run at {start:g}"
        return
    for index, sample in enumerate(samples):
        if not start <= sample <= end:
            yield f"time.samples.{index}", f"must be inside the run, {start:g} to {end:g}"
        elif index and not sample > samples[index - 1]:
            yield (
                f"time.samples.{index}",
                f"must be greater than the sample before it, {samples[index - 1]:g}",
            )


def _video(config: Any) -> Iterator[Problem]:
    video = config.output.video
    if video and not 0.5 <= video.width / video.height <= 5:
        text = f"{video.width} x {video.height} leaves no room for words that can be read"
        yield "output.video", f"{text}: width must be 0.5 to 5 times the height"
    names = colours(config)
    if video and video.color_by not in names:
        *others, last = map(repr, names)
        yield "output.video.color_by", f"must be {', '.join(others)} or {last}{nearest(video.color_by, names)}"
    if video and video.limits != "auto" and not video.limits[0] < video.limits[1]:
        yield "output.video.limits", "must be auto, or the lower limit and then the higher one"


def colours(config: Any) -> list[str]:
    """What a movie of the validated ``config`` may be coloured by."""
    rheology, names = config.fluid.rheology, ["speed", "u"]
    if not config.parallel:
        names += ["v", "vorticity", "pressure"]
    if config.axisymmetric:
        names += ["swirl", "stream_function"]
    if rheology.carries_stress:
        names += ["shear_stress", "normal_stress_difference"]
        names += ["conformation_trace"] if getattr(rheology, "linear_stress", False) else []
    elif rheology.type == "newtonian" and not config.parallel and not config.axisymmetric:
        names.append("shear_stress")
    return [*names, *(["error"] if config.has_exact_velocity else []), "dye"]


def _members(config: Any) -> Iterator[Problem]:
    """What the chosen members of the registry say: each may have a function ``problems(config)``."""
    for family, parameters in config.members.items():
        yield from _said_by(family, parameters.type, config)


def _said_by(family: str, name: str, config: Any) -> Iterator[Problem]:
    find = getattr(registry.load(family, name), "problems", None)
    return find(config) if find else iter(())


def _scheme(config: Any) -> Iterator[Problem]:
    """What the scheme says, where it can have a box that is periodic as that of the scene is.

    Which boxes a scheme can have is its literal ``PERIODIC``, pairs for x and y as in ``Config.periodic``.
    """
    chosen = config.scheme.type
    if config.periodic in _boxes(chosen):
        yield from _said_by("schemes", chosen, config)
        return
    able = [name for name in registry.names("schemes") if config.periodic in _boxes(name)]
    if able:
        yield "scheme.type", f"has no box as that of {config.scene}; take {' or '.join(able)}"
    else:
        yield "scene", "no scheme can run it yet: they all need walls"


def _boxes(scheme: str) -> list[tuple[bool, bool]]:
    return registry.constant("schemes", scheme, "PERIODIC")


def _size(config: Any) -> Iterator[Problem]:
    across = resolution.across(config)
    particles = across * (across * (config.area / config.across / config.across))
    needed = memory.estimated_bytes(particles, config, config.scheme.type != "wcsph")
    available = memory.physical_bytes()
    key = resolution.resolution_key(config)
    text = f"makes {particles:.3g} particles, which would need about {memory.format_bytes(needed)} of memory"
    if particles > memory.MOST_PARTICLES:
        yield key, f"{text}; at most {memory.MOST_PARTICLES} particles are allowed"
    elif available and needed > available:
        yield key, f"{text}; this machine has {memory.format_bytes(available)}"
