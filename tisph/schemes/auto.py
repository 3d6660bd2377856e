"""Automatic choice of the scheme, its order and its step control that reach the requested accuracy fastest.

The implicit scheme of order 4 is faster at every error that both schemes reach, wherever it can serve the config
(``benchmarks``). The remaining choice is the accuracy of its steps.
"""

import math
from collections.abc import Iterator
from typing import Any, Literal

from tisph import registry
from tisph.config.base import Model, Problem
from tisph.config.schema import Config
from tisph.schemes import unsupported, unused

PERIODIC = [(True, False), (True, True), (False, False)]
"""Boxes that the schemes can serve, by whether they are periodic in x and y."""

STEPS = {"fast": (3e-4, 1.5), "balanced": (3e-5, 0.7), "high": (3e-7, 0.5)}
"""Tolerance of a step, and its largest strain, by accuracy."""

ELASTIC_STEPS = {"fast": (1e-4, 1.5), "balanced": (1e-5, 0.7), "high": (3e-7, 0.5)}
"""Tolerance and largest strain in a viscoelastic fluid: viscosity does not damp the errors of steps in its waves."""

TWO_DIMENSIONAL_STEPS = {"fast": (2e-5, 60.0, 2.0), "balanced": (2e-6, 6.0, 1.0), "high": (3e-7, math.inf, 0.15)}
"""In two-dimensional flow: tolerance of a step, bound of tolerance times (particles across)^4, largest Courant number.

With the fourth power errors of steps and of the spacing fall alike. In the Taylor-Green vortex at t = 2 the errors are
4.7e-5 and 3.7e-6 with 50 and 100 across, and 3.0e-5 and 1.3e-6 with ``ERROR_RATIO``."""

UNESTIMATED_COURANT = {"fast": 0.6, "balanced": 0.3, "high": 0.15}
"""Largest Courant number where the error estimate lacks polymer stresses, or paths near a singular corner."""


ERROR_RATIO = 2 / 3
"""Error of balanced steps over the error of the spacing, with which a two-dimensional flow takes least time: its errors
e_t and e_s = e - e_t cost e_s^(-1/2) particles times e_t^(-1/3) steps."""


class Parameters(Model):
    """``accuracy`` of the steps.

    L2 errors in start-up Couette flow at Re 50, 50 particles across: 4e-4 (fast), 7e-5 (balanced) and 2e-6 (high) at
    t* = 0.018, and 1.6e-4, 3.6e-5 and 1.5e-6 at t* = 0.027.
    """

    type: Literal["auto"] = "auto"
    accuracy: Literal["fast", "balanced", "high"] = "balanced"


def problems(config: Config) -> Iterator[Problem]:
    """Yield dotted key and text of everything in a config that the chosen scheme cannot serve."""
    implicit = registry.load("schemes", "implicit")
    if not config.parallel:  # only the implicit scheme is chosen, with either step control
        yield from implicit.problems(config)
        yield from unused(config, "implicit")
        return
    obstacle = _obstacle(config, implicit)
    yield from unused(config, "wcsph" if obstacle else "implicit", obstacle or "")
    if obstacle:
        yield from unsupported(config, "wcsph")
    if obstacle and config.time.tolerance != "auto":
        yield "time.tolerance", f"is for scheme implicit, which cannot be taken here: {obstacle}"


def _obstacle(config: Config, implicit: Any) -> str | None:
    """Return in words why the implicit scheme cannot be chosen; None where it can."""
    if config.time.cfl != "auto":
        return "time.cfl gives a Courant number"
    return next((text.partition(";")[0] for _, text in implicit.problems(config)), None)


def resolve(config: Config) -> tuple[Config, str]:
    """Return the config with the chosen scheme, and the reason in words."""
    implicit = registry.load("schemes", "implicit")
    two_dimensional = not config.parallel
    obstacle = None if two_dimensional else _obstacle(config, implicit)
    if obstacle:
        chosen = registry.load("schemes", "wcsph").Parameters()
        return config.model_copy(update={"scheme": chosen}), f"wcsph, since {obstacle}"
    elastic = config.fluid.rheology.carries_stress
    of_parallel_flow, strain = (ELASTIC_STEPS if elastic else STEPS)[config.scheme.accuracy]
    if two_dimensional:
        tolerance, of_the_spacing, most = TWO_DIMENSIONAL_STEPS[config.scheme.accuracy]
        if elastic or config.singular:
            most = UNESTIMATED_COURANT[config.scheme.accuracy]
        else:
            tolerance = min(tolerance, of_the_spacing / config.particles_across**4)
        if config.flows_through:
            most = min(most, implicit.OPEN_COURANT)
        if config.has_free_bodies or config.flows_through:
            tolerance = of_parallel_flow  # across bodies and steps there are some ten particles, whatever the gap has
    else:
        tolerance, most = of_parallel_flow, strain
    candidate = implicit.Parameters(**{"largest_courant" if two_dimensional else "largest_strain": most})
    time, limit = config.time, f"{'Courant number' if two_dimensional else 'strain'} {most:g}"
    if time.cfl != "auto":
        candidate = implicit.Parameters()
        wanted = f"steps of Courant number {time.cfl:g}"
    elif config.singular:
        wanted = f"{config.scheme.accuracy} accuracy, steps of {limit}"
    else:
        balanced = two_dimensional and config.scheme.accuracy == "balanced" and not config.has_free_bodies
        if balanced and time.tolerance == "auto":
            candidate = candidate.model_copy(update={"error_ratio": ERROR_RATIO})
        time = time if time.tolerance != "auto" else time.model_copy(update={"tolerance": tolerance})
        wanted = f"{config.scheme.accuracy} accuracy, tolerance {time.tolerance:g} and {limit} a step"
    reason = f"implicit, order {candidate.operators.order}: {wanted}"
    return config.model_copy(update={"scheme": candidate, "time": time}), reason
