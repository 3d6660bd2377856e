"""Rheometry: moduli, flow curves and step strains read of histories that theory makes, and theory's limits."""

import csv
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from oracles.circular_couette import CircularCouette, Rotation
from typer.testing import CliRunner

import tisph
from tisph import cli, registry, scenes, simulation
from tisph.config.loader import loaded
from tisph.errors import ConfigError
from tisph.exact.heat import ExponentialCouette
from tisph.exact.linear_viscoelasticity import (
    Spectrum,
    apparent_viscosity,
    corrected_viscosity,
    cylinder_apparent_viscosity,
)
from tisph.exact.uniform_shear import UniformShear
from tisph.geometry.motion import Schedule, StressControlledWall, WallMotion
from tisph.report import plots as report
from tisph.rheometry import rheometers, viscometers
from tisph.rheometry.rheometers import (
    _creep,
    _flow_curve,
    _middle,
    _oscillation,
    _slowest_pair,
    _start_up,
    _step_strain,
    _window,
    as_plane,
    read,
    read_schedule,
    together,
)
from tisph.rheometry.viscometers import Reading


@pytest.fixture(autouse=True)
def known_numbers(monkeypatch):
    """Let every reading of this file have no number but the ``NUMBERS`` that a sweep can collect."""

    def checked(title, lines, numbers, curves):
        assert set(numbers) <= rheometers.NUMBERS
        return Reading(title, lines, numbers, curves)

    for module in (rheometers, viscometers):
        monkeypatch.setattr(module, "Reading", checked)


LIQUID = Spectrum(0.1, ((0.6, 1.0), (0.3, 0.1)))
NORMALS = {"inner": 1.01, "inner_exact": 1.0, "outer": 7.0, "outer_exact": 7.0}
"""N1 at cylinders of which the inner one moves, over what theory has there."""


def law_of(spectrum):
    """Upper-convected modes with a spectrum, in uniform shear."""
    law = registry.load("rheology", "oldroyd_b").Parameters
    modes = [law(relaxation_time=time, solvent_fraction=0.1).laws(eta / 0.9)[0] for eta, time in spectrum.modes]
    return UniformShear(lambda rate: spectrum.solvent * rate, tuple(modes))


def plane(gap, wall):
    """What is asked of a channel with a moving wall, of density 1."""
    return SimpleNamespace(
        gap=gap, top=wall, apparent_viscosity=lambda eta, frequency: apparent_viscosity(eta, frequency, 1.0, gap)
    )


def test_an_error_names_the_folder(case, tmp_path):
    (tmp_path / "config.resolved.yaml").write_text(case().resolved_yaml())
    done = CliRunner().invoke(cli.app, ["rheometry", str(tmp_path)])
    assert done.exit_code == 2
    assert done.stderr.startswith(f"error: {tmp_path}: its history has no wall stress")


def test_a_slow_oscillation_shows_the_viscosity_and_a_fast_one_the_solvent():
    assert LIQUID.complex_viscosity(1e-9j) == pytest.approx(LIQUID.viscosity, rel=1e-8)
    assert LIQUID.complex_viscosity(1e9j) == pytest.approx(0.1, rel=1e-7)
    assert LIQUID.apparent_viscosity(1.0, 1e-9, 1.0) == pytest.approx(LIQUID.complex_viscosity(1j), rel=1e-8)


@pytest.mark.parametrize("frequency", [0.1, 1.0, 10.0, 100.0])
def test_inertia_is_taken_off(frequency):
    measured = LIQUID.apparent_viscosity(frequency, 1.0, 0.1)
    theory = LIQUID.complex_viscosity(1j * frequency)
    found = corrected_viscosity(measured, lambda eta: apparent_viscosity(eta, frequency, 1.0, 0.1), 1.2 * theory)
    assert found == pytest.approx(theory, rel=1e-10)


def test_compliance_of_a_fluid_with_one_mode():
    # Jeffreys: J = t/eta + (eta_p lambda/eta^2) (1 - exp(-t eta/(lambda eta_s)))
    liquid, t = Spectrum(0.1, ((0.9, 2.0),)), np.array([0.01, 0.5, 3.0])
    assert liquid.compliance(t) == pytest.approx(t + 1.8 * -np.expm1(-t / 0.2), rel=1e-9)
    assert liquid.growth(1e3) == pytest.approx(1.0)
    assert liquid.normal_stress_growth(1e3) == pytest.approx(2.0 * 0.9 * 2.0)


