"""One liquid of each law of polymers, and states of its particles, for the tests of laws."""

import numpy as np

from tisph import families

VISCOSITY, TIME = 0.7, 1.5
KINDS = {
    "oldroyd_b": {"type": "oldroyd_b"},
    "giesekus": {"type": "giesekus", "mobility": 0.3},
    "linear_ptt": {"type": "phan_thien_tanner", "extensibility": 0.25},
    "exponential_ptt": {"type": "phan_thien_tanner", "extensibility": 0.25, "form": "exponential"},
    "fene_p": {"type": "fene_p", "maximum_extension": 20.0},
}


def law(kind, viscosity=VISCOSITY, **other):
    """The law of one of KINDS, with ``other`` numbers; with relaxation time TIME where none is given."""
    values = {"relaxation_time": TIME, "solvent_fraction": 0.5, **KINDS[kind], **other}
    member = families.load("rheology", values["type"])
    return member.Law(member.Parameters(**values), viscosity)


LAWS = {kind: law(kind) for kind in KINDS}


def deviations(components, count):
    """Deviations C of positive conformation tensors, shape (components, count), up to a stretch of some 1.5."""
    a, b, c, d = 1 + np.random.default_rng(5).uniform(-0.5, 0.5, (4, count))
    return np.array([a * a + b * b - 2.0, (b - 1) * c, c * c - 1, d * d - 1])[:components]
