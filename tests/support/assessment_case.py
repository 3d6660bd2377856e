"""A flow whose results the assessment judges: its config, its reference, and the measure of ``tisph bench``."""

import numpy as np

from tisph.config import load
from tisph.exact import couette

CASE = """
scene: channel
units: {length: m, mass: kg, time: s}
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 1.0}
walls: {top: {velocity: 0.5}}
discretisation: {particles_across: 20}
time: {end: 2.7}
"""

TIME = 2.7


def loaded(folder):
    """The config of the flow, in a ``folder``."""
    (folder / "case.yaml").write_text(CASE)
    return load(folder / "case.yaml")


def exact(y, t=TIME):
    """Exact velocity."""
    return couette.velocity(y, t, gap=1.0, kinematic_viscosity=0.01, bottom=0.0, top=0.5)


def l2(y, u, t=TIME):
    """L2 error of velocities ``u`` at heights ``y``."""
    right = exact(y, t)
    return float(np.sqrt(np.sum((u - right) ** 2) / np.sum(right**2)))