def test_a_free_wall_on_a_newtonian_fluid_slows_down():
    # heavy: no waves in the liquid, d = eta/(mass gap), less the liquid's own third
    assert Spectrum(1.0).free_oscillation(-0.01, 1.0, 1.0, 100.0) == pytest.approx(-1.0 / (100.0 + 1.0 / 3.0), rel=1e-5)


def test_moduli_are_found_in_a_history_with_a_start():
    frequency, gap = 10.0, 0.1
    wall = WallMotion(0.0, 0.01, frequency)
    t = np.linspace(0.0, 6 * 2 * np.pi / frequency, 401)
    complex_stress = LIQUID.apparent_viscosity(frequency, 1.0, gap) * -0.01j / gap
    stress = (complex_stress * np.exp(1j * frequency * t)).real + 0.02 * np.exp(-t)
    table = {"t": t, "strain": wall.displacement(t) / gap, "wall_shear": stress, "wall_shear_exact": stress}
    numbers = _oscillation(plane(gap, wall), LIQUID, wall, table).numbers
    for name in ("storage_modulus", "loss_modulus"):
        found, theory = (numbers[f"{name}_{kind}"] for kind in ("corrected_for_inertia", "linear_theory"))
        assert found == pytest.approx(theory, rel=1e-4)  # what the polynomial leaves of the start
    assert numbers["third_harmonic"] < 1e-4


def test_large_strains_are_not_blamed_on_inertia():
    frequency, gap = 1.0, 0.1
    wall = WallMotion(0.0, 0.5, frequency)
    t = np.linspace(0.0, 6 * 2 * np.pi / frequency, 401)
    stress = np.cos(t) + 0.2 * np.sin(t) + 0.1 * np.sin(3 * t)
    exact = 0.5 * stress
    table = {"t": t, "strain": wall.displacement(t) / gap, "wall_shear": stress, "wall_shear_exact": exact}
    lines = _oscillation(plane(gap, wall), LIQUID, wall, table).lines
    (off,) = (line for line in lines if "differs from its reference" in line)
    assert "+1.00e+00 of G', +1.00e+00 of G''" in off
    assert not any("inertia" in line for line in lines[5:])


@pytest.mark.parametrize(("periods", "unsure"), [(2, True), (4, False)])
def test_one_period_with_the_start_in_it_is_called_unsure(periods, unsure):
    wall = WallMotion(0.0, 0.01, 6.0)
    t = np.linspace(0.0, periods * 2 * np.pi / 6.0, 201)
    table = {"t": t, "strain": wall.displacement(t), "wall_shear": np.cos(6.0 * t), "wall_shear_exact": np.cos(6.0 * t)}
    lines = _oscillation(plane(1.0, wall), LIQUID, wall, table).lines
    assert any("uncertain" in line for line in lines) == unsure


def read_lines(reading):
    """The rows of the table of a reading: numbers, and whether they are marked."""
    rows = [line.split() for line in reading.lines[2:] if line.split()[0][0].isdigit()]
    return np.array([row[:4] for row in rows], dtype=float), ["not resolved" in " ".join(row) for row in rows]


@pytest.mark.parametrize("before", [None, 20.0])
def test_start_up_and_cessation_without_inertia_are_those_of_the_law(before):
    """A Giesekus fluid at rate 20 ends at the viscosity 1.760; linear theory has 9.997."""
    member = registry.load("rheology", "giesekus")
    laws = member.Parameters(relaxation_time=1.0, solvent_fraction=0.1, mobility=0.2).laws(10.0)
    law, t = UniformShear(lambda rate: 1.0 * rate, laws), np.array([0.0, 1e-3, 0.3, 8.0])
    wall = WallMotion(0.0, before=before) if before else WallMotion(20.0)
    table = {"t": t, "wall_shear": t, "wall_shear_exact": t, "resolved": np.array([0, 0, 1, 1])}
    found, marked = read_lines(_start_up(1.0, law, wall, table))
    assert marked == [True, False, False]
    steady = law.steady(20.0)[0] / 20.0
    # jumps by the solvent at once; the mode relaxes from its steady stress, or grows elastically at first
    expected = (steady - 1.0, 0.0) if before else (1.0 + 9e-3, steady)
    assert found[[0, -1], 3] == pytest.approx(expected, rel=5e-3, abs=5e-3)
    assert steady == pytest.approx(1.760, abs=5e-4)


