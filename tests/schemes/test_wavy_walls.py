"""Flow along periodic walls with outlines, against the lubrication limit of a plane channel and a spectral method."""

import numpy as np
import pytest
from flows import flow_text

import tisph
from tisph.config import load

LENGTH, DEPTH = 6.0, 0.4
PIPE, THROAT = 3.0, 0.4

CHANNEL = flow_text("long_channel")

REFERENCE = {0: 29.2617935, 10: 6.0873576, 30: 2.2300297, 100: 0.7643952}
"""``python benchmarks/wavy_pipe.py``: Reynolds number -> acceleration for a flow rate of pi, equal at two resolutions
to 5e-7."""


def wave(length, depth, count=24, ahead=0.0):
    """Places on 1 - depth (1 - cos)/2, whose crest is at x = -ahead."""
    x = np.linspace(0.0, length, count + 1)
    return np.stack([x, 1.0 - 0.5 * depth * (1.0 - np.cos(2.0 * np.pi * (x + ahead) / length))], axis=1)


def at_end(tmp_path, text, *changes):
    """Return a simulation that has run to its end."""
    path = tmp_path / "case.yaml"
    path.write_text(text)
    simulation = tisph.Simulation(load(path, changes))
    while not simulation.finished:
        simulation.step()
    return simulation


MOVED = {"as it is": ("top", 0.0), "along a part of a period": ("top", 1.7), "mirrored": ("bottom", 0.0)}


@pytest.mark.taichi
@pytest.mark.parametrize(("side", "ahead"), MOVED.values(), ids=MOVED)
def test_flow_rate_through_long_waves_is_that_of_lubrication(tmp_path, side, ahead):
    """The pressure gradient is 12 nu Q <h^-3 (1 + 4/5 h'^2)>, h the distance of the walls.

    From psi = Q (3 Y^2 - 2 Y^3), Y = y/h, and the next term of nabla^4 psi = 0 in powers of the slope.
    """
    outline = wave(LENGTH, DEPTH, ahead=ahead) * [1.0, 1.0 if side == "top" else -1.0]
    outline[:, 1] += 0.0 if side == "top" else 1.0
    simulation = at_end(tmp_path, CHANNEL, f"walls.{side}={{outline: {outline.round(12).tolist()}, smooth: true}}")
    x = np.linspace(0.0, LENGTH, 500, endpoint=False)
    height = 1.0 - 0.5 * DEPTH * (1.0 - np.cos(2.0 * np.pi * x / LENGTH))
    slope = np.pi * DEPTH / LENGTH * np.sin(2.0 * np.pi * x / LENGTH)
    flow_rate = 1.0 / (12.0 * np.mean((1.0 + 0.8 * slope**2) / height**3))
    # 8e-5 at 18 across is the term of fourth order in the slope; without that of second order it would be 1.6e-2
    assert simulation.scene.velocities(simulation.state)["flow_rate"] == pytest.approx(flow_rate, rel=3e-4)


def pipe(reynolds, across, end):
    """Return the config of flow through a pipe with a constriction; without inertia for a Reynolds number of 0."""
    viscosity, inertia = (2.0 / reynolds, "true") if reynolds else (1.0, "false")
    return f"""\
scene: region
coordinates: axisymmetric
fluid: {{density: 1.0, kinematic_viscosity: {viscosity}, inertia: {inertia}}}
geometry: {{length: {PIPE}, height: 1.0}}
walls: {{top: {{outline: {wave(PIPE, THROAT).round(12).tolist()}, smooth: true}}}}
drive: {{acceleration: {REFERENCE[reynolds]}}}
discretisation: {{particles_across: {across}}}
scheme: {{accuracy: fast}}
time: {{end: {end}}}
runtime: {{threads: 1}}
output: {{video: null}}
"""


@pytest.mark.taichi
def test_creeping_flow_through_a_constriction_is_that_of_a_spectral_method(tmp_path):
    """The wall bears the whole pressure gradient."""
    simulation = at_end(tmp_path, pipe(0, 16, 1e-4))
    scene, snapshot = simulation.scene, simulation.scheme.snapshot()
    assert scene.flow_rate(snapshot)["flow_rate"] == pytest.approx(np.pi, rel=2e-4)  # 6e-5; 4e-6 at 24 across
    volume = np.pi * PIPE * ((1.0 - 0.5 * THROAT) ** 2 + 0.5 * (0.5 * THROAT) ** 2)
    assert scene.loads(snapshot)["force_top"] == pytest.approx(REFERENCE[0] * volume, rel=5e-3)


@pytest.mark.taichi
@pytest.mark.slow
@pytest.mark.parametrize(("reynolds", "across", "end"), [(10, 16, 8.0), (30, 16, 20.0), (100, 24, 40.0)])
def test_pressure_drop_of_a_constriction_at_reynolds_numbers(tmp_path, reynolds, across, end):
    """Repeats the flow without inertia; minutes. At a given flow rate the pressure drop is off by somewhat more."""
    simulation = at_end(tmp_path, pipe(reynolds, across, end))
    found = simulation.scene.flow_rate(simulation.state)["flow_rate"]
    assert found == pytest.approx(np.pi, rel=5e-3)


def test_frozen_values_are_those_of_the_spectral_method():
    """Of its coarse resolution, here at one Reynolds number."""
    import importlib.util
    from pathlib import Path

    place = Path(__file__).parents[2] / "benchmarks" / "wavy_pipe.py"
    described = importlib.util.spec_from_file_location("wavy_pipe", place)
    module = importlib.util.module_from_spec(described)
    described.loader.exec_module(module)
    assert (module.LENGTH, module.DEPTH) == (PIPE, THROAT)
    assert module.acceleration(10.0, 21, 11) == pytest.approx(REFERENCE[10], rel=1e-5)
    # Hagen and Poiseuille, of a straight pipe: 8 nu U/R^2
    straight = lambda x: (np.ones_like(x), np.zeros_like(x))  # noqa: E731
    assert module.acceleration(10.0, 11, 7, wall=straight) == pytest.approx(1.6, rel=1e-9)
