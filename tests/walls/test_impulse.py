"""Walls that jump: the impulse that consistent images give, and what it is good for."""

import numpy as np
import pytest

from tisph.measures.channel import wall_shear
from tisph.runtime import view
from tisph.schemes.wcsph._boundaries import ImpulsiveStart

pytestmark = pytest.mark.taichi

CONSISTENT = "walls.treatment.type=consistent_image"
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4}"


def at_start(make, *overrides, **options):
    """Return heights and velocities right after the start, row by row, and the scheme."""
    scheme = make(*overrides, "walls.bottom.velocity=0.0", **options)
    last = scheme.snapshot()
    return last.y, last.u, scheme


def test_only_layers_at_the_impulsively_started_wall_move(make):
    _, u, scheme = at_start(make, CONSISTENT)
    assert scheme.steps == 0
    rows = u.reshape(12, 12)
    assert np.ptp(rows, axis=1).max() < 1e-13
    assert np.abs(rows[:9]).max() < 1e-15  # out of reach of the upper wall's images
    assert 0.2 * 0.5 < rows[11, 0] < 0.3 * 0.5  # 1/4 with three points across, a little else with a wider kernel


def test_displacements_leave_nothing_but_velocities(make):
    scheme = make(CONSISTENT, jitter=0.2)
    particles = scheme.particles
    ImpulsiveStart(scheme.stepper).apply(scheme.now, (0.0, 0.5))
    for field in (particles.mid_pressure, particles.mid_compression):
        assert not view(field)[scheme.now].any()


@pytest.mark.parametrize(
    "overrides",
    [
        (CONSISTENT, "initial.state=developed"),
        (CONSISTENT, "initial={state: exact, time: 0.5}"),
        ("walls.treatment.type=comoving_image",),
    ],
)
def test_no_impulse_without_a_jump_or_consistent_images(make, overrides):
    y, u, scheme = at_start(make, *overrides)
    assert np.array_equal(u, scheme.scene.initial_velocity(y))


def test_the_impulse_counts_as_the_walls(make):
    _, _, scheme = at_start(make, CONSISTENT, jitter=0.2)
    balance = scheme.momentum_balance()
    assert balance["top_wall"] == pytest.approx(balance["change"], rel=1e-12)
    assert balance["change"] > 0


@pytest.mark.parametrize(("moves", "rests"), [("top", "bottom"), ("bottom", "top")])
@pytest.mark.parametrize("memory", [(), (POLYMER,)], ids=["newtonian", "oldroyd_b"])
def test_an_implicit_impulse_counts_as_that_of_its_wall(make, memory, moves, rests):
    walls = f"walls.{moves}.velocity=0.5", f"walls.{rests}.velocity=0.0"
    balance = make("scheme.type=implicit", CONSISTENT, *walls, *memory).momentum_balance()
    assert balance[f"{rests}_wall"] == 0.0
    assert balance[f"{moves}_wall"] == pytest.approx(balance["change"], rel=1e-12)
    assert balance["change"] != 0


def test_a_stopped_wall_gives_the_opposite_impulse(make):
    _, started, _ = at_start(make, CONSISTENT)
    stop = ("walls.top={velocity: 0.0, velocity_before: 0.5}", "initial.state=developed")
    y, stopped, _ = at_start(make, CONSISTENT, *stop)
    assert np.allclose(stopped - 0.5 * y, -started, atol=1e-14)


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_an_impulse_shears_a_polymer_that_is_at_rest(make, jitter):
    # the conformation 1 + S/G of simple shear has det = 1 and A_yy = 1; at the wall S_xy,y = G u_yy = G J/nu_s
    scheme = make(CONSISTENT, POLYMER, "walls.bottom.velocity=0.0", jitter=jitter)
    last, modulus, jump, solvent = scheme.snapshot(), 0.6 * 0.01 / 0.5, 0.5, 0.4 * 0.01
    xx, xy, yy = (1.0 + last.stress_xx / modulus, last.stress_xy / modulus, 1.0 + last.stress_yy / modulus)
    assert xx * yy - xy**2 == pytest.approx(1.0, abs=1e-12)
    assert np.array_equal(yy, np.ones_like(yy))
    reached = last.y > 1.0 - scheme.lists.cutoff
    assert np.all(xy[last.y > 1.0 - 1.0 / 12] > 0.0)
    assert not xy[~reached].any()
    slope = view(scheme.walls.track.slope)[:, :12]
    assert slope[1, :, 1] == pytest.approx(modulus * jump / solvent, rel=1e-12)
    assert not slope[0].any()


def test_an_impulse_stretches_the_stress_of_a_flow_that_stops(make):
    # S -> F (S + G) F^T - G of the developed flow leaves det(S + G), and S_yy = 0
    stop = ("walls.top={velocity: 0.0, velocity_before: 0.5}", "initial.state=developed")
    last = make(CONSISTENT, POLYMER, "walls.bottom.velocity=0.0", *stop).snapshot()
    modulus, strain = 0.6 * 0.01 / 0.5, 0.5 * 0.5  # shear rate times relaxation time
    determinant = (last.stress_xx + modulus) * (last.stress_yy + modulus) - last.stress_xy**2
    assert determinant == pytest.approx(modulus**2 * (1.0 + strain**2), rel=1e-12)
    assert last.stress_xy.max() - last.stress_xy.min() > 0.1 * modulus * strain
    assert not last.stress_yy.any()


def test_the_wall_shear_of_a_viscoelastic_start_has_the_second_order(make):
    # with a stress that starts unchanged the error only halves
    law = "{type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.1}"
    polymer = f"fluid={{density: 1.0, kinematic_viscosity: 1.0, rheology: {law}}}"
    errors = []
    for across in (12, 24):
        scheme = make(CONSISTENT, polymer, f"discretisation.particles_across={across}", "time.end=0.2")
        while not scheme.finished:
            scheme.advance()
        found, exact = wall_shear(scheme.scene, scheme.snapshot()), scheme.scene.exact_wall_shear(0.2)
        errors.append(abs(found[1] / exact[1] - 1.0))
    assert errors[1] < errors[0] / 3.0  # 4 by the second order, less the next terms
