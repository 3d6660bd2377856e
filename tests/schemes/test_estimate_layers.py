"""The layers that `tisph check` computes with do what particles do, while they stand on their lattice."""

import numpy as np
import pytest
from flows import flow_text
from implicit_case import channel_of, start_of_layers

from tisph import runtime, schemes
from tisph.schemes import _estimate
from tisph.schemes.implicit import step_control
from tisph.simulation.state import start_values

pytestmark = pytest.mark.taichi

CASE = flow_text("narrow_channel")
STEADY = "walls={bottom: {velocity: -1e-5}, top: {velocity: 5e-5}}"
SWINGING = "walls={bottom: {velocity: -1e-5}, top: {amplitude: 5e-5, angular_frequency: 9.0, phase: sin}}"
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.2, solvent_fraction: 0.3}"
DRIVEN = "drive.acceleration=2e-5"
SPEED = 5e-5
"""Of the top wall: so slow that layers do not shear."""


@pytest.fixture
def case(tmp_path):
    """Return a function that gives a config and its channel, in the flow's own frame, of overrides."""

    def build(*overrides):
        settings, channel = channel_of(tmp_path, CASE, overrides)
        return settings, channel.in_flow_frame()

    return build


def profiles(settings, channel, times):
    """Yield the scheme at every one of ``times``, and the velocities (layers,) of its layers of particles."""
    runtime.start("f64", 1)
    scheme = schemes.build(settings, channel, times, True)
    scheme.start(*start_values(channel, settings.initial))
    for time in times:
        while scheme.time < time:
            scheme.advance()
        last = scheme.snapshot()
        yield scheme, np.array([last.u[row].mean() for row in np.array_split(np.argsort(last.y, kind="stable"), 10)])


@pytest.mark.parametrize(
    "flow", [(SWINGING, DRIVEN), (STEADY, DRIVEN, "walls.treatment.type=comoving_image", "scheme.operators.order=2")]
)
def test_layers_of_the_implicit_scheme(case, flow):
    settings, channel = case("scheme={type: implicit}", *flow, "time.tolerance=1e-5")
    times = [0.1, 0.3]
    layers = _estimate.ImplicitLayers(settings, channel, step_control(settings, channel, times))
    for scheme, velocity in profiles(settings, channel, times):
        layers.run_to(scheme.time)
        assert layers.steps == scheme.steps
        # systems are solved to 1e-3 of the tolerance
        assert np.abs(layers.velocity - velocity).max() < 1e-6 * SPEED


def test_of_a_run_without_end_steps_are_counted_alone(case, monkeypatch):
    # relaxation times far shorter than a layer needs to cross a spacing: steps follow the fastest
    monkeypatch.setattr(_estimate, "MOST_STEPS", 30)
    settings, channel = case(POLYMER, "walls.top.velocity=5e-5", "scheme={type: implicit}", "time.tolerance=1e-9")
    layers = start_of_layers(settings, channel)
    layers.run_to(settings.time.end)
    assert layers.unknown
    assert layers.time == settings.time.end
    assert layers.steps > 30
