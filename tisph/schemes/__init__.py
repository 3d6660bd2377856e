"""Schemes: how the particles are advanced in time. One file each."""

from tisph import registry


def resolve(config):
    """Return the config with the scheme that is to run, and in words which one and why."""
    choose = getattr(registry.load("schemes", config.scheme.type), "resolve", None)
    return choose(config) if choose else (config, config.scheme.type)


def build(config, scene, targets, serial):
    """Return the scheme of a ``resolve``-d config in a ``scene``, with steps that end on the times ``targets`` exactly.

    ``serial`` compiles loops without threads. Here, and not before, Taichi is imported.
    """
    return registry.load("schemes", config.scheme.type).build(config, scene, targets, serial)


def coarsen_steps(config, factor):
    """Return a ``resolve``-d config with steps ``factor`` times as long at a spacing that is ``factor`` times as wide.

    Whatever limits them: so errors in time fall with the spacing, as those in space do.
    """
    change = getattr(registry.load("schemes", config.scheme.type), "coarsen_steps", None)
    return change(config, factor) if change else config


def orders(config):
    """Return the least and the largest order in the spacing that is to be expected of a ``resolve``-d config."""
    return registry.load("schemes", config.scheme.type).orders(config)
