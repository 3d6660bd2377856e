"""Temperature and dissolved substances in a parallel channel: against exact flows, with all walls and fluids."""

import numpy as np
import pytest
from implicit_case import channel_of, layers, start_of_layers
from same_bits import check_substances

import tisph
from tisph.errors import ConfigError, DivergedError
from tisph.exact import heated_shear
from tisph.exact.heat import Conduction, ExponentialCouette, Wall
from tisph.schemes.implicit.channel.heat import mixed
from tisph.schemes.implicit.channel.models import ThermalModel, model_of

pytestmark = pytest.mark.taichi

CASE = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 1.0}
geometry: {gap: 1.0, length: 1.0}
discretisation: {particles_across: 25}
scheme: {type: implicit}
time: {end: 4.0}
runtime: {threads: 1}
"""
SMALL = {
    "name": "heat",
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 1.0},
    "geometry": {"gap": 1.0, "length": 1.0},
    "discretisation": {"particles_across": 12},
    "scheme": {"type": "implicit"},
    "time": {"end": 2.0},
    "output": {"video": None},
    "runtime": {"threads": 1},
}
CONDUCTING = {"conductivity": 1.0, "heat_capacity": 1.0}
HEATED = {**CONDUCTING, "viscous_heating": True, "walls": {"bottom": 0.0, "top": 0.0}}
COUETTE = {"top": {"velocity": 1.0}}
POLYMER = {"type": "oldroyd_b", "relaxation_time": 0.3, "solvent_fraction": 0.3}


def exponential(coefficient, **more):
    """Section temperature of a fluid that heats itself, with the viscosity exp(-coefficient T)."""
    return {**HEATED, "viscosity": {"type": "exponential", "coefficient": coefficient}, **more}


def text(section):
    """An override that sets the section temperature."""
    return f"temperature={section}".replace("'", '"').replace("True", "true")


@pytest.fixture
def steady(tmp_path):
    """Return a function that returns heights, velocities and temperatures of layers at the end of a run."""

    def run(section, *overrides):
        found = layers(*channel_of(tmp_path, CASE, [text(section), *overrides]))
        assert not found.unknown
        return found.heights, found.velocity, found.flow.substances[0]

    return run


def at_end(**sections):
    """Snapshot of particles at the end of a run of ``SMALL`` with other ``sections``."""
    with tisph.Simulation({**SMALL, **sections}) as simulation:
        return simulation.run_until(simulation.config.time.end).snapshot


def differs(values, exact):
    """Largest difference of ``values``, over the range of the ``exact`` ones."""
    return np.abs(values - exact).max() / np.ptp(exact)


@pytest.mark.parametrize("bottom", [0.0, {"flux": 0.0}], ids=["given", "insulated"])
def test_slab_heats_up_by_conduction(tmp_path, bottom):
    """The start is an impulse; measured: 8.5e-5 where the layer has 3.5 spacings, then 2e-6 and 1e-6."""
    section = {**CONDUCTING, "walls": {"bottom": bottom, "top": 1.0}}
    settings, channel = channel_of(tmp_path, CASE, [text(section), "time={end: 0.5, samples: [0.02, 0.1]}"])
    exact = Conduction((0.0, 1.0), (Wall(None if bottom else 0.0), Wall(1.0)), 1.0)
    found = start_of_layers(settings, channel)
    for time, bound in ((0.02, 2e-4), (0.1, 5e-6), (0.5, 3e-6)):
        found.run_to(time)
        assert differs(found.flow.substances[0], exact.temperature(found.heights, time)) < bound
        assert not found.velocity.any()


@pytest.mark.parametrize("flow", ["walls.top.velocity=1.0", "drive.acceleration=12.0"])
def test_viscous_heating_is_a_polynomial_that_images_continue(steady, flow):
    """Degrees 2 and 4: with the heat's curvature in the images both are exact but for residuals of steps (1e-10)."""
    y, u, values = steady(HEATED, flow)
    exact = 0.5 * y * (1 - y) if "walls" in flow else 0.75 * (1 - (2 * y - 1) ** 4)
    assert differs(values, exact) < 1e-8
    assert differs(u, y if "walls" in flow else 6 * y * (1 - y)) < 1e-8


# measured in u and T: 8e-8, 8e-7; 1.8e-6, 1.1e-5; 3.8e-5, 9.0e-5, of order 4 in the spacing
@pytest.mark.parametrize(("nahme", "bound"), [(1.0, 1e-6), (5.0, 2e-5), (20.0, 1.5e-4)])
def test_exponential_viscosity_heats_and_thins(steady, nahme, bound):
    y, u, values = steady(exponential(nahme), "walls.top.velocity=1.0", "time.end=10.0")
    exact = ExponentialCouette(1.0, 1.0, 1.0, nahme, 1.0)
    assert differs(u, exact.velocity(y)) < bound
    assert differs(values, exact.temperature(y)) < bound


