"""Measures of heat in suites: exact fields have no error, changed ones the error of the change."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tisph import scenes
from tisph.config import loader
from tisph.exact.convection import HeatedCavity, Rolls, growth_rate
from tisph.exact.heat import CircularHeating, ExponentialCouette, rotating_mode
from tisph.exact.passive_scalar import Dispersion, Entrance, parabola
from tisph.simulation.state import start_snapshot, start_values
from tisph.studies import heat, suites
from tisph.studies.processes import Result

ANY = Result(Path(), {})
SUITE = suites.ours("heat")
LONG = suites.ours("heat", long=True)


@pytest.fixture
def show(monkeypatch):
    """A function that makes ``fields`` of x, y and t the only ones of a run of the suite, on its particles."""

    def fields_of(run, fields, across=None):
        config = (SUITE.runs | LONG.runs)[run]
        if across:
            config = {**config, "discretisation": {"particles_across": across}}
        settings = loader.loaded(config, {})
        scene = scenes.of(settings)
        start = start_snapshot(scene, start_values(scene, settings.initial), "f64")

        def sample(_, t):
            values = {name: field(start.x, start.y, t) + np.zeros(len(start.x)) for name, field in fields.items()}
            carried = {name: values.pop(name) for name in start.substances if name in values}
            return scene, replace(start, t=t, substances={**start.substances, **carried}, **values)

        monkeypatch.setattr(heat, "_sample", sample)

    return fields_of


def test_profiles_between_plates_are_compared_with_nahmes_flow(show):
    exact = ExponentialCouette(1.0, 1.0, 1.0, 1.0, np.sqrt(5.0))
    fields = {"temperature": lambda x, y, t: exact.temperature(y), "u": lambda x, y, t: exact.velocity(y)}
    show("nahme_5", fields)
    assert heat.sheared_off(ANY, t=5.0) < 1e-8
    show("nahme_5", {**fields, "u": lambda x, y, t: exact.velocity(y) + 0.01})
    assert heat.sheared_off(ANY, t=5.0) == pytest.approx(0.01 / np.sqrt(5.0), rel=1e-5)
    show("nahme_5", {**fields, "temperature": lambda x, y, t: exact.temperature(y) - 0.01})
    assert heat.sheared_off(ANY, t=5.0) == pytest.approx(0.01 / 0.48550782, rel=1e-5)


def test_profiles_between_cylinders_are_compared_around_the_axis(show):
    exact = CircularHeating((1.0, 2.0), (1.0, 0.0), 1.0, 1.0)
    fields = {
        "temperature": lambda x, y, t: exact.temperature(np.hypot(x, y)),
        "u": lambda x, y, t: -exact.velocity(np.hypot(x, y)) * y / np.hypot(x, y),
        "v": lambda x, y, t: exact.velocity(np.hypot(x, y)) * x / np.hypot(x, y),
    }
    show("heated_cylinders", fields)
    assert heat.sheared_off(ANY, t=6.0) < 1e-8
    show("heated_cylinders", {**fields, "v": lambda x, y, t: 0.0 * x})
    assert heat.sheared_off(ANY, t=6.0) > 0.1


def test_the_rotating_mode_turns_with_the_circle(show):
    def mode(speed):
        options = {"radius": 1.0, "diffusivity": 1.0, "angular_velocity": speed}
        return {"temperature": lambda x, y, t: rotating_mode(np.hypot(x, y), np.arctan2(y, x), t, **options)}

    show("turning_circle", mode(2.0))
    assert heat.rotating_mode_off(ANY, t=0.1) < 1e-12
    show("turning_circle", mode(1.0))
    assert heat.rotating_mode_off(ANY, t=0.1) > 0.01
    x, y = np.array([0.3, -0.6]), np.array([0.2, 0.5])  # the formula of the start
    config = loader.loaded(SUITE.runs["turning_circle"], {})
    start = scenes.of(config).substances[0].initial(x, y, 0.0)
    assert start == pytest.approx(mode(2.0)["temperature"](x, y, 0.0), abs=1e-10)


def test_lines_and_hot_walls_have_the_extremes_of_a_cavity(show):
    exact = HeatedCavity(1000.0, 0.71)
    show(
        "cavity_1e3",
        {
            "temperature": lambda x, y, t: exact.temperature(x, y),
            "u": lambda x, y, t: exact.velocity(x, y)[0],
            "v": lambda x, y, t: exact.velocity(x, y)[1],
        },
        across=32,
    )
    largest = exact.extremes()
    across, up = [[0.5, 0.0], [0.5, 1.0]], [[0.0, 0.5], [1.0, 0.5]]
    assert heat.largest_on_line(ANY, t=1.0, field=0, line=across) == pytest.approx(largest["u_max"], rel=1e-5)
    assert heat.largest_on_line(ANY, t=1.0, field=1, line=up) == pytest.approx(largest["v_max"], rel=1e-5)
    for name, chosen in (("nusselt_max", True), ("nusselt_min", False)):
        assert heat.hot_wall_nusselt(ANY, t=1.0, largest=chosen) == pytest.approx(largest[name], rel=1e-3)


def test_waves_of_temperature_grow_at_the_exact_rate(show):
    rate = growth_rate(np.pi, 2000.0, 1.0)

    def wave(rate):
        bump = lambda x, y, t: 1e-3 * np.exp(rate * t) * np.sin(np.pi * y) * np.cos(np.pi * x)  # noqa: E731
        return {"temperature": lambda x, y, t: 0.5 - y + bump(x, y, t)}

    show("rolls_grow", wave(rate))
    assert heat.rolls_off(ANY, waves=1, between=[0.5, 1.5]) < 1e-9
    show("rolls_grow", wave(1.1 * rate))
    assert heat.rolls_off(ANY, waves=1, between=[0.5, 1.5]) == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize(("run", "pipe"), [("dye", False), ("pipe_dye", True)])
def test_waves_of_dye_decay_and_travel_at_the_exact_rate(show, run, pipe):
    exact, k = Dispersion(1.0, parabola(1.0, 1.0, pipe), 0.1, pipe), np.pi / (6.0 if pipe else 1.0)

    def wave(factor):
        s = exact.rate(k) * factor
        return {"dye": lambda x, y, t: np.real(np.exp(1j * k * x + s * t) * exact.mode(k, y))}

    show(run, wave(1.0))
    assert heat.dispersion_off(ANY, name="dye", waves=1, between=[2.0, 2.5]) < 1e-5
    show(run, wave(1.01))
    assert heat.dispersion_off(ANY, name="dye", waves=1, between=[2.0, 2.5]) == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize("run", ["entrance_1000", "entrance_1000_flux"])
def test_nusselt_numbers_of_entrances_are_local(show, run):
    """Fits at the wall to the exact T, 16 particles across, are 5e-4 off at x* = 0.01 (measured)."""
    flux = run.endswith("flux")
    exact = Entrance(1.0, parabola(1.0, 1.0), 0.002, flux=flux)
    fields = {
        "u": lambda x, y, t: 6.0 * y * (1.0 - y),
        "temperature": lambda x, y, t: exact.temperature(x, y),  # of half-widths and fluxes 0.004/0.002 * 1/2 = 1
    }
    show(run, fields)
    assert heat.entrance_off(ANY, t=40.0, at=0.01) < 2e-3
    show(run, {**fields, "temperature": lambda x, y, t: exact.temperature(0.7 * x, y)})
    assert heat.entrance_off(ANY, t=40.0, at=0.01) > 0.01


def test_a_balance_is_a_difference_over_what_flows():
    samples = [
        {"t": 1.0, "heat_gained": 5.0, "heat_received": 4.0, "heat_flow_top": 9.0},
        {"t": 3.0, "heat_gained": 8.0, "heat_received": 6.5, "heat_flow_top": 2.5},
    ]
    run = Result(Path(), {"samples": samples})
    assert heat.balance_off(run, amount="heat", wall="top", between=[1.0, 3.0]) == pytest.approx(0.5 / 5.0)


def test_numbers_in_the_suite_are_the_exact_ones():
    """Constants of the rows: heat flows, saturated rolls and local Nusselt numbers."""
    walls = {f"nahme_{n}": ExponentialCouette(1.0, 1.0, 1.0, 1.0, np.sqrt(n)).heat_flux(1.0) for n in (1, 5)}
    walls["heated_cylinders"] = -2.0 * np.pi * CircularHeating((1.0, 2.0), (1.0, 0.0), 1.0, 1.0).heat_flux(1.0)
    found = {each.case: each.quantity for each in SUITE.criteria if "heat flow" in each.quantity}
    assert found.keys() == walls.keys()
    for run, text in found.items():
        assert float(text.split()[-1]) == pytest.approx(walls[run], rel=5e-6)  # six digits are printed
    for run, rayleigh, prandtl in (("rolls_2000", 2000.0, 1.0), ("rolls_5000", 5000.0, 0.71)):
        exact = Rolls(rayleigh, prandtl, np.pi)
        printed = {
            each.quantity.split()[0]: float(each.quantity.split()[-1]) for each in SUITE.criteria if each.case == run
        }
        assert printed.pop("largest") == pytest.approx(exact.largest_velocity, rel=5e-6)
        assert list(printed.values()) == pytest.approx([exact.nusselt] * len(printed), rel=5e-6)
