"""Temperature and dissolved substances of two-dimensional flow: exact solutions, and the features they meet."""

import numpy as np
import pytest
from same_bits import check_substances

import tisph
from tisph.errors import DivergedError
from tisph.exact.heat import CircularHeating, Conduction, ExponentialCouette, Wall
from tisph.exact.passive_scalar import Dispersion, parabola

BASE = {
    "name": "heat",
    "fluid": {"density": 1.0, "kinematic_viscosity": 1.0},
    "discretisation": {"particles_across": 14},
    "time": {"end": 0.1},
    "output": {"video": None},
    "runtime": {"threads": 1},
}
CONDUCTING = {"conductivity": 1.0, "heat_capacity": 1.0}
STOKES = {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False}
POLYMER = {"type": "oldroyd_b", "relaxation_time": 0.1, "solvent_fraction": 0.5}
CIRCLE = {"type": "circle", "centre": [1.0, 0.5], "radius": 0.2}
CHANNEL = {"scene": "channel", "geometry": {"gap": 1.0, "length": 2.0}, "walls": {"top": {"velocity": 1.0}}}
ENDS = {"left": {"type": "inlet", "velocity": 1.0}, "right": {"type": "outlet"}}
BOX = {"scene": "cavity", "geometry": {"width": 1.0, "height": 1.0}, "walls": {"lid": {"velocity": 1.0}}}
REGULAR = {**BOX, "walls": {"lid": {"velocity": 1.0, "profile": "regular"}}}
FINE = {"particles_across": 24}
PIPE = {"scene": "pipe", "geometry": {"radius": 1.0, "length": 2.0}, "drive": {"acceleration": 1.0}}
PERIODIC = {"scene": "taylor_green", "geometry": {"length": 1.0}, "initial": {"velocity": 1.0}}
CYLINDERS = {
    "scene": "annulus",
    "geometry": {"inner_radius": 1.0, "outer_radius": 2.0},
    "walls": {"inner": {"angular_velocity": 1.0}},
}

FLOWS = {
    "cavity": BOX,
    "regular lid, polymer": {**REGULAR, "fluid": {**BASE["fluid"], "rheology": POLYMER}},
    "cavity without inertia": {**REGULAR, "fluid": STOKES},
    "single precision": {**BOX, "discretisation": {"particles_across": 12, "precision": "f32"}},
    "slip": {**REGULAR, "walls": {**REGULAR["walls"], "bottom": {"slip_length": 0.2}}},
    "varying spacing": {**BOX, "discretisation": {**FINE, "refine": [{"at": [0.5, 0.3], "spacing": 0.03}]}},
    "cylinders": CYLINDERS,
    "pipe": {**PIPE, "walls": {"outer": {"angular_velocity": 1.0}}},
    "ends": {**CHANNEL, "ends": ENDS, "walls": {}, "bodies": [CIRCLE]},
    "ends of a pipe": {**PIPE, "ends": ENDS, "drive": {}, "geometry": {"radius": 1.0, "length": 3.0}},
    "free body": {**CHANNEL, "bodies": [{**CIRCLE, "motion": "free", "density": 1.0}]},
    "free body in a stream": {
        **CHANNEL,
        "ends": ENDS,
        "walls": {},
        "bodies": [{**CIRCLE, "motion": "free", "density": 1.0}],
    },
    "no walls": {**PERIODIC, "discretisation": FINE},
}


@pytest.mark.parametrize("name", FLOWS)
def test_uniform_temperature_stays_uniform_in_every_flow(name):
    """A constant obeys equation and conditions: a part of a flow that forgets the temperature changes it.

    It is off by the rounding errors of the operators, some thousand units in the last place (1e-12 was measured), and
    by the residual of the linear systems, which is 0 for a constant.
    """
    config = {**BASE, **FLOWS[name], "temperature": {**CONDUCTING, "initial": 0.7}}
    with tisph.Simulation(config) as simulation:
        for _ in range(8):
            simulation.step()
        values = simulation.state.snapshot.substances["temperature"]
    assert np.abs(values - 0.7).max() < (1e-4 if name == "single precision" else 1e-10)


