"""Schemes: how the particles are advanced in time. One file each."""

from tisph import families


def resolve(config):
    """Return the config with the scheme that is to run, and in words which one and why."""
    choose = getattr(families.load("schemes", config.scheme.type), "resolve", None)
    return choose(config) if choose else (config, config.scheme.type)
