"""Regions turned around an axis: spin-up of a closed cylinder, shapes, what other scenes compute, and end plates."""

import numpy as np
import pytest
from case_from_text import to_end
from scipy.special import j1, jn, jn_zeros

pytestmark = pytest.mark.taichi


@pytest.fixture
def run(start_flow):
    """Return a function that runs a config with changes, and returns scene, last snapshot and diagnostics."""

    def whole(name, *changes):
        scene, scheme = start_flow(name, *changes)
        found = to_end(scheme)
        return scene, found, scene.diagnostics(found, ())

    return whole


def spin_up(x, r, t, speed):
    """Swirl in a cylinder of radius 1 and length 2 with nu = 1 that began to turn slowly: w is diffused alone.

    ``speed`` r - w is the product of the solutions between the plates and in the pipe.
    """
    roots, waves = jn_zeros(1, 40)[:, None], 0.5 * np.pi * np.arange(1, 80, 2)[:, None]
    across = np.sum(2.0 / (roots * jn(2, roots)) * j1(roots * r) * np.exp(-(roots**2) * t), axis=0)
    along = np.sum(2.0 / waves * np.sin(waves * x) * np.exp(-(waves**2) * t), axis=0)
    return speed * (r - along * across)


def angular_momentum(t, speed):
    """That of ``spin_up`` of density 1, by Gauss and Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x, r = (part.ravel() for part in np.meshgrid(1.0 + nodes, 0.5 + 0.5 * nodes))
    values = 2.0 * np.pi * r**2 * spin_up(x, r, t, speed)
    return 0.5 * np.sum(np.outer(weights, weights).ravel() * values)


def test_a_closed_cylinder_spins_up_as_its_series_and_its_torques_balance(run):
    """At 16 across 3e-5 and 2e-5 (L2); of fourth order 5e-5."""
    speed = 1e-3
    _, last, _ = run("can", f"turning=[{{wall: around, angular_velocity: {speed}}}]")
    exact = spin_up(last.x, last.y, last.t, speed)
    assert np.linalg.norm(last.w - exact) < 1e-4 * np.linalg.norm(exact)
    change = (angular_momentum(0.05 + 1e-4, speed) - angular_momentum(0.05 - 1e-4, speed)) / 2e-4
    assert -last.bodies.torque.sum() == pytest.approx(change, rel=5e-3)


def test_fluid_in_what_turns_as_a_whole_turns_as_a_solid(run):
    """Of the start at most exp(-14.7 nu t/R^2) is left, 3e-5, as in a long cylinder; u, v have errors of a step."""
    body = "{type: polygon, corners: [[0.8, 0], [1.2, 0], [1.2, 0.6], [0.8, 0.6]], corner_radius: 0.16}"
    turning = "turning=[{wall: around, angular_velocity: 1.0}, {wall: body_0, angular_velocity: 1.0}]"
    _, found, _ = run("can", f"bodies=[{body}]", turning, "time.end=0.7")
    assert np.abs(found.w - found.y).max() < 1e-4
    assert max(np.abs(found.u).max(), np.abs(found.v).max()) < 1e-4


@pytest.mark.parametrize(
    ("other", "region", "names"),
    [
        (
            "end_plates",
            "region_of_end_plates",
            {"inner": "around_3", "outer": "around_1", "left": "around_0", "right": "around_2"},
        ),
        ("turning_sphere", "region_of_a_turning_sphere", {"sphere": "body_0", "tube": "top"}),
    ],
)
def test_loads_are_those_of_the_scene_of_that_shape(run, other, region, names):
    """The same numbers but for rounding, which walls in another order make, over the largest load."""
    own, others = run(region)[2], run(other)[2]
    for kind in ("force", "torque"):
        size = max(abs(others[f"{kind}_{name}"]) for name in names)
        for name, called in names.items():
            assert own[f"{kind}_{called}"] == pytest.approx(others[f"{kind}_{name}"], abs=1e-5 * size)


def test_swirl_beside_walls_that_turn_differently_is_right_away_from_their_corner(run):
    """One end turns slowly, steady: a series. The corner's errors, 0.06 of the wall's speed, fall off in 0.2 to 3e-3,
    16 across; in 0.4 to 3e-4. Torques there have no limit, and balance to the first order of the spacing."""
    scene, found, loads = run("can", "turning=[{wall: around_1, angular_velocity: 0.01}]", "time.end=1.0")
    roots = jn_zeros(1, 400)[:, None]
    depth, along = roots * (2.0 - found.x), np.exp(-2.0 * roots * found.x)
    exact = np.sum(2.0 / (roots * jn(2, roots)) * j1(roots * found.y) * np.exp(-depth) * (1.0 - along), axis=0)
    errors, away = np.abs(found.w / 0.01 - exact), np.hypot(found.x - 2.0, found.y - 1.0)
    assert errors[away > 0.2].max() < 1e-2
    assert errors[away > 0.4].max() < 1e-3
    torques = [loads[f"torque_{name}"] for name in scene.names]
    assert abs(sum(torques)) < 2.0 * scene.spacing * max(map(abs, torques))
    assert not any(name.startswith("torque") for name in scene.flow_quantities)
