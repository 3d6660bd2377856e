"""Flows between walls, forces on them included: the same bits on any number of threads, and in single precision."""

from pathlib import Path

import numpy as np
import pytest
from flows import flow_text

from tisph import config, registry, runtime, scenes
from tisph.numerics import least_squares as operators
from tisph.simulation.state import start_values

LATTICE = flow_text("cylinder_crossing_a_cell")

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
