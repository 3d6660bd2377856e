"""Schemes advance the particles in time. One file each; ``_protocol.py`` lists the members of a scheme.

The constants say which rheologies, ways to drive a wall and wall treatments at bodies the schemes support.
"""

from collections.abc import Iterator, Sequence
from itertools import chain

from tisph import registry
from tisph.config.base import Problem
from tisph.config.schema import Config
from tisph.scenes._scene import Scene
from tisph.schemes._protocol import Scheme, SchemeEstimates, SchemeMember

EXPLICIT_RHEOLOGIES = ("newtonian", "oldroyd_b")
"""Rheologies of the explicit scheme; the implicit scheme serves each that has a ``Law``, and ``multi_mode``."""

AROUND_BODIES = ("adami", "virtual_image", "comoving_image")
"""Wall treatments of the explicit scheme at walls of bodies; the first one where a config names none."""

STRESS_CONTROLLED = [(side, "stress_controlled") for side in ("bottom", "top")]
"""Walls that may be stress-controlled, and the property that is then true."""

SCHEDULED = [(side, "velocities") for side in ("bottom", "top")]
SCHEDULED += [(side, "angular_velocities") for side in ("inner", "outer")]
"""Walls that may have velocities at times, and the key of these velocities."""


def resolve(config: Config) -> tuple[Config, str]:
    """Return the config with the scheme that will run, and the choice and its reason in words."""
    member = registry.load("schemes", config.scheme.type)
    return member.resolve(config) if hasattr(member, "resolve") else (config, config.scheme.type)


def build(config: Config, scene: Scene, targets: Sequence[float], serial: bool) -> Scheme:
    """Return the scheme of a ``resolve``-d config in a ``scene``, with steps that end on the times ``targets`` exactly.

    ``serial`` compiles loops without threads. Here, and not before, Taichi is imported.
    """
    return _member(config).build(config, scene, targets, serial)


def coarsen_steps(config: Config, factor: float) -> Config:
    """Return a ``resolve``-d config with steps ``factor`` times as long for a spacing ``factor`` times as wide.

    Errors in time then fall with the spacing, as errors in space do.
    """
    return _member(config).coarsen_steps(config, factor)


def orders(config: Config) -> tuple[float, float]:
    """Return the least and the largest order in the spacing that counts as observed for a ``resolve``-d config."""
    return _member(config).orders(config)


def estimates(config: Config, scene: Scene) -> SchemeEstimates:
    """Return the estimates of a run of a ``resolve``-d config in a ``scene``."""
    return _member(config).estimates(config, scene)


def _member(config: Config) -> SchemeMember:
    return registry.load("schemes", config.scheme.type)


def unsupported(config: Config, scheme: str) -> Iterator[Problem]:
    """Yield dotted key and text where ``scheme`` cannot serve the rheology of the config, or the motion of a wall."""
    walls = getattr(config, "walls", None)
    slipping = next(iter(config.at_walls("slip_length")), None)
    if slipping and slipping.startswith("walls.") and getattr(config, "ends", None):
        yield f"{slipping}.slip_length", "must be left out with open ends: their profiles have no slip yet"
    if slipping and scheme != "implicit":
        yield "scheme.type", f"{scheme} has no wall with a slip_length ({slipping}); take implicit"
    if scheme != "implicit" and (config.temperature or config.scalars):
        name = "temperature" if config.temperature else "dissolved substance (scalars)"
        yield "scheme.type", f"{scheme} has no {name}; take implicit"
    automatic = ["discretisation.refine"] if config.discretisation.refine == "auto" else []
    varied = next(iter([*config.spacings, *automatic]), None)
    if varied and config.parallel:
        yield varied, "must be left out in parallel flow, whose scheme has one spacing: give more particles across"
    elif varied and scheme != "implicit":
        yield "scheme.type", f"{scheme} has one spacing everywhere ({varied}); take implicit"
    if config.discretisation.growth is not None and not varied:
        yield "discretisation.growth", "does nothing where no body, wall or refined place has a spacing: leave it out"
    kinds = ((STRESS_CONTROLLED, "stress-controlled wall"), (SCHEDULED, "wall with velocities at times"))
    for keys, kind in kinds:
        found = [side for side, key in keys if getattr(getattr(walls, side, None), key, None)]
        if found and scheme != "implicit":
            yield "scheme.type", f"{scheme} has no {kind} (walls.{found[0]}); take implicit"
    walled = not all(config.periodic) or getattr(config, "bodies", None)
    if not config.fluid.inertia and (scheme == "wcsph" or config.parallel or not walled):
        yield "fluid.inertia", "must be true but in two-dimensional flow between walls or past bodies, by implicit"
    elif not config.fluid.inertia and config.singular:
        text = "must be true where the velocity jumps at a corner, from one wall to another or from an inlet to a wall"
        yield "fluid.inertia", text
    elif not config.fluid.inertia and config.has_exact_velocity:
        yield "fluid.inertia", f"must be true in scene {config.scene}, whose reference has inertia"
    name = config.fluid.rheology.type
    if scheme == "wcsph" and name not in EXPLICIT_RHEOLOGIES:
        yield "scheme.type", f"wcsph has no {name} fluid; take implicit"


def unused(config: Config, chosen: str, reason: str = "") -> Iterator[Problem]:
    """Yield dotted key and text of each key without effect where scheme ``chosen`` runs, unless it has its default.

    ``reason``: why scheme ``auto`` does not choose ``implicit``.
    """
    beside = "does nothing beside time.cfl, which sets the steps: leave one of them out"
    found = {}
    if chosen == "wcsph":
        found["scheme.accuracy"] = f"is for scheme implicit, which is not taken here: {reason}"
    else:
        wcsph = registry.load("schemes", "wcsph")
        explicit = config.model_copy(update={"scheme": wcsph.Parameters()})
        able = not any(chain(explicit.problems(), wcsph.problems(explicit)))
        text = "is for scheme wcsph; implicit, which runs here, has no smoothing kernel: leave it out"
        text += ", or give scheme: {type: wcsph}" if able else ""
        found |= {"discretisation.kernel": text, "discretisation.smoothing_ratio": text}
        one, other = ("strain", "courant") if config.parallel else ("courant", "strain")
        found[f"scheme.largest_{other}"] = f"does nothing in this flow, whose steps have a largest_{one}: leave it out"
        if config.parallel:
            found["scheme.error_ratio"] = "is for two-dimensional flow: leave it out"
        if config.time.cfl != "auto":
            found |= {f"scheme.largest_{one}": beside, "scheme.accuracy": beside, "scheme.error_ratio": beside}
            found |= {} if config.parallel else {"time.tolerance": beside}
    for key, text in found.items():
        section, name = key.split(".")
        field = type(getattr(config, section)).model_fields.get(name)
        if field is not None and getattr(getattr(config, section), name) != field.default:
            yield key, text
