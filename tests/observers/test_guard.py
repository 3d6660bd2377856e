"""The guard names field, particle, step and time of what went wrong."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tisph.errors import DivergedError
from tisph.observers.guard import Guard
from tisph.snapshot import Snapshot

CHANNEL = SimpleNamespace(
    density=2.0, extent=(1.0, 1.0), periodic=(True, False), parallel=True, peak_velocity=0.5, start_time=0.0,
    spacing=0.1, solvent_viscosity=0.02, bodies=(),
)  # fmt: skip


def sound():
    values = np.linspace(0.1, 0.9, 5)
    return Snapshot(t=1.5, step=50, x=values, y=values, u=values, v=0 * values, density=2 + 0 * values, pressure=values)


def spoiled(field, value):
    values = getattr(sound(), field).copy()
    values[3] = value
    return replace(sound(), **{field: values})


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("u", np.nan, "not a finite number"),
        ("v", np.inf, "not a finite number"),
        ("density", 2.5, "off the reference density"),
        ("density", 1.5, "off the reference density"),
        ("v", 0.051, "breaks up"),
        ("v", -0.051, "breaks up"),
        ("y", -0.01, "beyond a wall"),
        ("y", 1.01, "beyond a wall"),
    ],
)
def test_names_field_particle_step_and_time(field, value, words):
    with pytest.raises(DivergedError) as caught:
        Guard(CHANNEL).check(spoiled(field, value))
    message = str(caught.value)
    assert message.startswith(field)
    for part in (words, "particle 3", "step 50", "t = 1.5"):
        assert part in message


def test_remembers_the_last_good_state():
    guard = Guard(CHANNEL)
    good = sound()
    guard.check(good)
    with pytest.raises(DivergedError):
        guard.check(spoiled("u", np.nan))
    assert guard.last_good is good


def test_the_flow_may_settle_while_viscosity_has_not_crossed_two_spacings():
    """2 * 0.1^2 / 0.02 = 1: the state at 1.5 is judged, one at 0.9 is not, and of a flow from t = 1 neither is."""
    wild = spoiled("v", 0.3)
    Guard(CHANNEL).check(replace(wild, t=0.9))
    later = SimpleNamespace(**{**vars(CHANNEL), "start_time": 1.0})
    Guard(later).check(wild)
