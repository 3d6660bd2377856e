"""Cylinders whose angular velocities are given at some times: errors, restarts, what is refused, what is read."""

from dataclasses import replace

import annulus_case as case
import numpy as np
import pytest

from tisph import config, registry, runtime, schemes
from tisph.errors import ConfigError
from tisph.exact._fluids import ViscoelasticFluid
from tisph.exact.start_up import CircularStartUp
from tisph.geometry.motion import Schedule, WallMotion
from tisph.rheometry.rheometers import read
from tisph.schemes._forecast import estimates
from tisph.schemes.implicit.planar.scheme import PlanarScheme
from tisph.simulation import checkpoint

pytestmark = pytest.mark.taichi

PULSE = Schedule((0.0, 0.1, 0.1), (1.0, 1.0, 0.0))
END = 0.15


def started():
    runtime.start("f64", 1)
    flow, places = case.make((PULSE, 0.0), viscosity=1.0)
    scheme = PlanarScheme(flow, [END], True, tolerance=1e-4)
    scheme.start(places, np.zeros_like(places))
    return scheme


def error(snapshot):
    """Root mean square of the velocities' error, over the speed that the cylinder had."""
    exact = CircularStartUp(case.INNER, case.OUTER, ViscoelasticFluid(1.0, ()), PULSE, WallMotion(0.0))
    radius = np.hypot(snapshot.x, snapshot.y)
    around = (snapshot.x * snapshot.v - snapshot.y * snapshot.u) / radius
    return np.sqrt(np.mean((around - exact.velocity(radius, END)) ** 2))


def test_a_cylinder_that_stops(tmp_path):
    scheme, kept = started(), None
    while not scheme.finished:
        scheme.advance()
        if scheme.time == 0.1:  # a step ended there
            checkpoint.save(tmp_path / "state.h5", scheme, "fingerprint")
            kept = scheme.steps + 3
        elif scheme.steps == kept:
            seen = scheme.snapshot()
    assert error(scheme.snapshot()) < 1e-4  # twelve across; measured: 5.6e-5

    resumed = started()
    checkpoint.restore(tmp_path / "state.h5", resumed, "fingerprint")
    for _ in range(3):
        resumed.advance()
    for name in ("x", "y", "u", "v", "pressure"):
        assert np.array_equal(getattr(resumed.snapshot(), name), getattr(seen, name)), name


@pytest.mark.slow
def test_polynomials_in_time_across_a_jump_have_large_errors():
    scheme = started()
    scheme.problem = replace(scheme.problem, jump_times=())
    while not scheme.finished:
        scheme.advance()
    assert error(scheme.snapshot()) > 1e-3  # measured: 1.6e-3


CASE = """
scene: annulus
fluid: {density: 1.0, kinematic_viscosity: 1.0}
geometry: {inner_radius: 1.0, outer_radius: 2.0}
walls: {inner: {times: [0.0, 0.2, 0.2], angular_velocities: [0.5, 0.5, 0.0]}}
discretisation: {particles_across: 12}
time: {end: 1.0}
"""


@pytest.fixture
def load(tmp_path):
    """Return a function that gives the config of overrides."""

    def build(*overrides):
        (tmp_path / "case.yaml").write_text(CASE)
        return config.load(tmp_path / "case.yaml", overrides)

    return build


def test_steps_of_two_starts_are_known_before(load):
    pulse = "walls.inner={times: [0.0, 0.1, 0.1], angular_velocities: [1.0, 1.0, 0.0]}"
    numbers = estimates(load(pulse, f"time.end={END}", "time.tolerance=1e-4"))
    assert numbers["steps"] < 85 < 2.5 * numbers["steps"]  # of ``test_a_cylinder_that_stops``: two starts, 2.07 times


def test_the_scene_knows_the_schedule(load):
    annulus = registry.load("scenes", "annulus").Scene.from_config(load())
    assert annulus.jump_times == (0.2,)
    assert annulus.bodies[0].motion.rotation == Schedule((0.0, 0.2, 0.2), (0.5, 0.5, 0.0))
    assert annulus.reference_velocity == 0.5
    assert annulus.exact_around(1.0, 0.0, 0.1) == pytest.approx(0.5)
    assert annulus.exact_around(1.0, 0.0, 0.21) == pytest.approx(0.0, abs=1e-12)
    # the layer of the stop is thin again
    assert annulus.thinnest_layer(0.21) == (pytest.approx(0.1), "the layer at the inner cylinder")


REFUSED = {
    "scheme={type: wcsph}": r"wcsph has no wall with velocities at times \(walls.inner\); take implicit",
    "walls.inner.times=[0.0, 0.2]": "must be as many times, .* as there are angular_velocities, 3",
    "walls.inner.times=[0.0, 0.3, 0.2]": "must ascend from 0 on",
    "walls.inner.angular_velocities=[0.0, 0.0, 0.0]": "must not all be 0: for a wall at rest give angular_velocity: 0",
    "walls.inner.phase=sin": "is not for a wall with angular_velocities at times",
    "walls.outer.times=[0.0, 1.0]": "is only for a wall with angular_velocities at times",
    "initial={state: developed}": r"must be rest where a wall has velocities at times \(walls.inner\)",
}


@pytest.mark.parametrize("override", REFUSED)
def test_what_is_not_served_is_refused(load, override):
    with pytest.raises(ConfigError, match=REFUSED[override]):
        schemes.resolve(load(override))


def test_a_newtonian_ramp_is_read_as_a_flow_curve(load):
    settings = load("walls.inner={times: [0.0, 10.0], angular_velocities: [0.0, 1.0]}")
    annulus = registry.load("scenes", "annulus").Scene.from_config(settings)
    t = np.linspace(0.0, 10.0, 21)
    torque = -4.0 * np.pi * 4.0 / 3.0 * 0.1 * t  # without inertia, as this history says
    reading = read(settings, annulus, {"t": t, "torque_inner": torque, "torque_inner_exact": torque})
    assert reading.title == "flow curve"
    assert reading.numbers["fastest_rate"] == pytest.approx(8.0 / 3.0)
    assert max(reading.numbers[f"off_by_{name}"] for name in ("inertia", "memory")) < 1e-12
