"""Four-roll mill of an Oldroyd-B fluid against two methods that share no discretisation.

The flow is that of B. Thomases, M. Shelley, Phys. Fluids 19 (2007) 103103: a periodic square of side 2 pi, density 1,
solvent viscosity 1, polymer viscosity 1/2, from rest, driven by the force (2 sin x cos y, -2 cos x sin y).
"""

import math

import numpy as np
import pytest

import tisph
from tisph.measures.fits import local_fits, periodic_tree

SIDE, NODES, POLYMER = 2 * math.pi, 32, 0.5
STRETCHED = [(0, 0), (math.pi / 4, 0), (math.pi / 2, 0), (0, math.pi / 16), (0, math.pi / 8)]
"""On the line along which fluid leaves the point (0, 0), and beside it."""

FLOWS = {  # relaxation time, time: w = relaxation time du/dx at (0, 0); mean of |u|^2/2; trace of A at the places above
    (0.6, 1.0): (0.435629, 0.132062, [2.51061, 2.31712, 2.02377, 2.47700, 2.38784]),
    (0.6, 2.0): (0.396600, 0.111401, [3.46908, 3.00089, 2.19440, 3.25624, 2.82420]),
    (1.0, 1.0): (0.763676, 0.146082, [2.74966, 2.47156, 2.03992, 2.69768, 2.56096]),
    (1.0, 2.0): (0.686259, 0.121660, [5.31540, 4.31468, 2.53257, 4.70595, 3.58320]),
}


def force(x, y, t):
    return 2 * np.sin(x) * np.cos(y), -2 * np.cos(x) * np.sin(y)


@pytest.mark.parametrize("relaxation_time", [0.6, 1.0])
def test_a_four_roll_mill_stretches_the_polymer_as_two_methods_say(relaxation_time):
    """Errors at 64 across are up to a half of the tolerances, the largest where A grows like exp((2 w - 1) t).

    Energies are means over the square of the velocities that particles interpolate: the mean of the particles
    themselves is up to 3e-3 off, as they lie unevenly by that.
    """
    rheology = {"type": "oldroyd_b", "relaxation_time": relaxation_time, "solvent_fraction": 2 / 3}
    config = {
        "scene": "shear_layer",
        "fluid": {"density": 1.0, "dynamic_viscosity": 1.5, "rheology": rheology},
        "geometry": {"length": SIDE},
        "initial": {"velocity": 1e-9, "thickness": SIDE / 24},
        "reference": {"velocity": 1.0},
        "discretisation": {"particles_across": 64},
        "time": {"end": 2.0},
        "output": {"video": None},
        "runtime": {"threads": 1},
    }
    lattice = np.stack(np.meshgrid(*2 * [(np.arange(NODES) + 0.5) * SIDE / NODES]), axis=-1).reshape(-1, 2)
    with tisph.Simulation(config, body_force=force) as simulation:
        for time in (1.0, 2.0):
            state = simulation.run_until(time)
            tree, _ = periodic_tree(simulation.scene, np.stack([state.x, state.y], axis=1) % SIDE)
            trace = 2.0 + (state.stress[0] + state.stress[2]) * relaxation_time / POLYMER
            fields = np.stack([state.u, state.v, trace], axis=1)
            fits, radius = local_fits(tree, np.array(STRETCHED, dtype=float), fields, 4)
            velocity = local_fits(tree, lattice, fields[:, :2], 4)[0][:, 0]
            w, energy, traces = FLOWS[relaxation_time, time]
            assert 0.5 * np.square(velocity).sum(axis=1).mean() == pytest.approx(energy, rel=2e-4)
            assert relaxation_time * fits[0, 1, 0] / radius[0] == pytest.approx(w, rel=2e-4)
            assert fits[:, 0, 2] == pytest.approx(traces, rel=2e-3)
