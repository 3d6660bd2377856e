"""Schemes to test with: small channels on one thread, built without a YAML file of a test's own."""

from tisph import config, runtime, schemes
from tisph.geometry.motion import WallMotion
from tisph.scenes.channel import Channel
from tisph.simulation.state import start_values

CASE = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 1.0}
walls: {top: {velocity: 0.5}}
discretisation: {particles_across: 12}
scheme: {type: wcsph}
time: {end: 1.0}
runtime: {threads: 1}
"""


class Together(Channel):
    """Walls and liquid that all move at one velocity, as seen from rest: a config of that is refused."""

    frame_velocity = 0.0


def builder(path):
    """Return a function that builds a Scheme from ``key.path=value`` overrides of the config file at ``path``.

    ``jitter`` is short for ``initial.jitter``. ``moved(x, y)`` and ``velocity(x, y)`` return other places and
    velocities (particles, 2) than those of the config. With ``started=False`` there are no particles in it yet;
    with ``fresh=False`` earlier Schemes, of the same precision and threads, can still be used. ``together`` is a
    velocity that both walls and, in ``initial.state=developed``, the liquid have.
    """

    def build(*overrides, jitter=None, moved=None, velocity=None, started=True, fresh=True, together=None):
        settings = config.load(path, overrides if jitter is None else (*overrides, f"initial.jitter={jitter}"))
        channel = Channel.from_config(settings)
        if together is not None:
            wall = WallMotion(together)
            channel = Together(**{**vars(channel), "bottom": wall, "top": wall})
        threads = settings.runtime.threads
        if fresh:
            runtime.start(settings.discretisation.precision, threads)
        targets = sorted({*settings.time.samples, settings.time.end})
        scheme = schemes.build(settings, channel, targets, threads == 1)
        if started:
            position, field, stress = start_values(channel, settings.initial)
            if moved:
                position = moved(*position.T)
            if velocity:
                field = velocity(*position.T)
            scheme.start(position, field, stress)
        return scheme

    return build
