"""Schemes to test with: small channels on one thread, built without a YAML file."""

import numpy as np
import pytest

from tisph import config, families, runtime
from tisph.scenes.channel import Channel
from tisph.simulation.run import start_values

CASE = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 1.0}
walls: {top: {velocity: 0.5}}
discretisation: {particles_across: 12}
scheme: {type: wcsph}
time: {end: 1.0}
"""


@pytest.fixture
def make(tmp_path):
    """Return a function that builds a started Scheme from ``key.path=value`` overrides of a small Couette case."""

    def build(*overrides, jitter=0.0, velocity=None):
        path = tmp_path / "case.yaml"
        path.write_text(CASE)
        settings = config.load(path, overrides)
        channel = Channel.from_config(settings)
        threads = 1 if settings.runtime.threads == "auto" else settings.runtime.threads
        runtime.start(settings.discretisation.precision, threads)
        scheme = families.load("schemes", settings.scheme.type).Scheme(
            settings, channel, settings.time.samples, serial=threads == 1
        )
        x, y = channel.jittered(0, jitter)
        field = np.stack([channel.initial_velocity(y), 0 * y], 1) if velocity is None else velocity(x, y)
        scheme.start(np.stack([x, y], 1), field, start_values(channel, settings.initial)[2])
        return scheme

    return build
