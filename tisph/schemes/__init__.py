"""Schemes: how the particles are advanced in time. One file each; ``_protocol.py`` says what one must have."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tisph import registry

if TYPE_CHECKING:
    from tisph.scenes._scene import Scene
    from tisph.schemes._protocol import Scheme, SchemeEstimates, SchemeMember


def resolve(config: Any) -> tuple[Any, str]:
    """Return the config with the scheme that is to run, and in words which one and why."""
    member = registry.load("schemes", config.scheme.type)
    return member.resolve(config) if hasattr(member, "resolve") else (config, config.scheme.type)


def build(config: Any, scene: "Scene", targets: Sequence[float], serial: bool) -> "Scheme":
    """Return the scheme of a ``resolve``-d config in a ``scene``, with steps that end on the times ``targets`` exactly.

    ``serial`` compiles loops without threads. Here, and not before, Taichi is imported.
    """
    return _member(config).build(config, scene, targets, serial)


def coarsen_steps(config: Any, factor: float) -> Any:
    """Return a ``resolve``-d config with steps ``factor`` times as long for a spacing ``factor`` times as wide.

    Whatever limits them: so errors in time fall with the spacing, as those in space do.
    """
    return _member(config).coarsen_steps(config, factor)


def orders(config: Any) -> tuple[float, float]:
    """Return the least and the largest order in the spacing that is to be expected of a ``resolve``-d config."""
    return _member(config).orders(config)


def estimates(config: Any, scene: "Scene") -> "SchemeEstimates":
    """Return what is known of a run of a ``resolve``-d config in a ``scene`` before it runs."""
    return _member(config).estimates(config, scene)


def _member(config: Any) -> "SchemeMember":
    return registry.load("schemes", config.scheme.type)
