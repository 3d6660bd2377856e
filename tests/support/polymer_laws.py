"""One liquid of each law of polymers, and states of its particles, for the tests of laws."""

import numpy as np
from scipy.special import lambertw

from tisph import registry
from tisph.measures.flow import PolymerParameters

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
    member = registry.load("rheology", values["type"])
    return member.Law(member.Parameters(**values), viscosity)


def oldroyd_b(relaxation_time, solvent_fraction):
    """What a channel needs to be told of an Oldroyd-B fluid, as keyword arguments."""
    numbers = {"relaxation_time": relaxation_time, "solvent_fraction": solvent_fraction}
    return {
        "polymer": PolymerParameters(**numbers),
        "rheology": registry.load("rheology", "oldroyd_b").Parameters(type="oldroyd_b", **numbers),
    }


LAWS = {kind: law(kind) for kind in KINDS}


def conformation_excess(components, count):
    """Deviations C of positive conformation tensors, shape (components, count), up to a stretch of some 1.5."""
    a, b, c, d = 1 + np.random.default_rng(5).uniform(-0.5, 0.5, (4, count))
    return np.array([a * a + b * b - 2.0, (b - 1) * c, c * c - 1, d * d - 1])[:components]


def giesekus_shear(wi, mobility):
    """C_xx, C_xy, C_yy in steady shear (Giesekus 1982)."""
    part = 8 * mobility * (1 - mobility) * wi**2
    chi = np.sqrt(2 / (np.sqrt(1 + 2 * part) + 1))  # ((1 + 2 part)^(1/2) - 1)/part, without cancellation
    f = (1 - chi) / (1 + (1 - 2 * mobility) * chi)
    viscosity = (1 - f) ** 2 / (1 + (1 - 2 * mobility) * f)
    first = 2 * f * (1 - mobility * f) / (mobility * (1 - f))
    return first - f, viscosity * wi, -f


def least_root(cubic):
    """The real root above 1 of Y^3 - Y^2 = ``cubic``."""
    return max(np.roots([1.0, -1.0, 0.0, -cubic]).real)


def network_shear(wi, y):
    """C_xx, C_xy, C_yy in steady shear of a network of Y = ``y``."""
    return 2 * (wi / y) ** 2, wi / y, 0.0


def fene_shear(wi, extension):
    """C of FENE-P in steady shear: f A = 1 + ..., with f from f^3 - f^2 = 2 Wi^2/L2."""
    f = least_root(2 * wi**2 / extension)
    return (1 + 2 * (wi / f) ** 2) / f - 1, wi / f**2, 1 / f - 1, 1 / f - 1


def steady_shear(kind, wi):
    """C in steady simple shear of the liquids of KINDS, at ``wi`` = relaxation time * rate: closed forms."""
    numbers = KINDS[kind]
    if kind == "giesekus":
        return giesekus_shear(wi, numbers["mobility"])
    if kind == "fene_p":
        return fene_shear(wi, numbers["maximum_extension"])
    if kind == "oldroyd_b":
        return network_shear(wi, 1.0)
    strength = 2 * numbers["extensibility"] * wi**2
    return network_shear(wi, least_root(strength) if kind == "linear_ptt" else np.exp(lambertw(2 * strength).real / 2))
