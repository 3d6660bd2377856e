"""Polymer stress in a given velocity field, at every particle, against integration along its own path.

The reference at a particle is exact wherever the particle is: its path is integrated backwards to the start, and the
conformation tensor forwards along it. Two other methods have the tables of shared/reference/viscoelastic.md, part B.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tisph
from tisph.errors import ConfigError
from tisph.exact.eccentric_cylinders import EccentricCylinders

SIDE = 2.0 * math.pi
CYLINDERS = EccentricCylinders(1.0, 2.0, 0.5, 1.0, 0.0)

COMMON = {"output": {"video": None}, "runtime": {"threads": 1}}
FLOWS = {
    "vortices": {
        "scene": "shear_layer",
        "geometry": {"length": SIDE},
        "initial": {"velocity": 1.0, "thickness": SIDE / 24},
        "reference": {"velocity": 1.0},
    },
    "cylinders": {
        "scene": "eccentric_annulus",
        "geometry": {"inner_radius": 1.0, "outer_radius": 2.0, "eccentricity": 0.5},
        "walls": {"inner": {"angular_velocity": 1.0}, "outer": {"angular_velocity": 0.0}},
    },
}


def vortices(x, y):
    return np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)


def gradient_of_vortices(x, y):
    along, across = np.cos(x) * np.cos(y), np.sin(x) * np.sin(y)
    return along, -across, across, -along


def gradient_between_cylinders(x, y, step=2e-3):
    """Return differences of sixth order of the velocity, whose error is 1e-11."""
    weights = {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    by_x = sum(weight * np.array(CYLINDERS.velocity(x + k * step, y)) for k, weight in weights.items()) / step
    by_y = sum(weight * np.array(CYLINDERS.velocity(x, y + k * step)) for k, weight in weights.items()) / step
    return by_x[0], by_y[0], by_x[1], by_y[1]


GIVEN = {"vortices": (vortices, gradient_of_vortices), "cylinders": (CYLINDERS.velocity, gradient_between_cylinders)}


def conformation(flow, relaxation_time, x, y, time, backwards=True):
    """Return x, y, A_xx, A_xy, A_yy at ``time`` on the paths that end at x, y then, or that begin there."""
    velocity, gradient = GIVEN[flow]

    def path(t, state):
        return np.concatenate(velocity(*state.reshape(2, -1)))

    def change(t, state):
        x, y, xx, xy, yy = state.reshape(5, -1)
        a, b, c, d = gradient(x, y)
        stretched = 2 * (a * xx + b * xy), b * yy + c * xx, 2 * (c * xy + d * yy)
        relaxed = ((rest - each) / relaxation_time for rest, each in zip((1, 0, 1), (xx, xy, yy), strict=True))
        return np.concatenate([*velocity(x, y), *(sum(pair) for pair in zip(stretched, relaxed, strict=True))])

    accuracy = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-10}
    start = np.concatenate([x, y])
    if backwards:
        start = solve_ivp(path, (time, 0.0), start, **accuracy).y[:, -1]
    start = np.concatenate([start, np.ones(len(x)), np.zeros(len(x)), np.ones(len(x))])
    return solve_ivp(change, (0.0, time), start, **accuracy).y[:, -1].reshape(5, -1)


@pytest.mark.parametrize(
    ("flow", "relaxation_time", "start", "time", "expected"),
    [
        ("vortices", 0.5, (math.pi / 2, 0.3), 5.0, [1.83853117, 2.83014414, 1.91895226, 0.19071397, 0.72738423]),
        ("vortices", 2.0, (math.pi / 2, 0.05), 10.0, [0.56965855, 3.04879302, 13.24119395, 3.63410148, 2.75817491]),
        ("cylinders", 1.0, (0.5 - 1.3, 0.0), 10.0, [0.5 + 1.04166737, 0.71508210, 5.27382591, -4.44654681, 4.75394439]),
    ],
)
def test_the_reference_is_that_of_two_other_methods(flow, relaxation_time, start, time, expected):
    """The table has the inner axis at the origin and the outer one at (0.5, 0): turned by half a turn, and shifted."""
    x, y = np.array(start)[:, None]
    found = conformation(flow, relaxation_time, x, y, time, backwards=False)[:, 0]
    assert found == pytest.approx(expected, abs=2e-8)


@pytest.mark.parametrize(
    ("flow", "relaxation_time", "across", "time", "gradient", "most"),
    [
        ("vortices", 2.0, 80, 2.0, False, 1e-3),
        ("vortices", 2.0, 32, 2.0, True, 1e-5),
        ("cylinders", 1.0, 16, 0.5, False, 1e-3),
        ("cylinders", 1.0, 16, 0.5, True, 1e-5),
    ],
)
def test_the_stress_of_every_particle_is_that_of_its_path(flow, relaxation_time, across, time, gradient, most):
    """Errors are over the norm of the tensor of the particle; the largest are half of the bounds, or less."""
    velocity, derivatives = GIVEN[flow]
    exact = {"largest_courant": 0.15} if gradient else {}
    config = {
        **FLOWS[flow],
        **COMMON,
        "fluid": {
            "density": 1.0,
            "dynamic_viscosity": 1.0,
            "rheology": {"type": "oldroyd_b", "relaxation_time": relaxation_time, "solvent_fraction": 0.5},
        },
        "discretisation": {"particles_across": across},
        "scheme": {"type": "implicit", **exact},
        "time": {"end": time, "tolerance": 1e-8 if gradient else 1e-7},
    }

    def given(x, y, t):
        return (*velocity(x, y), *derivatives(x, y)) if gradient else velocity(x, y)

    with tisph.Simulation(config, velocity=given) as simulation:
        state = simulation.run_until(time)
    exact = conformation(flow, relaxation_time, state.x, state.y, time)
    found = np.array(state.stress) * relaxation_time / 0.5 + np.array([[1.0], [0.0], [1.0]])
    norm = np.sqrt(exact[2] ** 2 + 2 * exact[3] ** 2 + exact[4] ** 2)
    assert (np.abs(found - exact[2:]).max(axis=0) / norm).max() < most
    assert np.hypot(*(np.array([state.u, state.v]) - velocity(state.x, state.y))).max() < 1e-6


def test_a_given_velocity_leaves_no_place_for_forces_or_bodies_in_flow():
    still = lambda x, y, t: (0.0, 0.0)  # noqa: E731
    config = {**FLOWS["vortices"], **COMMON, "fluid": {"density": 1.0, "dynamic_viscosity": 1.0}, "time": {"end": 1.0}}
    with pytest.raises(ConfigError, match="leave out initial_velocity and body_force"):
        tisph.Simulation(config, velocity=still, body_force=still)
    with pytest.raises(ConfigError, match="two-dimensional flow with scheme implicit"):
        tisph.Simulation(config, velocity=still, scheme={"type": "wcsph"})