def test_absolute_temperatures_and_arrhenius(steady):
    section = {**HEATED, "conductivity": 2.5, "initial": 1.0, "reference": 1.0, "walls": {"bottom": 1.0, "top": 1.0}}
    law = {"type": "arrhenius", "activation_temperature": 5.0}
    y, u, values = steady({**section, "viscosity": law}, "walls.top.velocity=1.0")
    places = [0.25, 0.5, 0.75]
    assert np.interp(places, y, u) == pytest.approx([0.23677349, 0.5, 0.76322651], abs=1e-4)  # of the line between
    assert values.max() == pytest.approx(1.0447652, abs=1e-6)


@pytest.mark.parametrize("insulated", [False, True])
def test_flows_with_exponential_viscosity_follow_the_exact_solution(tmp_path, insulated):
    """Start-up with heating, of slip_layers_heat.md with Pr = 2. Measured: 1.0e-4 in u, 2.2e-4 in 5 T, at 0.1."""
    walls = {"bottom": {"flux": 0.0} if insulated else 0.0, "top": 0.0}
    section = {**exponential(5.0), "heat_capacity": 2.0, "walls": walls}
    ramp = "walls.top={times: [0.0, 0.1], velocities: [0.0, 1.0]}"
    settings, channel = channel_of(tmp_path, CASE, [text(section), ramp, "time={end: 0.3, samples: [0.1]}"])
    sides = heated_shear.Wall(None if insulated else 0.0), heated_shear.Wall(0.0, speed=lambda t: min(10.0 * t, 1.0))
    flow = heated_shear.HeatedShear((0.0, 1.0), sides, lambda t, _rate: np.exp(-5.0 * t), 1.0, heat_capacity=2.0)
    exact, found = heated_shear.StartUp(flow, breaks=[0.1]), start_of_layers(settings, channel)
    for time in (0.1, 0.3):
        found.run_to(time)
        profiles, y = exact.at(time), found.heights
        assert np.abs(found.velocity - profiles.velocity(y)).max() < 2e-4
        assert 5.0 * np.abs(found.flow.substances[0] - profiles.temperature(y)).max() < 4e-4


@pytest.mark.parametrize("law", [None, {"type": "exponential", "coefficient": 1.0}], ids=["constant", "exponential"])
def test_buoyancy_drives_a_vertical_channel(steady, law):
    """Measured: 1e-11 with constant viscosity, else 6e-7, 5e-5 of the largest velocity."""
    section = {**CONDUCTING, "expansion": 1.0, "gravity": [-1.0, 0.0], "walls": {"bottom": -0.5, "top": 0.5}}
    y, u, values = steady({**section, "viscosity": law} if law else section)
    assert values == pytest.approx(y - 0.5, abs=1e-8)
    sides = heated_shear.Wall(-0.5), heated_shear.Wall(0.5)
    viscosity = lambda t, _rate: np.exp(-t) if law else np.ones_like(t)  # noqa: E731
    flow = heated_shear.HeatedShear((0.0, 1.0), sides, viscosity, 1.0, buoyancy=1.0, heating=False)
    assert u == pytest.approx(flow.steady().velocity(y), abs=2e-6 if law else 1e-9)


def test_stress_of_a_wall_finds_the_cold_flow(steady):
    y, u, values = steady(exponential(2.0), "walls.top.shear_stress=1.0", "time.end=10.0")
    exact = ExponentialCouette.of_stress(1.0, gap=1.0, viscosity=1.0, conductivity=1.0, coefficient=2.0)
    assert exact.speed == pytest.approx(1.2482175)
    assert differs(u, exact.velocity(y)) < 2e-5  # measured: 7e-6
    assert differs(values, exact.temperature(y)) < 4e-5  # measured: 1.8e-5


@pytest.mark.slow
@pytest.mark.parametrize(("stress", "goes_on"), [(3.512, False), (3.516, True)])
def test_largest_stress_of_a_steady_flow(tmp_path, stress, goes_on):
    """Below G = 3.5138 the hottest place stays under 1.18684 of the turning point, above it goes past."""
    overrides = [text(exponential(stress)), "walls.top.shear_stress=1.0", "time.end=200", "scheme.largest_strain=2.0"]
    found = layers(*channel_of(tmp_path, CASE, overrides))
    assert (stress * found.flow.substances[0].max() > 1.18684) == goes_on


