"""Cylinders whose angular velocities are given at some times: errors, restarts, what is refused, what is read."""

import functools

import annulus_case as case
import numpy as np
import pytest
from case_from_text import to_end
from same_bits import check_resuming

from tisph import registry, runtime
from tisph.exact._fluids import ViscoelasticFluid
from tisph.exact.start_up import CircularStartUp
from tisph.geometry.motion import Schedule, WallMotion
from tisph.rheometry.rheometers import read
from tisph.schemes._forecast import estimates
from tisph.schemes.implicit.planar.scheme import PlanarScheme

pytestmark = pytest.mark.taichi

PULSE = Schedule((0.0, 0.1, 0.1), (1.0, 1.0, 0.0))
END = 0.15


def started(started=True):
    runtime.start("f64", 1)
    flow, places = case.make((PULSE, 0.0), viscosity=1.0)
    scheme = PlanarScheme(flow, [END], True, tolerance=1e-4)
    if started:
        scheme.start(places, np.zeros_like(places))
    return scheme


def error(snapshot):
    """Root mean square of the velocities' error, over the speed that the cylinder had."""
    exact = CircularStartUp(case.INNER, case.OUTER, ViscoelasticFluid(1.0, ()), PULSE, WallMotion(0.0))
    radius = np.hypot(snapshot.x, snapshot.y)
    around = (snapshot.x * snapshot.v - snapshot.y * snapshot.u) / radius
    return np.sqrt(np.mean((around - exact.velocity(radius, END)) ** 2))


def test_a_cylinder_that_stops(tmp_path):
    scheme = started()
    while scheme.time < 0.1:  # a step ends there
        scheme.advance()
    assert scheme.time == 0.1
    jump = scheme.steps
    assert error(to_end(scheme)) < 1e-4  # twelve across; measured: 5.6e-5
    check_resuming(started, tmp_path, stops=(jump,), steps=jump + 3)


@pytest.fixture
def load(load_flow):
    """Return a function that gives the config of overrides."""
    return functools.partial(load_flow, "stopped_cylinder")


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
    assert annulus.thinnest_layer(0.21)[:2] == (pytest.approx(0.1), "the layer at the inner cylinder")


def test_a_newtonian_ramp_is_read_as_a_flow_curve(load):
    settings = load("walls.inner={times: [0.0, 10.0], angular_velocities: [0.0, 1.0]}")
    annulus = registry.load("scenes", "annulus").Scene.from_config(settings)
    t = np.linspace(0.0, 10.0, 21)
    torque = -4.0 * np.pi * 4.0 / 3.0 * 0.1 * t  # without inertia, as this history says
    reading = read(settings, annulus, {"t": t, "torque_inner": torque, "torque_inner_exact": torque})
    assert reading.title == "flow curve"
    assert reading.numbers["fastest_rate"] == pytest.approx(8.0 / 3.0)
    assert max(reading.numbers[f"off_by_{name}"] for name in ("inertia", "memory")) < 1e-12
