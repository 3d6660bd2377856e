"""Viscometers around an axis and the stress of suspensions, read of numbers that theory makes."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from tisph import cli, scenes
from tisph.config import load
from tisph.config.loader import loaded
from tisph.errors import ConfigError
from tisph.rheometry.rheometers import read
from tisph.rheometry.viscometers import batch_means, rabinowitsch, read_viscometer
from tisph.scenes import of
from tisph.scenes._cell_flow import STRESS_BY_BODIES as BODIES
from tisph.scenes._cell_flow import STRESS_BY_CONTACTS as CONTACTS
from tisph.scenes._cell_flow import STRESS_ON_WALLS as WALLS
from tisph.scenes.sphere_in_tube import wall_factor
from tisph.schemes.implicit.planar.free_bodies import Contact
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Bodies

T = np.linspace(0.0, 2.0, 41)
COMMON = {"name": "viscometer", "fluid": {"density": 1.0, "kinematic_viscosity": 0.7}}
COMMON |= {"discretisation": {"particles_across": 16}, "time": {"end": 2.0, "samples": [2.0]}}


def scene(name, **sections):
    return of(loaded({**COMMON, "scene": name, **sections}, {}))


def constant_history(**values):
    """A history with constant columns; at the start there are no loads."""
    return {"t": T, **{name: np.where(T > 0.0, value, np.nan) for name, value in values.items()}}


def couette(radial=0.0):
    cylinders = {"inner_radius": 1.0, "outer_radius": 2.0, "length": 1.5}
    found = scene("taylor_couette", geometry=cylinders, walls={"inner": {"angular_velocity": 3.0}})
    torque = -2.0 * np.pi * 1.5 * 0.7 * 3.0 * 8.0 / 3.0  # 2 b^2/(b^2 - a^2)
    energies = {"kinetic_energy_radial": radial, "kinetic_energy_azimuthal": 1.0}
    return read_viscometer("taylor_couette", found, constant_history(torque_inner=torque, **energies), {})


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
    reading = read_viscometer("pipe", pipe(), constant_history(force_outer=force), {"mean_velocity": mean})
    assert reading.numbers["viscosity"] == pytest.approx(0.7, rel=1e-12)
    assert reading.numbers["wall_stress"] == pytest.approx(1.0, rel=1e-12)


def test_falling_ball_has_the_factor_of_its_wall():
    assert wall_factor(1e-9) == pytest.approx(1.0, abs=1e-8)
    assert wall_factor(0.5) == pytest.approx(5.947377, rel=5e-3)  # finite elements
    velocity = -0.5 / (6.0 * np.pi * 0.7 * 0.5 * wall_factor(0.5))
    reading = read_viscometer("sphere_in_tube", ball(), constant_history(velocity=velocity), {})
    assert reading.numbers["viscosity"] == pytest.approx(0.7, rel=1e-12)
    assert reading.numbers["reynolds"] == pytest.approx(-velocity * 0.5 / 0.7, rel=1e-12)


def test_what_still_changes_is_called_unsteady():
    table = constant_history(velocity=-0.01) | {"velocity": -0.01 * T}
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
        ("pipe", lambda: pipe(drive={"amplitude": 1.0, "angular_frequency": 2.0}), constant_history(force_outer=1.0)),
        ("sphere_in_tube", lambda: ball(closure="periodic_pressure"), constant_history(velocity=1.0)),
        ("sphere_in_tube", lambda: ball(sphere={"velocity": 1.0}), constant_history(velocity=1.0)),
    ],
)
def test_other_runs_are_refused(name, made, table):
    with pytest.raises(ConfigError):
        read_viscometer(name, made(), table, {"mean_velocity": 1.0})


CASE = """
scene: channel
geometry: {gap: 1.0, length: 2.0}
walls: {bottom: {velocity: -0.5}, top: {velocity: 1.5}}
initial: {state: developed}
fluid: {density: 2.0, kinematic_viscosity: 0.1}
bodies:
- {type: circle, centre: [0.1, 0.3], radius: 0.15, motion: free, force: [0.3, 0.1], torque: 0.2}
- {type: circle, centre: [1.7, 0.45], radius: 0.15}
- {type: ellipse, centre: [0.3, 0.7], half_axes: [0.2, 0.15], angle: 0.5, motion: free, hold: [x, angle]}
discretisation: {particles_across: 20}
time: {end: 1.0, samples: [1.0]}
"""
POWER_LAW = "fluid.rheology={type: power_law, index: 0.8, reference_rate: 1.0, least_rate: 0.01}"
ROUND = "bodies=[{centre: [0.1, 0.3], radius: 0.15, motion: free}, {centre: [1.7, 0.45], radius: 0.15, motion: free}]"
NEAR = 0.2
"""Distance of contact in which each of these bodies pushes both others."""


@pytest.fixture
def make(loader):
    """Return a function that gives config and scene of the case with overrides."""
    config = loader(CASE)
    return lambda *overrides: (config(*overrides), scenes.of(config(*overrides)))


def snapshot_of(config, scene, loads, contact):
    """The start of the run, in which bodies move as the undisturbed fluid at their centres, with loads on them."""
    found = start_snapshot(scene, start_values(scene, config.initial), "f64")
    bodies = Bodies.at(0.0, scene.bodies, np.stack([loads, loads]), contact=contact)
    along = -0.5 + 2.0 * bodies.centre[:, 1]
    return replace(found, bodies=replace(bodies, velocity=np.stack([along, 0.0 * along], axis=1)))


# --- stress


def test_stress_by_bodies_is_that_of_the_balance_of_momentum(make):
    """What the fluid does to bodies gives the stress: forces of contact and from outside are in that already."""
    config, scene = make()
    contact = Contact(scene.bodies, NEAR, 3.0, 0.05).loads([body.at() for body in scene.bodies])[0]
    loads = np.random.default_rng(1).normal(size=contact.shape)
    inertia = scene.bodies[0].motion.inertia
    loads[0, :3] = -contact[0, :3] - inertia.load  # in slow flow all loads on the free freedoms cancel
    loads[2, 1] = -contact[2, 1]
    found = scene.mean_stresses(snapshot_of(config, scene, loads, contact))
    inside, heights = loads[:3], np.array([0.3, 0.45, 0.7]) - 0.5
    total = np.sum(inside[:, 3] - 0.5 * inside[:, 2] + heights * inside[:, 0])
    assert found[BODIES] == pytest.approx(0.2 * 2.0 + total / 2.0, rel=1e-9)  # mu G, and over the area
    assert found[CONTACTS] == pytest.approx(contact[:3, 3].sum() / 2.0)
    assert found[WALLS] == pytest.approx(0.5 * (loads[3, 0] - loads[4, 0]) / 2.0)


def test_stresslets_of_contact_are_those_of_forces_between_centres(make):
    _, scene = make()
    loads = Contact(scene.bodies[:2], NEAR, 3.0, 0.05).loads([body.at() for body in scene.bodies[:2]])[0]
    (along, across), force = np.array([-0.4, 0.15]), loads[0, :2]  # to the other one, through the period
    assert loads[:2, 3].sum() == pytest.approx(0.5 * (along * force[1] + across * force[0]), rel=1e-12)
    assert loads[0, 3] > 0.0  # pressed together along the axis of compression they resist
    assert loads[0, :2] == pytest.approx(-loads[1, :2], rel=1e-12)


def test_fluctuations_carry_momentum(make):
    config, scene = make("bodies=[{centre: [1.0, 0.7], radius: 0.2, motion: free, density: 3.0}]")
    none = np.zeros((3, 4))
    still = snapshot_of(config, scene, none, none)
    moved = replace(still, u=still.u + 0.1, v=still.v + 0.3)
    moved = replace(moved, bodies=replace(moved.bodies, velocity=moved.bodies.velocity + np.array([0.1, 0.3])))
    solid = np.pi * 0.04
    carried = 0.03 * (2.0 * (2.0 - solid) + 3.0 * solid) / 2.0
    assert scene.mean_stresses(still)[BODIES] == pytest.approx(0.4, rel=1e-12)
    assert scene.mean_stresses(moved)[BODIES] == pytest.approx(0.4 - carried, rel=1e-12)


@pytest.mark.parametrize(("changes", "expected"), [
    ((), [WALLS, BODIES, CONTACTS]),
    (("initial.state=rest", "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"),
     [WALLS, BODIES, CONTACTS]),
    (("initial.state=rest", POWER_LAW), [WALLS]),
    (("walls={}", "initial.state=rest"), []),
    (("drive.acceleration=1.0",), []),
    (("bodies=[{centre: [1.0, 0.5], radius: 0.15}]",), []),
])  # fmt: skip
def test_the_history_has_stresses_where_walls_shear_free_bodies(make, changes, expected):
    config, scene = make(*changes)
    assert (
        list(scene.mean_stress_names) == [name for name in scene.time_series().columns if "stress" in name] == expected
    )
    assert set(expected) <= set(scene.flow_quantities)
    if expected:
        known = np.ones((len(scene.bodies), 4))
        state = snapshot_of(config, scene, known, 0.0 * known)
        values = dict(zip(scene.time_series().columns, scene.time_series().measure(state), strict=True))
        assert {name: values[name] for name in expected} == scene.mean_stresses(state)
        assert scene.mean_stresses(state).items() <= scene.diagnostics(state, None).items()


# --- statistics


@pytest.mark.parametrize(("memory", "tolerance"), [(0.0, 0.05), (0.8, 0.2)])
def test_batch_means_know_their_error(memory, tolerance):
    """Of noise in which each value remembers the last: the variance of a mean of n is (1 + m)/(1 - m)/n times its own.

    Two thousand series tell their mean variance to 1 %, and their mean error to 3 %; batches of 40 values that remember
    five are correlated, by which their variance is a tenth too small.
    """
    draw, values = np.random.default_rng(2), np.zeros((2000, 600))
    for k in range(1, 600):
        values[:, k] = memory * values[:, k - 1] + draw.normal(size=2000)
    values = 5.0 + values[:, 197:] * np.sqrt(1.0 - memory**2)
    means, errors = np.array([batch_means(row) for row in values]).T
    variance = (1.0 + memory) / (1.0 - memory) / 400.0
    assert np.mean((means - 5.0) ** 2) == pytest.approx(variance, rel=0.1)
    assert np.mean(errors**2) == pytest.approx(variance, rel=tolerance)


def test_too_few_values_have_no_batches():
    with pytest.raises(ConfigError, match="has 9 lines to average over; there must be 10"):
        batch_means(np.ones(9))


# --- reading


def noisy(viscosity):
    """A history over 401 times, with stresses that are known from its second half on."""
    draw, t = np.random.default_rng(3), np.linspace(0.0, 15.0, 401)
    table = {"t": t, "resolved": np.ones(401)}
    for name, mean in ((WALLS, 1.3), (BODIES, 1.25), (CONTACTS, 0.1)):
        values = viscosity * np.where(t > 7.5, mean + 0.05 * draw.normal(size=401), 9.0)
        table[name] = np.where(t > 0.0, values, np.nan)  # no forces are known at the start
    return table


@pytest.mark.parametrize("turned", [False, True])
def test_viscosity_is_read_with_its_error(make, turned):
    speeds = "walls={bottom: {velocity: 1.5}, top: {velocity: -0.5}}" if turned else "name=plain"
    config, scene = make(speeds, ROUND)
    reading = read(config, scene, noisy(-0.4 if turned else 0.4), 7)
    numbers = reading.numbers
    for way, mean in (("walls", 1.3), ("bodies", 1.25)):
        error = numbers[f"relative_viscosity_{way}_error"]
        assert error == pytest.approx(0.05 / np.sqrt(200), rel=0.7)  # three times what ten batches tell it to, 24 %
        assert numbers[f"relative_viscosity_{way}"] == pytest.approx(mean, abs=4 * 0.05 / np.sqrt(200))
    solid = np.pi * (2 * 0.15**2) / 2.0
    assert numbers["area_fraction"] == pytest.approx(solid, rel=1e-9)
    assert (numbers["strain"], numbers["contacts"]) == (30.0, 7)
    assert numbers["relative_viscosity_contacts"] == pytest.approx(0.1, abs=4 * 0.05 / np.sqrt(200))
    text = "\n".join(reading.lines)
    assert f"1 + 2 phi      {1.0 + 2.0 * solid:.5g}" in text
    assert "contacts in the whole run: 7" in text
    assert "uncertain" not in text


def test_short_runs_are_called_unsure_and_old_ones_have_no_contacts(make):
    config, scene = make(POWER_LAW, "initial.state=rest")
    table = {name: values for name, values in noisy(0.4).items() if name in ("t", WALLS)}
    reading = read(config, scene, {**table, "t": table["t"] / 2.0})
    assert "contacts" not in reading.numbers
    assert reading.lines[-1].startswith("uncertain: each of the 10 batches that give the error has a strain of 0.75")
    assert [curve[1] for curve in reading.curves] == ["by the stress on the walls"]
    assert reading.lines[1].startswith("viscosity over that of the config, mean")


@pytest.mark.parametrize(("change", "known"), [(ROUND, True), ("name=ellipse", False), (POWER_LAW, False)])
def test_einstein_stands_beside_circles_in_a_newtonian_fluid_alone(make, change, known):
    config, scene = make(change, "initial.state=rest")
    names = [curve[1] for curve in read(config, scene, noisy(0.4)).curves]
    assert ("Einstein, 1 + 2φ" in names) == known


@pytest.mark.parametrize("change", [
    "walls={bottom: {velocity: 1.0}, top: {velocity: 1.0}}",
    "walls={bottom: {velocity: 0.0}, top: {amplitude: 1.0, angular_frequency: 1.0}}",
    "drive.acceleration=1.0",
])  # fmt: skip
def test_only_steady_shear_without_a_drive_is_read(make, change):
    config, scene = make(change, "initial.state=rest")
    table = {"t": np.linspace(0.0, 1.0, 401)} | {name: np.ones(401) for name in scene.mean_stress_names}
    with pytest.raises(ConfigError, match="needs walls of different, constant velocities, without a drive"):
        read(config, scene, table)


def test_fixed_bodies_are_no_suspension(make, tmp_path):
    config, _ = make("bodies=[{centre: [1.0, 0.5], radius: 0.15}]")
    (tmp_path / "config.resolved.yaml").write_text(config.resolved_yaml())
    done = CliRunner().invoke(cli.app, ["rheometry", str(tmp_path)])
    assert done.exit_code == 2
    assert "rheometry reads runs in a channel (without bodies, or with free bodies)" in done.stderr


def test_a_ball_has_a_terminal_velocity_in_slow_flow_alone():
    path = Path(__file__).parents[2] / "configs" / "falling_ball.yaml"
    ball = scenes.of(load(path))
    assert ball.terminal_velocity == pytest.approx(-0.5 / (6.0 * np.pi * 0.5 * wall_factor(0.5)), rel=1e-12)
    assert ball.time_series().levels[3] == ball.terminal_velocity
    fast = scenes.of(load(path, ["fluid.kinematic_viscosity=0.1"]))  # U a/nu = 0.45
    assert np.isnan(fast.terminal_velocity)