def test_stress_after_cessation_is_over_the_rate_before():
    t, steady = np.linspace(0.0, 3.0, 31), 0.5 / 0.1
    wall = WallMotion(0.0, before=0.5)
    table = {"t": t, "wall_shear": 1.01 * steady * (LIQUID.viscosity - LIQUID.growth(t))}
    table["wall_shear_exact"] = table["wall_shear"] / 1.01
    numbers = _start_up(0.1, law_of(LIQUID), wall, table).numbers
    left = LIQUID.viscosity - LIQUID.growth(3.0)
    assert numbers["viscosity_at_the_end"] == pytest.approx(1.01 * left)
    assert numbers["viscosity_at_the_end_reference"] == pytest.approx(left)


@pytest.mark.parametrize(("side", "sign"), [(0, -1.0), (1, 1.0)], ids=["bottom", "top"])
def test_the_compliance_is_the_strain_over_the_stress_on_either_wall(side, sign):
    plate, t = StressControlledWall(1.5), np.linspace(0.0, 4.0, 801)
    liquid, name = Spectrum(0.1, ((0.9, 2.0),)), ("bottom", "top")[side]
    strain = 1.5 * liquid.compliance(np.maximum(t, 1e-9))
    rate = 1.5 * (1.0 + 9.0 * np.exp(-t / 0.2))  # of Jeffreys' compliance
    channel = SimpleNamespace(driven_side=side, gap=0.1, **{name: plate})
    table = {"t": t, "strain": sign * 1.01 * strain, f"wall_velocity_{name}_exact": 0.1 * rate}
    numbers = _creep(channel, liquid, table).numbers
    assert numbers["compliance_at_the_end"] == pytest.approx(1.01 * liquid.compliance(4.0), rel=1e-9)
    # a rate with a memory of 0.2, summed in steps of 0.005
    assert numbers["compliance_at_the_end_reference"] == pytest.approx(liquid.compliance(4.0), rel=1e-3)


def test_recovered_strain_counts_from_the_end_of_the_stress():
    plate, t = StressControlledWall(0.0, steps=((0.0, 2.0), (1.0, 0.0))), np.linspace(0.0, 3.0, 31)
    rate = np.where(t <= 1.0, 1.0, -0.25)
    strain = np.where(t <= 1.0, t, 1.0 - 0.25 * (t - 1.0))
    channel = SimpleNamespace(driven_side=1, gap=1.0, top=plate)
    reading = _creep(channel, LIQUID, {"t": t, "strain": strain, "wall_velocity_top_exact": rate})
    assert reading.numbers["compliance_at_the_end"] == pytest.approx(0.5)
    assert reading.numbers["recovered_strain"] == pytest.approx(0.5)
    assert reading.numbers["recovered_strain_reference"] == pytest.approx(0.5, abs=0.1)  # the jump of the rate, summed
    assert any("recovered strain 0.5" in line for line in reading.lines)


def test_free_oscillations_are_found_beside_decaying_terms():
    t = np.linspace(0.0, 10.0, 401)[1:]
    velocity = 1.0 - np.exp(-0.5 * t) * np.cos(1.7 * t) + 0.05 * np.exp(-4.0 * t) * np.cos(9.0 * t)
    assert _slowest_pair(t, velocity) == pytest.approx(-0.5 + 1.7j, rel=1e-8)
    first = 0.1 * np.where(t < 1.0, 1.0 - t, 0.0) ** 2  # what the start leaves in the first tenth
    assert _slowest_pair(t, velocity + first) == pytest.approx(-0.5 + 1.7j, rel=1e-8)


def test_less_than_two_periods_are_refused():
    with pytest.raises(ConfigError, match=r"the run has 1\.\d* periods"):
        _window(np.linspace(0.0, 10.0, 50), 1.0, 0.1)


@pytest.mark.parametrize(("own", "other"), [(1.0, 2.0), (2.0, 1.0)], ids=["inner", "outer"])
def test_cylinders_bear_the_torque_of_the_closed_form(own, other):
    frequency, viscosity, density = 3.0, 0.5, 2.0
    motions = [Rotation(0.0, 1.0, frequency) if radius == own else Rotation(0.0) for radius in (1.0, 2.0)]
    flow = CircularCouette(1.0, 2.0, viscosity / density, *motions)
    torque = flow.settled_torque(1.7, density=density)[0 if own == 1.0 else 1]
    rate = 2 * other**2 / abs(own**2 - other**2)
    factor = cylinder_apparent_viscosity(viscosity, frequency, density, own, other)
    expected = -2 * np.pi * own**2 * rate * (factor * -1j * np.exp(1j * frequency * 1.7)).real
    assert torque == pytest.approx(expected, rel=1e-9)


