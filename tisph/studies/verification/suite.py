"""The verification suite as data: which runs, and what each is held to; a module for each kind of flow."""

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.studies.verification import (
    axisymmetric,
    bodies,
    cavity,
    cavity_long,
    channel,
    circular_couette,
    couette,
    free_bodies,
    free_bodies_long,
    implicit,
    manufactured,
    rheologies,
    rheometry,
    two_dimensional,
    two_dimensional_inelastic,
    two_dimensional_polymers,
    viscoelastic,
)

RESUMED = "_resumed"
"""End of the name of a run that is ended on the way and resumed."""

PARTS = (
    couette,
    channel,
    viscoelastic,
    rheologies,
    rheometry,
    implicit,
    two_dimensional,
    circular_couette,
    cavity,
    bodies,
    free_bodies,
    axisymmetric,
    two_dimensional_inelastic,
    two_dimensional_polymers,
)

ALONE = {"manufactured": manufactured}
"""Parts that run when they are asked for by name, and not with the others: they need sympy."""

LONG = {"cavity": cavity_long, "free_bodies": free_bodies_long}
"""Parts of runs that take minutes each, by the name of the short one."""


def names():
    """Names of the parts."""
    return [*(part.__name__.rpartition(".")[2] for part in PARTS), *ALONE]


def one(name, quick=False, long=False):
    """Runs and criteria, as ``runs`` and ``criteria``, of the part ``name``: all, the quick or the long ones.

    Raises ConfigError where there is no such part, or it has none of those.
    """
    if name not in names():
        raise ConfigError(f"no suite {name!r}{nearest(name, names())}; there are {', '.join(names())}")
    if not long:
        part = ALONE[name] if name in ALONE else PARTS[names().index(name)]
        return part.runs(quick), part.criteria(quick)
    if name not in LONG:
        raise ConfigError(f"--long: {name} has no runs of minutes; those that have: {', '.join(LONG)}")
    return LONG[name].runs(), LONG[name].criteria()


def runs(quick):
    """Configs by run name, as plain dicts: the suite of minutes, or the quick one."""
    return {name: config for part in PARTS for name, config in part.runs(quick).items()}


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    return [criterion for part in PARTS for criterion in part.criteria(quick)]
