"""Scheme implicit, for its tests: overrides of the small Couette case, and how to run it."""

import numpy as np
from case_from_text import to_end

from tisph import config, scenes, schemes
from tisph.schemes._estimate import ImplicitLayers
from tisph.schemes.implicit import step_control

IMPLICIT = ("scheme={type: implicit}", "time.tolerance=1.0e-5")

SLOW = 1e-6
"""Velocities with which nothing moves noticeably: the arrangement is the same whatever the steps."""


def fix_steps(scheme, dt):
    """Let a scheme take steps of one length, whatever their errors."""
    control = scheme.control
    control.fixed, control.dt_next, control.limit = True, dt, lambda _gradient: dt


def exact_error(scheme):
    """Run to the end; return the error of the velocities, relative and root mean square."""
    last = to_end(scheme)
    exact = scheme.channel.exact_velocity(last.y, last.t)
    return np.linalg.norm(last.u - exact) / np.linalg.norm(exact)


def channel_of(folder, text, overrides):
    """The config in ``text`` with ``overrides``, its scheme resolved, and its channel."""
    (folder / "case.yaml").write_text(text)
    settings = schemes.resolve(config.load(folder / "case.yaml", overrides))[0]
    return settings, scenes.of(settings)


def start_of_layers(settings, channel):
    """The layers of the lattice at the start."""
    targets = sorted({*settings.time.samples, settings.time.end})
    return ImplicitLayers(settings, channel, step_control(settings, channel, targets))


def layers(settings, channel):
    """The layers of the lattice at the end."""
    found = start_of_layers(settings, channel)
    found.run_to(settings.time.end)
    return found