def test_a_cylinder_is_read_as_a_plane():
    t, inner, outer = np.linspace(0.0, 20.0, 50), WallMotion(0.5), WallMotion(0.0)
    viscosities = {"kinematic_viscosity": 1.0, "dynamic_viscosity": 1.0, "solvent_viscosity": 0.1}
    walls = {"inner_radius": 1.0, "outer_radius": 2.0, "inner": inner, "outer": outer}
    annulus = SimpleNamespace(density=1.0, **walls, **viscosities)
    torque = -4 * np.pi * 0.5 * LIQUID.growth(t) * 4 / 3  # 4 pi W eta a^2 b^2/(b^2 - a^2), as the viscosity grows
    _, wall, table = as_plane(annulus, {"t": t, "torque_inner": torque, "torque_inner_exact": torque})
    assert wall.cosine == pytest.approx(0.5 * 8 / 3)
    assert table["wall_shear"] == pytest.approx(wall.cosine * LIQUID.growth(t))
    growth = wall.cosine**2 * LIQUID.normal_stress_growth(t)
    normal = {f"n1_{name}": factor * growth for name, factor in NORMALS.items()}
    _, wall, table = as_plane(annulus, {"t": t, "torque_inner": torque, "torque_inner_exact": torque, **normal})
    reading = _start_up(1.0, law_of(LIQUID), wall, table)
    known = LIQUID.normal_stress_growth(20.0)
    assert reading.numbers["normal_stress_coefficient_at_the_end"] == pytest.approx(1.01 * known)
    assert reading.numbers["normal_stress_coefficient_at_the_end_reference"] == pytest.approx(known)
    assert any(f"(reference {known:.6g})" in line for line in reading.lines)
    assert [curve[1] for curve in reading.curves[3:5]] == ["run, at the wall that moves", "reference"]
    turned = SimpleNamespace(**{**vars(annulus), "inner": outer, "outer": inner})
    torques = {f"torque_{name}": torque for name in ("inner_exact", "outer", "outer_exact")}
    _, wall, table = as_plane(turned, {"t": t, **torques})
    assert wall.cosine == pytest.approx(0.5 * 2 / 3)  # 2 a^2/(b^2 - a^2), the shear rate at the outer one
    assert table["wall_shear"] == pytest.approx(wall.cosine * LIQUID.growth(t))
    with pytest.raises(ConfigError, match="one moving cylinder"):
        as_plane(SimpleNamespace(**{**vars(annulus), "outer": inner}), {})


def test_the_exact_normal_stress_of_a_channel_is_read_beside_the_found(case):
    fluid = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4}"
    config = case("discretisation.particles_across=12", "initial.state=developed", fluid)
    t, channel = np.linspace(0.0, 1.0, 5), scenes.of(config)
    table = {name: np.ones(5) for name in ("strain", "wall_shear_top", "wall_shear_top_exact", "n1_mean")} | {"t": t}
    numbers = read(config, channel, table).numbers
    known = 2.0 * 0.6 * channel.dynamic_viscosity * 0.5  # Psi_1 = 2 eta_p lambda
    assert numbers["normal_stress_coefficient_at_the_end_reference"] == pytest.approx(known)


def test_the_picture_has_units_and_logarithmic_axes_below_their_legends(tmp_path, monkeypatch):
    wall, t, units = WallMotion(0.5), np.geomspace(0.01, 5.0, 50), SimpleNamespace(length="cm", mass="g", time="s")
    table = {"t": t, "wall_shear": LIQUID.growth(t), "wall_shear_exact": LIQUID.growth(t), "n1": t, "n1_exact": t}
    figures = []
    monkeypatch.setattr(report.style.PlotFigure, "savefig", lambda self, *rest, **others: figures.append(self))
    report.plot_reading(tmp_path / "a.png", "name", _start_up(1.0, law_of(LIQUID), wall, table), units)
    viscosity, normal = figures[0].axes
    assert (viscosity.get_xlabel(), viscosity.get_ylabel()) == ("time [s]", "viscosity growth eta+ [g/(cm s)]")
    assert normal.get_ylabel() == "N1 over the square of the rate [g/cm]"
    assert [line.get_label() for line in normal.lines[:2]] == ["run, at the wall that moves", "reference"]
    for axes in (viscosity, normal):
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        assert axes.get_legend().get_window_extent().y0 >= axes.bbox.y1


