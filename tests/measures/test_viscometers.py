"""Viscometers around an axis, read of numbers that theory makes."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph.config.loader import loaded
from tisph.errors import ConfigError
from tisph.measures.viscometers import rabinowitsch, read_viscometer, wall_factor
from tisph.scenes import of

T = np.linspace(0.0, 2.0, 41)
COMMON = {"name": "viscometer", "fluid": {"density": 1.0, "kinematic_viscosity": 0.7}}
COMMON |= {"discretisation": {"particles_across": 16}, "time": {"end": 2.0, "samples": [2.0]}}


def scene(name, **sections):
    return of(loaded({**COMMON, "scene": name, **sections}, {}))


def columns(**values):
    """A history with constant columns; at the start there are no loads."""
    return {"t": T, **{name: np.where(T > 0.0, value, np.nan) for name, value in values.items()}}


def couette(radial=0.0):
    cylinders = {"inner_radius": 1.0, "outer_radius": 2.0, "length": 1.5}
    found = scene("taylor_couette", geometry=cylinders, walls={"inner": {"angular_velocity": 3.0}})
    torque = -2.0 * np.pi * 1.5 * 0.7 * 3.0 * 8.0 / 3.0  # 2 b^2/(b^2 - a^2)
    energies = {"kinetic_energy_radial": radial, "kinetic_energy_azimuthal": 1.0}
    return read_viscometer("taylor_couette", found, columns(torque_inner=torque, **energies), {})


def pipe(**changes):
    sections = {"geometry": {"radius": 0.5, "length": 1.0}, "drive": {"acceleration": 4.0}}
    return scene("pipe", **{**sections, **changes})


def ball(**changes):
    tube = {"tube_radius": 1.0, "sphere_radius": 0.5, "length": 4.0}
    sections = {"geometry": tube, "sphere": {"free": True, "density": 2.0, "force": -0.5}}
    return scene("sphere_in_tube", **{**sections, **changes})


def test_couette_viscometer_finds_the_viscosity():
    assert couette().numbers["viscosity"] == pytest.approx(0.7, rel=1e-12)
    assert not any("vortices" in line for line in couette().lines)
    assert any("vortices" in line for line in couette(radial=1e-3).lines)


def test_capillary_finds_the_viscosity_of_a_parabola():
    force, mean = 4.0 * np.pi * 0.5**2, 4.0 * 0.5**2 / (8.0 * 0.7)
    reading = read_viscometer("pipe", pipe(), columns(force_outer=force), {"mean_velocity": mean})
    assert reading.numbers["viscosity"] == pytest.approx(0.7, rel=1e-12)
    assert reading.numbers["wall_stress"] == pytest.approx(1.0, rel=1e-12)


def test_falling_ball_has_the_factor_of_its_wall():
    assert wall_factor(1e-9) == pytest.approx(1.0, abs=1e-8)
    assert wall_factor(0.5) == pytest.approx(5.947377, rel=5e-3)  # finite elements
    velocity = -0.5 / (6.0 * np.pi * 0.7 * 0.5 * wall_factor(0.5))
    reading = read_viscometer("sphere_in_tube", ball(), columns(velocity=velocity), {})
    assert reading.numbers["viscosity"] == pytest.approx(0.7, rel=1e-12)
    assert reading.numbers["reynolds"] == pytest.approx(-velocity * 0.5 / 0.7, rel=1e-12)


def test_what_still_changes_is_called_unsteady():
    table = columns(velocity=-0.01) | {"velocity": -0.01 * T}
    assert any("unsteady" in line for line in read_viscometer("sphere_in_tube", ball(), table, {}).lines)


def test_rates_of_a_power_law_fluid_are_corrected():
    """Of stress = rate^n the apparent rate is 4 n/(3 n + 1) of the rate at the wall."""
    rates = np.geomspace(0.1, 10.0, 5)
    index = 0.5
    numbers = [{"wall_stress": rate**index, "apparent_rate": rate * 4 * index / (3 * index + 1)} for rate in rates]
    readings = [SimpleNamespace(numbers=each) for each in numbers]
    found = [[float(value) for value in line.split()] for line in rabinowitsch(readings)[1:]]
    assert np.array(found)[:, 1] == pytest.approx(rates, rel=1e-5)  # six digits
    assert rabinowitsch(readings[:2]) == []


@pytest.mark.parametrize(
    ("name", "made", "table"),
    [
        ("pipe", lambda: pipe(drive={"amplitude": 1.0, "angular_frequency": 2.0}), columns(force_outer=1.0)),
        ("sphere_in_tube", lambda: ball(closure="periodic_pressure"), columns(velocity=1.0)),
        ("sphere_in_tube", lambda: ball(sphere={"velocity": 1.0}), columns(velocity=1.0)),
    ],
)
def test_other_runs_are_refused(name, made, table):
    with pytest.raises(ConfigError):
        read_viscometer(name, made(), table, {"mean_velocity": 1.0})
