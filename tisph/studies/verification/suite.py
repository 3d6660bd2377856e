"""The verification suite as data: which runs, and what each is held to; a module for each kind of flow."""

from tisph.studies.verification import (
    bodies,
    cavity,
    channel,
    circular_couette,
    couette,
    implicit,
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
    two_dimensional_inelastic,
    two_dimensional_polymers,
)


def runs(quick):
    """Configs by run name, as plain dicts: the suite of minutes, or the quick one."""
    return {name: config for part in PARTS for name, config in part.runs(quick).items()}


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    return [criterion for part in PARTS for criterion in part.criteria(quick)]