SCHEDULED_LIQUID = Spectrum(0.1, ((0.9, 2.0),))
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
    assert stress == pytest.approx(3.0 * SCHEDULED_LIQUID.growth(TIMES), rel=1e-8)
    assert normal == pytest.approx(9.0 * SCHEDULED_LIQUID.normal_stress_growth(TIMES), abs=1e-8 * normal.max())
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
    reading, late = _step_strain(0.1, SCHEDULED_LIQUID, wall, table, (stress, normal)), TIMES > 0.2
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
    ("law", "mean", "tolerance"),
    [
        (lambda: UniformShear(lambda rate: 3.0 * rate), 2.0 * 0.6**2 / (12 * 3.0), 1e-5),
        # power law of index 1/2: n/(2 n + 1) (drive h)^(1/n) h, with half the gap h
        (lambda: UniformShear(np.sqrt), 0.25 * 0.6**2 * 0.3, 1e-4),
        # Bingham: Newtonian times 1 - 3/2 f + 1/2 f^3, f yield stress over that at the wall; regularised to 1e-3 of it
        (
            lambda: UniformShear(lambda rate: rate + 0.2 * (1.0 - np.exp(-1e4 * rate))),
            *(2.0 * 0.6**2 / 12 * (1 - 0.5 + 0.5 / 27), 1e-3),
        ),
        (lambda: uniform(), 2.0 * 0.6**2 / 12, 1e-5),  # the viscosity of Oldroyd-B is constant: 0.1 + 0.9
    ],
)
def test_mean_velocity_between_plates_follows_from_the_flow_curve(law, mean, tolerance):
    """Drive 2, gap 0.6, by hand; tolerances are those of the quadrature, 1e-4, and of the regularisation."""
    assert law().mean_velocity(2.0, 0.6) == pytest.approx(mean, rel=tolerance)


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
    channel = SimpleNamespace(gap=0.1, flow=SimpleNamespace(density=1.0, solvent_viscosity=0.1, dynamic_viscosity=1.0))
    wall = Schedule((0.0, 0.2, 0.2), (0.3, 0.3, 0.0))
    stress, _ = uniform().response(rates(wall, 0.1), TIMES)
    reading = read_schedule(
        config, channel, SCHEDULED_LIQUID, wall, {"t": TIMES, "wall_shear": stress, "wall_shear_exact": stress}
    )
    grown = 0.9 * 3.0 * -np.expm1(-0.1)  # of the rate 3 in the time 0.2
    modulus = grown * np.exp(-(6.0 - 0.2) / 2.0) / 0.6
    assert reading.numbers["modulus_at_the_end_without_inertia"] == pytest.approx(modulus, rel=1e-8)
    assert "  inertia changes it by less than 1% from t = 0.2 on" in reading.lines


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
    law = SimpleNamespace(viscosity=lambda square: 2.0)
    rheology = SimpleNamespace(carries_stress=False, law=lambda *viscosity_and_density: law)
    config = SimpleNamespace(fluid=SimpleNamespace(rheology=rheology))
    channel = SimpleNamespace(gap=1.0, flow=SimpleNamespace(kinematic_viscosity=2.0, density=1.0))
    table = {"t": TIMES, "wall_shear": TIMES, "wall_shear_exact": TIMES}
    assert read_schedule(config, channel, SCHEDULED_LIQUID, Schedule(times, velocities), table).title == title


def runs_of(folder, configs):
    """Run configs of a channel without pictures; return the folders."""
    folders = []
    for name, config in configs.items():
        folders.append(str(folder / name))
        settings = loaded({"name": name, "scene": "channel", "output": {"video": None}, **config}, {})
        simulation.run(settings, Path(folders[-1]), pictures=False, video=False)
    return folders


