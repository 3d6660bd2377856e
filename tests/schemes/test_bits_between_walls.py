"""Flows between walls, forces on them included: the same bits on any number of threads, and in single precision."""

from pathlib import Path

import numpy as np
import pytest

from tisph import config, registry, runtime, scenes
from tisph.numerics import least_squares as operators
from tisph.schemes.implicit.planar import wall_points
from tisph.simulation.state import start_values

LATTICE = """
scene: lattice
fluid: {density: 1.0, kinematic_viscosity: 0.02}
geometry: {length: 1.0, height: 1.0}
bodies: [{centre: [0.9, 0.5], radius: 0.2, motion: {velocity: [1.0, 0.0], angular_velocity: 2.0}}]
initial: {jitter: 0.2}
discretisation: {particles_across: 18}
time: {end: 1.0}
"""
"""A cylinder that turns and moves across the edge of its cell."""

pytestmark = [pytest.mark.taichi, pytest.mark.other_program]

STEPS = 4


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    """Return a function that starts the scheme of a case in some precision and on some threads."""
    path = tmp_path_factory.mktemp("case") / "case.yaml"
    path.write_text(LATTICE)

    def started(threads=1, precision="f64"):
        settings = config.load(path, ["scheme={type: implicit}", f"discretisation.precision={precision}"])
        runtime.start(precision, threads)
        scene = scenes.of(settings)
        scheme = registry.load("schemes", "implicit").build(settings, scene, [1.0], threads == 1)
        scheme.start(*start_values(scene, settings.initial))
        return scheme

    return started


@pytest.mark.parametrize("name", ["circular_couette", "eccentric_annulus"])
def test_single_precision_solves_for_the_pressure_between_cylinders(name):
    """The first pressure takes the iterations that it takes in double precision, 5 and 7: it stopped after 200.

    A constant part of the preconditioner's result, which no equation determines, has to be small for that.
    """
    path = Path(__file__).resolve().parents[2] / "configs" / f"{name}.yaml"
    settings = config.load(path, ["scheme={type: implicit}", "discretisation.precision=f32"])
    runtime.start("f32", 1)
    scene = scenes.of(settings)
    scheme = registry.load("schemes", "implicit").build(settings, scene, [1.0], True)
    scheme.start(*start_values(scene, settings.initial))
    assert scheme.equations.pressure.iterations <= 10
    for _ in range(STEPS):
        scheme.advance()
    assert scheme.steps == STEPS


def stepped(scheme):
    """What there is after some steps, by name."""
    for _ in range(STEPS):
        scheme.advance()
    snapshot = scheme.snapshot()
    return {**vars(snapshot), **vars(snapshot.bodies)}


@pytest.fixture(scope="module")
def one(start):
    """What there is after some steps on one thread, in double precision."""
    return stepped(start())


def test_one_and_two_threads_are_bitwise_reproducible(start, one, monkeypatch):
    monkeypatch.setattr(operators, "FEW", 0)  # or small loops would stay on one thread
    monkeypatch.setattr(operators, "FEW_NUMBERS", 0)
    two = stepped(start(2))
    for name in ("x", "y", "u", "v", "pressure", "force", "torque", "pressure_torque"):
        assert np.array_equal(one[name], two[name]), name
    assert np.abs(one["force"]).max() > 0.0 < one["t"]


@pytest.mark.slow  # that of the box without walls is in test_two_dimensional.py
def test_single_precision_gives_the_same_flow(start, monkeypatch):
    """It has plain rows near curved walls, and so has double precision here.

    Rounding of 6e-8 in the places, over a spacing of 1/14 or 1/18 and times the rows' largest entries, about 10.
    Measured: velocities 2e-5, forces 1.3e-3, pressure 9e-3; these are divided by the short first steps.
    """
    monkeypatch.setattr(wall_points, "CURVED", -1.0)
    single, double = (stepped(start(precision=precision)) for precision in ("f32", "f64"))
    assert single["t"] == pytest.approx(double["t"], rel=1e-3)  # the step follows the error, which has its own rounding
    for name in ("x", "y", "u", "v"):
        assert np.abs(single[name] - double[name]).max() < 1e-4, name
    for name, part in {"force": 1e-2, "pressure": 5e-2}.items():
        assert np.abs(single[name] - double[name]).max() < part * np.abs(double[name]).max(), name