def region(**sections):
    """Config of fluid between plates at y = 0 and 1."""
    return {**BASE, "scene": "region", "geometry": {"length": 1.5, "height": 1.0}, "walls": {}, **sections}


def at_end(config, end):
    """State at the time ``end``, and y and temperature of its particles."""
    with tisph.Simulation({**config, "time": {"end": end}}) as simulation:
        state = simulation.run_until(end)
    return state, state.y, state.snapshot.substances["temperature"]


@pytest.mark.parametrize("insulated", [False, True])
def test_slab_heats_up_by_conduction(insulated):
    """The start is an impulse, of which errors of the first steps and of the spacing are left: 1.2e-5 was measured."""
    below = {"flux": 0.0} if insulated else 0.0
    state, y, values = at_end(region(temperature={**CONDUCTING, "walls": {"top": 1.0, "bottom": below}}), 0.1)
    exact = Conduction((0.0, 1.0), (Wall(None if insulated else 0.0), Wall(1.0)), 1.0)
    assert np.abs(values - exact.temperature(y, 0.1)).max() < 5e-5
    flows = [-exact.heat_flux(0.0, 0.1) * -1.5, exact.heat_flux(1.0, 0.1) * -1.5]
    assert state.snapshot.flows[0] == pytest.approx(flows, abs=1e-3)


def test_given_flux_heats_a_slab():
    """With a flux q at the top and T = 0 below T is q y in the end, a polynomial that the operators have exactly."""
    _, y, values = at_end(region(temperature={**CONDUCTING, "walls": {"top": {"flux": 2.0}, "bottom": 0.0}}), 6.0)
    assert values == pytest.approx(2.0 * y, abs=1e-5)


def test_formulas_give_wall_temperatures_and_sources():
    """T = t y^2 has the source y^2 - 2 t: linear in time and of degree 2, it is exact but for residuals."""
    walls = {"top": "t", "bottom": 0.0}
    config = region(temperature={**CONDUCTING, "walls": walls, "source": "y**2 - 2*t"})
    _, y, values = at_end(config, 0.5)
    assert values == pytest.approx(0.5 * y**2, abs=1e-6)


def test_viscous_heating_between_cylinders():
    """Eight digits of slip_layers_heat.md; with 12 particles across errors of order 4 are 1e-5 of the largest T."""
    config = {
        **BASE,
        **CYLINDERS,
        "temperature": {**CONDUCTING, "viscous_heating": True, "walls": {"inner": 0.0, "outer": 0.0}},
    }
    state, _, values = at_end(config, 2.0)
    exact = CircularHeating((1.0, 2.0), (1.0, 0.0), 1.0, 1.0)
    radius = np.hypot(state.x, state.y)
    assert np.abs(values - exact.temperature(radius)).max() < 3e-5
    assert state.snapshot.flows[0] == pytest.approx(-2.0 * np.pi * np.array([1.6319622, 2 * 0.51735225]), rel=1e-4)


def test_heat_received_by_friction_is_the_heat_of_the_fluid():
    """In steady flow in a pipe u = g (R^2 - r^2)/4, T = g^2 (R^4 - r^4)/64 and its integral is pi g^2 length/96.

    The error of the integral over time is at the start, where steps are short but few.
    """
    config = {**BASE, **PIPE, "drive": {"acceleration": 4.0}, "discretisation": {"particles_across": 10}}
    heated = {**CONDUCTING, "viscous_heating": True, "walls": {"outer": 0.0}}
    state, _, _ = at_end({**config, "temperature": heated}, 2.0)
    assert state.snapshot.received[0] == pytest.approx(np.pi * 16.0 * 2.0 / 96.0, rel=1e-3)


@pytest.mark.parametrize("nahme", [1.0, 5.0])
def test_exponential_viscosity_heats_and_thins(nahme):
    """Nahme's closed form; with 12 particles across the error of T is 2e-5 at Na = 5, and has order 4."""
    heat = {**CONDUCTING, "viscous_heating": True, "viscosity": {"type": "exponential", "coefficient": 1.0}}
    config = region(temperature={**heat, "walls": {"top": 0.0, "bottom": 0.0}})
    speed = float(np.sqrt(nahme))
    state, y, values = at_end({**config, "walls": {"top": {"velocity": speed}}}, 4.0)
    exact = ExponentialCouette(1.0, 1.0, 1.0, 1.0, speed)
    assert np.abs(state.u - exact.velocity(y)).max() < 1e-4
    assert np.abs(values - exact.temperature(y)).max() < 1e-4