@pytest.mark.taichi
def test_oscillations_make_one_curve_in_text_json_and_csv(tmp_path):
    """Moduli of two short runs in a narrow gap, as from a file and from Python, and beside the linear theory."""
    fluid = {"density": 1.0, "dynamic_viscosity": 1.0}
    fluid["rheology"] = {"type": "oldroyd_b", "relaxation_time": 0.1, "solvent_fraction": 0.5}
    fixed = {"fluid": fluid, "geometry": {"gap": 0.1, "length": 0.1}, "discretisation": {"particles_across": 10}}
    walls = {each: {"amplitude": 0.01, "angular_frequency": each, "phase": "sin"} for each in (20.0, 10.0)}
    folders = runs_of(
        tmp_path,
        {f"at_{w:g}": {**fixed, "walls": {"top": top}, "time": {"end": 8 * np.pi / w}} for w, top in walls.items()},
    )
    done = CliRunner().invoke(cli.app, ["rheometry", *folders, "--csv", str(tmp_path / "moduli.csv")])
    assert done.exit_code == 0, done.output
    assert "moduli over the angular frequency" in done.output
    assert (tmp_path / "moduli.png").is_file()
    shown = json.loads(CliRunner().invoke(cli.app, ["rheometry", *folders, "--json"]).stdout)
    with open(tmp_path / "moduli.csv", newline="") as file:
        table = list(csv.DictReader(file))
    for folder, numbers, row in zip(folders, shown, table, strict=True):
        assert json.loads((Path(folder) / "rheometry.json").read_text()) == numbers
        assert tisph.open(folder).rheometry().numbers["third_harmonic"] == numbers["third_harmonic"]
        modulus = "storage_modulus_corrected_for_inertia"
        assert float(row[modulus]) == numbers[modulus]
        assert numbers[modulus] == pytest.approx(numbers["storage_modulus_linear_theory"], rel=1e-2)  # 2e-3
    curve = together([tisph.open(folder).rheometry() for folder in folders])
    drawn = next(each for each in curve.curves if "corrected" in each[1])
    assert drawn[2].tolist() == [10.0, 20.0]  # in the order of the frequency


@pytest.mark.taichi
def test_start_ups_make_one_flow_curve(tmp_path):
    """Viscosity and N1 of two short runs in a narrow gap at their ends, beside the law of the fluid."""
    rheology = {"type": "giesekus", "relaxation_time": 0.1, "solvent_fraction": 0.5, "mobility": 0.3}
    fluid = {"density": 0.001, "dynamic_viscosity": 1.0, "rheology": rheology}
    fixed = {"fluid": fluid, "geometry": {"gap": 1.0, "length": 1.25}, "discretisation": {"particles_across": 8}}
    ends = {20: 0.6, 5: 0.1}
    folders = runs_of(
        tmp_path,
        {f"rate_{w}": {**fixed, "walls": {"top": {"velocity": w}}, "time": {"end": t}} for w, t in ends.items()},
    )
    done = CliRunner().invoke(cli.app, ["rheometry", *folders])
    assert done.exit_code == 0, done.output
    table = done.stdout.partition("steady shear\n")[2].splitlines()
    assert table[0].endswith("N1, steady")
    slow, fast = (list(map(float, line.split())) for line in table[1:3])
    assert (slow[0], fast[0]) == (5.0, 20.0)
    assert fast[1] == pytest.approx(fast[2], rel=1e-3)  # after six relaxation times, without inertia
    assert fast[3] == pytest.approx(fast[4], rel=1e-3)
    assert "unsteady at the rate 5:" in table[3]  # it ends after one relaxation time
    assert (tmp_path / "steady_shear.png").stat().st_size > 10_000


HEATED = """
scene: channel
fluid: {density: 1.0, dynamic_viscosity: 1.0}
geometry: {gap: 0.1, length: 0.2}
walls: {top: {times: [0.0, 20.0], velocities: [0.0, 3.0]}}
temperature:
  conductivity: 1.0
  heat_capacity: 1.0
  viscous_heating: true
  walls: {top: 0.0, bottom: 0.0}
  viscosity: {type: exponential, coefficient: 1.0}
time: {end: 20.0}
"""


def test_a_flow_curve_shows_what_heating_takes_from_the_viscosity(tmp_path):
    """Stresses of Nahme's closed form are those of steady flow with heating, to the 1e-9 of its solver."""
    path = tmp_path / "heated.yaml"
    path.write_text(HEATED)
    config, rate = loaded(path, {}), 30.0 * np.linspace(0.0, 1.0, 41)[1:]
    stress = [ExponentialCouette(0.1, 1.0, 1.0, 1.0, 0.1 * float(one)).stress for one in rate]
    table = {"t": rate / 1.5, "wall_shear_top": np.array(stress), "strain": rate}
    reading = read(config, scenes.of(config), table)
    assert reading.numbers["off_reference"] < 1e-8
    assert reading.numbers["nahme_number"] == pytest.approx(9.0)
    assert reading.numbers["lowered_by_heat"] == pytest.approx(1.0 - stress[-1] / 30.0)
    assert {curve[1] for curve in reading.curves} == {"run", "steady flow with heating", "without heating"}
