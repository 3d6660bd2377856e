"""Where the implicit scheme stops or is refused: clustered particles, too short a period, what it cannot serve."""

import numpy as np
import pytest

from tisph import registry
from tisph.errors import ConfigError, DivergedError
from tisph.neighbours.point_cloud import active
from tisph.runtime import view
from tisph.schemes._channel.walls import OBEY_MOMENTUM

pytestmark = pytest.mark.taichi


@pytest.mark.parametrize("order", [2, 4])
def test_clustered_particles_stop_the_run(make, order):
    scheme = make(f"scheme={{type: implicit, operators: {{order: {order}}}}}")
    position = active(scheme.motion.position)
    angle = np.linspace(0, 2 * np.pi, 70, endpoint=False)
    # 70 particles within a fifth of a spacing: more than a row has room for at either order
    position[:70] = 0.5 + 0.1 * scheme.channel.spacing * np.stack([np.cos(angle), np.sin(angle)], 1)
    with pytest.raises(DivergedError, match=r"too many neighbours of a particle .* the particles have clustered"):
        scheme.advance()


def test_a_period_of_less_than_three_cells_is_refused(make):
    short = ("geometry.length=0.5", "discretisation={particles_across: 16, kernel: wendland_c2, smoothing_ratio: 0.8}")
    with pytest.raises(ConfigError, match=r"geometry\.length = 0\.5: must be at least 0\.5625, 9 particle spacings"):
        make("scheme={type: implicit}", *short)


def test_a_vanishing_matrix_is_solved_at_once(make):
    solver = make("scheme={type: implicit}").solver
    right = np.random.default_rng(1).normal(size=solver.points.fluid)
    view(solver.b)[: right.size] = right
    view(solver.x)[...] = 0.0
    assert solver.solve(0.0, 1e-8)
    assert np.array_equal(view(solver.x)[: right.size], right)


def refusal(make, *overrides):
    with pytest.raises(ConfigError) as caught:
        make("scheme={type: implicit}", *overrides)
    return str(caught.value)


@pytest.mark.parametrize("treatment", sorted(set(registry.names("walls")) - set(OBEY_MOMENTUM)))
def test_wall_treatments_without_ghosts_of_this_kind_are_refused(make, treatment):
    text = refusal(make, f"walls.treatment={{type: {treatment}}}")
    assert "walls.treatment.type" in text
    assert treatment in text
    assert all(served in text for served in OBEY_MOMENTUM)
    assert "\n" not in text


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("scheme.equation_of_state", "{type: tait}"),
        ("scheme.artificial_viscosity", "0.1"),
        ("scheme.operators.order", "3"),
        ("scheme.largest_strain", "0"),
        ("time.tolerance", "0"),
    ],
)
def test_meaningless_keys_and_values_are_refused(make, key, value):
    assert key in refusal(make, f"{key}={value}")
