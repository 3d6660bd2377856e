"""Fields that a user gives as functions: in physical components, in every scheme and frame."""

import numpy as np
import pytest

import tisph
from tisph.errors import ConfigError

pytestmark = pytest.mark.taichi

FLUID = {"density": 1.0, "kinematic_viscosity": 0.1}
CIRCLE = {
    "scene": "region",
    "fluid": FLUID,
    "walls": {"around": {"type": "circle", "centre": [0.3, 0.2], "radius": 1.0, "motion": {"angular_velocity": 1.0}}},
    "discretisation": {"particles_across": 20},
    "initial": {"jitter": 0.2},
    "time": {"end": 0.05},
}
CHANNEL = {
    "scene": "channel",
    "fluid": FLUID,
    "geometry": {"gap": 1.0, "length": 1.0},
    "scheme": {"type": "wcsph"},
    "discretisation": {"particles_across": 20},
    "time": {"end": 0.1},
}


def turning(x, y, t):
    """Rigid rotation with the wall of ``CIRCLE``."""
    return 0.2 - y, x - 0.3


def with_divergence(x, y, t):
    """The same and grad (cos x e^y/2 + x^2/5), whose divergence is 0.4, and which goes through the wall."""
    u, v = turning(x, y, t)
    return u - 0.5 * np.sin(x) * np.exp(y) + 0.4 * x, v + 0.5 * np.cos(x) * np.exp(y)


def test_the_divergence_of_an_initial_velocity_is_removed_and_said_so(capsys):
    with tisph.Simulation(CIRCLE, initial_velocity=with_divergence) as sim:
        state = sim.run_until(0.05)
    u, v = turning(state.x, state.y, 0.05)
    # what is left of a gradient of size 1 after projection by operators of order 4: some (spacing)^4, 1e-4
    assert np.hypot(state.u - u, state.v - v).max() < 1e-3
    assert capsys.readouterr().err.count("the divergence of the initial velocity") == 1


def test_nothing_is_said_of_an_initial_velocity_without_divergence(capsys):
    with tisph.Simulation(CIRCLE, initial_velocity=turning) as sim:
        sim.step()
    assert not capsys.readouterr().err


def test_a_body_force_is_at_places_of_the_config_s_frame():
    """Both walls move at one speed: the flow is the one between walls at rest, as a moving frame sees it."""
    wave, found = 2.0 * np.pi, []
    for speed in (0.0, 0.4):

        def force(x, y, t, speed=speed):
            return np.sin(wave * y) * (1.0 + 0.5 * np.cos(wave * (x - speed * t))), 0.0

        walls = {side: {"velocity": speed} for side in ("bottom", "top")}
        change = {"walls": walls, "initial": {"state": "developed"}, "reference": {"velocity": 0.1}}
        with tisph.Simulation({**CHANNEL, **change}, body_force=force) as sim:
            state = sim.run_until(0.1)
        found.append(np.stack([(state.x - speed * state.t) % 1.0, state.y, state.u - speed]))
    # the same steps but for rounding
    assert np.allclose(*found, atol=1e-9)


def test_a_body_force_on_a_wall_is_refused_by_wcsph():
    with (
        pytest.raises(ConfigError, match="must be 0 on walls"),
        tisph.Simulation({**CHANNEL, "reference": {"velocity": 0.1}}, body_force=lambda x, y, t: (1.0, 0.0)) as sim,
    ):
        sim.step()