def test_buoyancy_drives_a_vertical_channel():
    """Steady u = -(y^3/6 - y^2/4 + y/12), T = y - 1/2: polynomials of degree 3 are exact but for residuals."""
    heat = {**CONDUCTING, "walls": {"top": 0.5, "bottom": -0.5}, "expansion": 1.0, "gravity": [-1.0, 0.0]}
    state, y, _ = at_end(region(temperature=heat), 3.0)
    assert state.u == pytest.approx(-(y**3 / 6 - y**2 / 4 + y / 12), abs=1e-7)


def test_heat_that_runs_away_stops_the_run():
    """Above the largest pressure gradient no steady temperature exists, since the viscosity falls with it."""
    heat = {**CONDUCTING, "viscous_heating": True, "viscosity": {"type": "exponential", "coefficient": 1.0}}
    config = region(temperature={**heat, "walls": {"top": 0.0, "bottom": 0.0}}, drive={"acceleration": 60.0})
    with pytest.raises(DivergedError, match="temperature has risen"):
        at_end(config, 5.0)


def test_restart_gives_the_same_bits(tmp_path):
    """Every field and number of the substances is in the checkpoint."""
    heat = {**CONDUCTING, "viscous_heating": True, "walls": {"lid": 1.0}, "expansion": 50.0, "gravity": [0.0, -1.0]}
    config = {**BASE, **BOX, "temperature": heat, "scalars": [{"name": "dye", "diffusivity": 0.1, "initial": "x*y"}]}
    check_substances(config, tmp_path / "checkpoint.h5", stop=5, steps=12)


def test_dissolved_substances_do_not_change_the_flow():
    """A substance without feedback costs no step and no bit of the flow, as long as its error allows the steps."""
    config, flows = {**BASE, **BOX}, []
    for scalars in ([], [{"name": "dye", "diffusivity": 1.0}]):
        with tisph.Simulation({**config, "scalars": scalars, "scheme": {"type": "implicit"}}) as simulation:
            for _ in range(6):
                simulation.step()
            flows.append(simulation.state)
    assert np.array_equal(flows[0].u, flows[1].u)


def test_substance_disperses_in_poiseuille_flow_as_its_slowest_mode():
    """Decay and speed of the mode at Pe = 10 and k = pi: 1.6e-4 off with 24 across, order 4, for a bound of 1e-3."""
    exact, time, places = Dispersion(1.0, parabola(10.0, 1.0), 1.0), 0.05, np.linspace(0.0, 1.0, 201)
    amplitudes = exact.mode(np.pi, places)
    cosine, sine = (formula_in_y(places, part) for part in (amplitudes.real, amplitudes.imag))
    dye = {"name": "dye", "diffusivity": 1.0, "initial": f"({cosine})*cos(pi*x) - ({sine})*sin(pi*x)"}
    config = {**BASE, "scene": "channel", "geometry": {"gap": 1.0, "length": 2.0}, "drive": {"acceleration": 120.0}}
    config |= {"initial": {"state": "developed"}, "discretisation": FINE, "scalars": [dye], "time": {"end": time}}
    with tisph.Simulation(config) as simulation:
        state = simulation.run_until(time)
    rate = exact.rate(np.pi)
    wave = np.exp(1j * np.pi * state.x)
    known = (exact.mode(np.pi, state.y) * wave * np.exp(rate * time)).real
    change = np.log(np.mean(state.snapshot.substances["dye"] / wave) / np.mean(known / wave)) / time
    assert abs(change / rate) < 1e-3


def formula_in_y(places, values):
    """Formula of the polynomial in y through ``values`` at ``places`` from 0 to 1."""
    fit = np.polynomial.Polynomial.fit(places, values, 16, domain=[0.0, 1.0], window=[0.0, 1.0])
    return " + ".join(f"({float(factor)!r})*y**{power}" for power, factor in enumerate(fit.coef))