def test_heat_that_runs_away_stops_the_run():
    with pytest.raises(DivergedError, match="the temperature has risen to"):
        at_end(temperature=exponential(30.0), walls={"top": {"shear_stress": 1.0}}, time={"end": 20.0})


def test_conditions_and_sources_that_change_with_time(tmp_path):
    """T = cos(3 y + 1)(1 + sin(5 t)/2), by a given T at the bottom and a given flux at the top."""
    course = "(1 + 0.5*sin(5*t))"
    section = {
        **CONDUCTING,
        "initial": "cos(3*y + 1)",
        "source": f"cos(3*y + 1)*(2.5*cos(5*t) + 9*{course})",
        "walls": {"bottom": f"cos(1)*{course}", "top": {"flux": f"-3*sin(4)*{course}"}},
    }
    with tisph.Simulation({**SMALL, "temperature": section, "walls": COUETTE, "time": {"end": 1.0}}) as simulation:
        snapshot = simulation.run_until(1.0).snapshot
    exact = np.cos(3 * snapshot.y + 1) * (1 + 0.5 * np.sin(5.0))
    assert np.abs(snapshot.substances["temperature"] - exact).max() < 1e-3  # measured: 5e-4, of order 3
    flows = [3 * np.sin(1) * (1 + 0.5 * np.sin(5.0)), -3 * np.sin(4) * (1 + 0.5 * np.sin(5.0))]
    assert snapshot.flows[0] == pytest.approx(flows, rel=2e-3)


NAHME = ExponentialCouette(1.0, 1.0, 1.0, 5.0, 1.0)
PAIRS = {
    "slip": {"walls": {"top": {"velocity": 1.0 + 0.1 * NAHME.stress}, "bottom": {"slip_length": 0.1}}},
    "polymer": {"walls": COUETTE, "fluid": {**SMALL["fluid"], "rheology": POLYMER}},
    "disorder": {"walls": COUETTE, "initial": {"jitter": 0.1}},
    "single precision": {"walls": COUETTE, "discretisation": {"particles_across": 12, "precision": "f32"}},
}


@pytest.mark.parametrize("pair", PAIRS)
def test_walls_fluids_and_arrangements_meet_the_temperature(pair):
    """Slip follows the stress; a polymer has the steady viscosity of the solution. Measured: 1e-4 in u, 3e-4 in T."""
    found = at_end(temperature=exponential(5.0), time={"end": 3.0}, **PAIRS[pair])
    slip = 0.1 * NAHME.stress if pair == "slip" else 0.0
    assert found.u == pytest.approx(NAHME.velocity(found.y) + slip, abs=3e-4)
    assert differs(found.substances["temperature"], NAHME.temperature(found.y)) < 1e-3
    assert found.flows[0] == pytest.approx(-NAHME.heat_flux(1.0) * np.ones(2), rel=2e-3)


def test_plate_with_a_mass_on_a_polymer():
    """Stress, inertia, polymer and temperature at once: the steady flow is that of the viscosity."""
    fluid, plate = {**SMALL["fluid"], "rheology": POLYMER}, {"shear_stress": 1.0, "mass_per_area": 0.2}
    found = at_end(temperature=exponential(2.0), walls={"top": plate}, fluid=fluid, time={"end": 10.0})
    exact = ExponentialCouette.of_stress(1.0, gap=1.0, viscosity=1.0, conductivity=1.0, coefficient=2.0)
    assert found.u == pytest.approx(exact.velocity(found.y), abs=4e-3)


def test_shear_thinning_fluid_at_the_reduced_shear_rate(steady):
    """By superposition the shear rate is k/a with one k everywhere, so that the profiles are Nahme's."""
    from tisph.rheology.carreau_yasuda import Law, Parameters

    law = Law(Parameters(type="carreau_yasuda", time=0.7, index=0.5), 1.0)
    rate = NAHME.stress  # of the reduced shear rate, for the unit speed
    coefficient = 5.0 / law.viscosity(rate**2)
    rheology = "fluid.rheology={type: carreau_yasuda, time: 0.7, index: 0.5}"
    y, u, values = steady(exponential(coefficient), rheology, "walls.top.velocity=1.0")
    assert differs(u, NAHME.velocity(y)) < 1e-5  # measured: 2.4e-6
    assert differs(coefficient * values, 5.0 * NAHME.temperature(y)) < 3e-5  # measured: 1.4e-5


