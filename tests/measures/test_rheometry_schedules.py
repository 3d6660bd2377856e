"""Step strain and flow curves: the law alone against closed forms, and what is read of histories that theory makes."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph import registry
from tisph.exact.linear_viscoelasticity import Spectrum
from tisph.exact.uniform_shear import UniformShear
from tisph.geometry.motion import Schedule
from tisph.measures.rheometry import _flow_curve, _middle, _step_strain, read_schedule

LIQUID = Spectrum(0.1, ((0.9, 2.0),))
TIMES = np.linspace(0.0, 6.0, 61)


def uniform(name="oldroyd_b", **numbers):
    member = registry.load("rheology", name)
    laws = member.Parameters(relaxation_time=2.0, solvent_fraction=0.1, **numbers).laws(1.0)
    return UniformShear(lambda rate: 0.1 * rate, laws)


def rates(wall, gap):
    pieces = [(begin, wall.after(begin)) for begin in (0.0, *wall.jump_times)]
    return [(begin, lambda t, ramp=ramp: ramp.velocity(t) / gap) for begin, ramp in pieces]


def test_a_constant_rate_shows_the_growth_of_stress_and_normal_stress():
    stress, normal = uniform().response([(0.0, lambda t: 3.0 + 0.0 * t)], TIMES)
    assert stress == pytest.approx(3.0 * LIQUID.growth(TIMES), rel=1e-8)
    assert normal == pytest.approx(9.0 * LIQUID.normal_stress_growth(TIMES), abs=1e-8 * normal.max())
    assert uniform().steady(3.0) == pytest.approx((3.0, 2.0 * 0.9 * 2.0 * 9.0), rel=1e-9)


def test_steady_shear_of_a_giesekus_fluid_balances():
    law = uniform("giesekus", mobility=0.3)
    end, state = 120.0, np.zeros(law.laws[0].components)
    _, state = law._solved(lambda t: 5.0, 0.0, end, state, np.zeros(0))
    assert np.abs(law.laws[0].rate_in_shear(tuple(state), 5.0)).max() < 1e-8 * np.abs(state).max()


def normal_curve(reading, name="without inertia"):
    """Ordinates of the curve of N1 with this name."""
    (found,) = (curve[3] for curve in reading.curves if curve[0][1].startswith("N1") and curve[1] == name)
    return found


def test_stress_jumps_with_the_rate_and_conformation_does_not():
    wall = Schedule((0.0, 1.0, 1.0), (0.3, 0.3, 0.0))
    found, _ = uniform().response(rates(wall, 0.1), np.array([0.5, 1.0, 1.0 + 1e-9, 3.0]))
    grown = 0.9 * 3.0 * -np.expm1(-np.array([0.25, 0.5, 0.5]))
    expected = [0.3 + grown[0], 0.3 + grown[1], grown[2], grown[2] * np.exp(-1.0)]
    assert found == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("times", [(0.0, 0.2, 0.2), (0.0, 0.1, 0.2)], ids=["pulse", "triangle"])
def test_a_relaxation_modulus_is_read_from_a_ramp(times):
    wall = Schedule(times, (0.3, 0.3, 0.0) if times[1] == 0.2 else (0.0, 0.6, 0.0))
    strain = wall.displacement(0.2) / 0.1
    assert (strain, _middle(wall)) == pytest.approx((0.6, 0.1))
    law = uniform()
    stress, normal = law.response(rates(wall, 0.1), TIMES)
    table = {"t": TIMES, "wall_shear": 1.01 * stress, "wall_shear_exact": stress, "n1_mean": normal}
    reading, late = _step_strain(0.1, LIQUID, wall, table, (stress, normal)), TIMES > 0.2
    numbers = reading.numbers
    modulus = 0.9 / 2.0 * np.exp(-(6.0 - 0.1) / 2.0)
    # what is left of the ramp is of the second order, (0.2/2)^2/24 of the pulse
    assert numbers["modulus_at_the_end_reference"] == pytest.approx(modulus, rel=5e-4)
    assert numbers["modulus_at_the_end_linear"] == pytest.approx(modulus, rel=1e-12)
    assert numbers["modulus_at_the_end"] == pytest.approx(1.01 * numbers["modulus_at_the_end_reference"], rel=1e-12)
    assert numbers["inertia_gone_at"] == pytest.approx(0.2, abs=1e-9)  # from the first time after the step, less 0.1
    assert normal_curve(reading) == pytest.approx(normal[late] / strain**2)
    # Lodge and Meissner: N1 is strain times shear stress after a sudden strain, to the first order in its duration
    assert numbers["normal_over_shear_stress_at_the_end"] == pytest.approx(strain / 1.01, rel=0.05)


@pytest.mark.parametrize(
    ("flux", "mean", "tolerance"),
    [
        (lambda rate: 3.0 * rate, 2.0 * 0.6**2 / (12 * 3.0), 1e-5),
        # power law of index 1/2: n/(2 n + 1) (drive h)^(1/n) h, with half the gap h
        (lambda rate: np.sqrt(rate), 0.25 * 0.6**2 * 0.3, 1e-4),
        # Bingham: Newtonian times 1 - 3/2 f + 1/2 f^3, f yield stress over that at the wall; regularised to 1e-3 of it
        (lambda rate: rate + 0.2 * (1.0 - np.exp(-1e4 * rate)), 2.0 * 0.6**2 / 12 * (1 - 0.5 + 0.5 / 27), 1e-3),
    ],
)
def test_mean_velocity_between_plates_follows_from_the_flow_curve(flux, mean, tolerance):
    """Drive 2, gap 0.6, by hand; tolerances are those of the quadrature, 1e-4, and of the regularisation."""
    assert UniformShear(flux).mean_velocity(2.0, 0.6) == pytest.approx(mean, rel=tolerance)


def test_mean_velocity_of_an_oldroyd_b_fluid_is_the_newtonian_one():
    """Its viscosity is constant: 0.1 of the solvent and 0.9 of the polymer."""
    assert uniform().mean_velocity(2.0, 0.6) == pytest.approx(2.0 * 0.6**2 / 12, rel=1e-5)


def test_a_flow_curve_tells_inertia_from_relaxation():
    gap, density = 0.1, 1.0
    wall = Schedule((0.0, 6.0), (0.0, 1.2))
    law = UniformShear(lambda rate: 2.0 * rate)
    alone, normal = law.response(rates(wall, gap), TIMES)
    inertia = density * 0.2 * gap / 3.0  # of a steady ramp: the third of the liquid follows the wall
    table = {"t": TIMES, "wall_shear": alone + inertia, "wall_shear_exact": alone + inertia}
    numbers = _flow_curve(gap, law, wall, table, (alone, normal)).numbers
    assert numbers["fastest_rate"] == pytest.approx(12.0)
    assert numbers["off_reference"] == 0.0
    assert numbers["off_by_inertia"] == pytest.approx(inertia / (2.0 * 1.2), rel=1e-9)  # at a tenth of it
    assert numbers["off_by_memory"] == pytest.approx(0.0, abs=1e-14)


def test_a_flow_curve_of_a_viscoelastic_fluid_shows_its_normal_stress():
    wall, law = Schedule((0.0, 6.0), (0.0, 1.2)), uniform()
    stress, normal = law.response(rates(wall, 0.1), TIMES)
    table = {"t": TIMES, "wall_shear": stress, "wall_shear_exact": stress, "n1_mean": 1.01 * normal}
    reading = _flow_curve(0.1, law, wall, table, (stress, normal))
    assert normal_curve(reading, "run, mean of the gap") == pytest.approx(1.01 * normal)
    assert normal_curve(reading) == pytest.approx(normal)
    curve = np.linspace(0.0, 12.0, 101)
    assert normal_curve(reading, "steady shear") == pytest.approx(2.0 * 0.9 * 2.0 * curve**2)
    (steady,) = (drawn[3] for drawn in reading.curves if drawn[0][1].startswith("shear") and drawn[1] == "steady shear")
    assert steady == pytest.approx((0.1 + 0.9) * curve)


def test_the_law_alone_has_the_wall_motion_in_the_whole_gap():
    member = registry.load("rheology", "oldroyd_b").Parameters(relaxation_time=2.0, solvent_fraction=0.1)
    config = SimpleNamespace(fluid=SimpleNamespace(rheology=member))
    channel = SimpleNamespace(gap=0.1, density=1.0, solvent_viscosity=0.1, dynamic_viscosity=1.0)
    wall = Schedule((0.0, 0.2, 0.2), (0.3, 0.3, 0.0))
    stress, _ = uniform().response(rates(wall, 0.1), TIMES)
    reading = read_schedule(
        config, channel, LIQUID, wall, {"t": TIMES, "wall_shear": stress, "wall_shear_exact": stress}
    )
    grown = 0.9 * 3.0 * -np.expm1(-0.1)  # of the rate 3 in the time 0.2
    modulus = grown * np.exp(-(6.0 - 0.2) / 2.0) / 0.6
    assert reading.numbers["modulus_at_the_end_without_inertia"] == pytest.approx(modulus, rel=1e-8)
    assert "  inertia makes less than 1% from t = 0.2 on" in reading.lines


@pytest.mark.parametrize(
    ("times", "velocities", "title"),
    [
        ((0.0, 0.1, 0.1), (1.0, 1.0, 0.0), "step strain"),
        ((0.0, 4.0), (1.0, 0.0), "flow curve"),
        ((0.0, 0.5, 4.0), (0.0, 1.0, 0.0), "flow curve"),
        ((0.0, 0.1), (1.0, 2.0), "flow curve"),
        ((0.0, 0.1, 0.1, 0.2, 0.2), (1.0, 1.0, -1.0, -1.0, 0.0), "flow curve"),
    ],
    ids=["held", "not held for as long", "slows down for long", "goes on", "there and back"],
)
def test_a_wall_that_rests_longer_than_it_moves_is_step_strain(times, velocities, title):
    config = SimpleNamespace(fluid=SimpleNamespace(rheology=SimpleNamespace(carries_stress=False)))
    channel = SimpleNamespace(gap=1.0, viscous_stress=lambda rate: 2.0 * rate)
    table = {"t": TIMES, "wall_shear": TIMES, "wall_shear_exact": TIMES}
    assert read_schedule(config, channel, LIQUID, Schedule(times, velocities), table).title == title
