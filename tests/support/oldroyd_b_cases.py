"""Fluids, flows and functions that the tests of the exact Oldroyd-B solution share."""

import numpy as np
from oracles import oldroyd_b
from oracles.oldroyd_b import Flow, Fluid

HEIGHTS = np.linspace(0.0, 1.0, 101)
THIN = Fluid(density=1.0, solvent_viscosity=0.1, polymer_viscosity=0.9, relaxation_time=1.0)
COUETTE, POISEUILLE = Flow(1.0, top=1.0), Flow(1.0, acceleration=1.0)
BOTH = Flow(1.0, bottom=-0.4, top=0.7, acceleration=3.0)
LINEAR = (oldroyd_b.velocity, oldroyd_b.shear_rate, oldroyd_b.shear_stress)
ALL = (*LINEAR, oldroyd_b.normal_stress)
DEVELOPED = (
    oldroyd_b.developed_velocity,
    oldroyd_b.developed_shear_rate,
    oldroyd_b.developed_shear_stress,
    oldroyd_b.developed_normal_stress,
)
# Real and complex eigenvalues, thin and thick fluids; the last one has equal eigenvalues in its first mode.
FLUIDS = [
    THIN,
    Fluid(1.0, 0.01, 0.99, 1.0),
    Fluid(1.0, 0.05, 0.95, 0.1),
    Fluid(1.0, 0.5, 0.5, 0.2),
    Fluid(1.0, 0.9, 0.1, 5.0),
    Fluid(1.0, 0.36, 0.64, 25 / np.pi**2),
]
ACCURACY = 1e-11
"""Accuracy that the module promises, relative to the largest value in the gap."""


def largest_difference(first, second):
    return np.max(np.abs(first - second)) / np.max(np.abs(second))