def test_uniform_temperature_stays_and_changes_no_bit():
    """With a constant T the factor of the viscosity is 1 at the reference, and a substance without effect has none."""
    walls = {"walls": COUETTE, "initial": {"jitter": 0.1}, "time": {"end": 0.1}}
    alone, beside = at_end(**walls), at_end(**walls, temperature={**CONDUCTING, "initial": 0.7})
    assert np.array_equal(alone.u, beside.u)
    assert beside.substances["temperature"] == pytest.approx(np.full_like(beside.u, 0.7), abs=1e-12)


def test_restart_gives_the_same_bits(tmp_path):
    """Every field and number of the substances and of the walls is in the checkpoint, in a disordered arrangement."""
    config = {
        **SMALL,
        "walls": {"top": {"shear_stress": 1.0}},
        "initial": {"jitter": 0.2},
        "temperature": exponential(
            2.0, walls={"bottom": {"flux": 0.1}, "top": "t"}, expansion=1.0, gravity=[-1.0, 0.0]
        ),
        "scalars": [{"name": "dye", "diffusivity": 0.1, "initial": "y", "walls": {"top": 0.0}}],
    }
    check_substances(config, tmp_path / "checkpoint.h5", stop=15, steps=30)


def test_buoyancy_counts_in_the_balance_of_momentum(tmp_path):
    section = {**CONDUCTING, "expansion": 1.0, "gravity": [-1.0, 0.0], "walls": {"bottom": 0.0, "top": 1.0}}
    with tisph.Simulation({**SMALL, "temperature": section, "time": {"end": 0.3}}) as simulation:
        simulation.run_until(0.3)
        balance = simulation.scheme.momentum_balance()
    assert balance["drive"] > abs(balance["change"]) > 0.0
    assert balance["closure"] < 5e-3  # measured: 2.3e-3, with 12 across


def test_factor_scales_relaxation_times_and_viscosities(tmp_path):
    """In terms of time over a: F(C, u_y; a) = F(C, a u_y; 1)/a, and the tangent is the derivative of the stress."""
    rheology = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.3, solvent_fraction: 0.3}"
    _, channel = channel_of(tmp_path, CASE, [rheology, "walls.top.velocity=1.0"])
    base = model_of(channel.rheology, channel)
    hot, step, rate = ThermalModel(base, 0.3, 0.5), 1e-6, np.array([2.0])
    state = np.array([[0.3], [0.2], [0.1]])
    relaxed = [model.rate(state, np.zeros(1)) for model in (base, hot)]
    assert relaxed[1] == pytest.approx(2.0 * relaxed[0])
    known, (after, tangent) = state, hot.update(state, 0.1, rate, state)
    ahead = hot.update(known, 0.1, rate + step, state)[0]
    slope = (hot.shear_stress(ahead, rate + step) - hot.shear_stress(after, rate)) / step
    assert tangent == pytest.approx(slope, rel=1e-5)
    _, by_factor = hot.by_factor(state[:, 0], 2.0)
    other = ThermalModel(base, 0.3, 0.5 + step)
    assert by_factor == pytest.approx(
        float((other.shear_stress(state, rate) - hot.shear_stress(state, rate))[0]) / step
    )


def test_mixed_iterates_solve_linear_equations_in_their_dimension():
    """Two unknowns: after three iterates the mixture is the solution, although plain iteration diverges."""
    matrix, right, iterates, guess = np.array([[-3.0, 1.0], [0.5, 2.0]]), np.array([1.0, 2.0]), [], np.zeros(2)
    for _ in range(4):
        iterates.append((guess, matrix @ guess + right - guess))
        guess = mixed(iterates)
    assert guess == pytest.approx(np.linalg.solve(np.eye(2) - matrix, right))


def test_fluid_gains_the_heat_that_it_receives(tmp_path):
    """Through walls, by heating and from a source, within a step, too; the initial jump at a wall counts."""
    section = {**HEATED, "walls": {"bottom": {"flux": 2.0}, "top": 1.0}, "source": "y*t"}
    with tisph.Simulation({**SMALL, "temperature": section, "walls": COUETTE, "time": {"end": 0.5}}) as simulation:
        simulation.run_until(0.5)
        scheme = simulation.scheme
        for time in (scheme.time, scheme.time - 0.3 * scheme.particles.dt):
            found = scheme.snapshot(time)
            content = np.mean(found.substances["temperature"])  # by midpoints; Euler and Maclaurin have the next term
            content += found.flows[0].sum() / 12.0**2 / 24.0
            assert found.received[0] == pytest.approx(content, rel=1e-3)


def test_images_of_other_treatments_are_refused():
    config = {**SMALL, "walls": {**COUETTE, "treatment": {"type": "comoving_image"}}, "temperature": CONDUCTING}
    with pytest.raises(ConfigError, match="consistent_image"):
        tisph.Simulation(config)
