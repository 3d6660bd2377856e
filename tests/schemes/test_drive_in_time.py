"""A drive that oscillates beside its mean, or has values at times: against the reference, in channels and pipes."""

import numpy as np
import pytest

import tisph
from tisph.errors import ConfigError
from tisph.schemes.implicit.channel.walls import PrescribedWall

pytestmark = pytest.mark.taichi

CHANNEL = {
    "scene": "channel",
    "fluid": {"density": 2.0, "kinematic_viscosity": 0.1},
    "geometry": {"gap": 1.0, "length": 1.0},
    "discretisation": {"particles_across": 40},
    "initial": {"jitter": 0.2},
    "time": {"end": 1.0, "samples": [0.3, 1.0], "tolerance": 1e-6},
    "output": {"video": None},
}
PIPE = {
    **CHANNEL,
    "scene": "pipe",
    "geometry": {"radius": 1.0, "length": 1.0},
    "discretisation": {"particles_across": 24},
}
SWING = {"acceleration": 1.0, "amplitude": 2.0, "angular_frequency": 4.0, "phase": "sin"}
RAMPS = {"times": [0.0, 0.3, 0.6, 0.6], "accelerations": [0.2, 1.5, 1.5, -1.0]}
POLYMER = {"relaxation_time": 0.5, "solvent_fraction": 0.3}
LAWS = {
    "newtonian": {"type": "newtonian"},
    "oldroyd_b": {"type": "oldroyd_b", **POLYMER},
    "giesekus": {"type": "giesekus", "mobility": 0.2, **POLYMER},
    "carreau_yasuda": {"type": "carreau_yasuda", "time": 1.0, "index": 0.5},
}
SLIP, STRESS = {"walls.top.slip_length": 0.2}, {"walls.top.shear_stress": 0.2, "walls.top.mass_per_area": 0.5}


def errors(case, drive, law="newtonian", **more):
    """Return the errors of the velocity at both samples, and the residual of the momentum balance if there is one."""
    fluid = {**case["fluid"], "rheology": LAWS[law]}
    with tisph.Simulation({**case, "fluid": fluid, "drive": drive}, **more) as sim:
        found = [sim.run_until(t).l2 for t in (0.3, 1.0)]
        return found, sim.scheme.momentum_balance()["closure"] if sim.scene.parallel else 0.0


@pytest.mark.parametrize("drive", [SWING, RAMPS], ids=["swing", "ramps"])
@pytest.mark.parametrize("law", LAWS)
def test_channels_meet_the_reference(law, drive):
    found, closure = errors(CHANNEL, drive, law)
    # where the shear rate changes its sign, a viscosity that falls with it has a kink: measured 9.6e-4, order 3
    assert max(found) < (2e-3 if law == "carreau_yasuda" else 1e-4)
    assert closure < 3e-3


@pytest.mark.parametrize("more", [SLIP, STRESS, {"initial.state": "developed"}], ids=["slip", "stress", "developed"])
def test_other_walls_and_starts_meet_the_reference(more):
    assert max(errors(CHANNEL, SWING, **more)[0]) < 1e-4


def test_walls_need_to_know_how_the_drive_changes(monkeypatch):
    right = max(errors(CHANNEL, RAMPS, "oldroyd_b")[0])
    monkeypatch.setattr(PrescribedWall, "later_jumps", lambda *_: (0.0, 0.0))
    assert max(errors(CHANNEL, RAMPS, "oldroyd_b")[0]) > 1.5 * right


@pytest.mark.parametrize("drive", [SWING, RAMPS], ids=["swing", "ramps"])
def test_pipes_meet_the_reference(drive):
    assert max(errors(PIPE, drive)[0]) < 1e-4


def test_the_explicit_scheme_follows_the_drive():
    explicit = {"scheme.type": "wcsph", "discretisation.particles_across": 16, "time.tolerance": "auto"}
    constant = max(errors(CHANNEL, {"acceleration": 1.0}, **explicit)[0])
    for drive in (SWING, RAMPS):
        assert max(errors(CHANNEL, drive, **explicit)[0]) < 2.0 * constant


def test_single_precision_is_as_good_as_its_rounding():
    assert max(errors(CHANNEL, SWING, **{"discretisation.precision": "f32"})[0]) < 2e-4


@pytest.mark.parametrize(
    ("drive", "more", "words"),
    [
        (RAMPS, {"initial.state": "developed"}, "must be rest where the drive has accelerations at times"),
        (SWING, {"initial.state": "developed"}, "no periodic flow is built in"),
        (SWING, {"bodies": [{"centre": [0.5, 0.5], "radius": 0.25}]}, "drive.amplitude .* must be left out"),
        ({**RAMPS, "amplitude": 1.0, "angular_frequency": 2.0}, {}, "must be left out beside accelerations"),
        ({"times": [0.0]}, {}, "is only for accelerations"),
        ({"times": [0.0], "accelerations": [1.0, 2.0]}, {}, "as many times"),
    ],
)
def test_a_drive_that_has_no_flow_is_refused(drive, more, words):
    fluid = {**CHANNEL["fluid"], "rheology": LAWS["giesekus"]}
    with pytest.raises(ConfigError, match=words):
        tisph.check({**CHANNEL, "fluid": fluid, "drive": drive}, **more)


def test_the_drive_gives_its_impulse():
    with tisph.Simulation({**CHANNEL, "drive": RAMPS}) as sim:
        drive, times = sim.scene.drive, np.linspace(0.0, 1.0, 100001)
    values = [drive.value(t) for t in times]
    assert drive.gained(0.0, 1.0) == pytest.approx(np.trapezoid(values, times), abs=1e-4)
