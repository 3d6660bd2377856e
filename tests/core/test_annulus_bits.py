"""A flow between walls, force on them included, has the same bits on any number of threads."""

import numpy as np

from tisph import config, families, runtime
from tisph.least_squares import rows
from tisph.scenes.annulus import Annulus
from tisph.simulation.start import start_values

CASE = """
scene: annulus
fluid: {density: 1.0, kinematic_viscosity: 0.02}
geometry: {inner_radius: 1.0, outer_radius: 2.0}
walls: {inner: {angular_velocity: 1.0}}
initial: {jitter: 0.2}
discretisation: {particles_across: 12}
time: {end: 1.0}
"""
STEPS = 4


def start(settings, threads):
    """Return the scheme of a run on so many ``threads``, at its start."""
    runtime.start("f64", threads)
    scene = Annulus.from_config(settings)
    scheme = families.load("schemes", "implicit").Scheme(settings, scene, [1.0], threads == 1)
    scheme.start(*start_values(scene, settings.initial))
    return scheme


def test_one_and_two_threads_give_the_same_bits(tmp_path, monkeypatch):
    monkeypatch.setattr(rows, "FEW", 0)  # or small loops would stay on one thread
    monkeypatch.setattr(rows, "FEW_NUMBERS", 0)
    (tmp_path / "case.yaml").write_text(CASE)
    settings, found = config.load(tmp_path / "case.yaml", ["scheme={type: implicit}"]), []
    for threads in (1, 2):
        scheme = start(settings, threads)
        for _ in range(STEPS):
            scheme.advance()
        found.append(scheme.snapshot())
    one, two = ({**vars(snapshot), **vars(snapshot.bodies)} for snapshot in found)
    for name in ("x", "y", "u", "v", "pressure", "force", "torque", "pressure_torque"):
        assert np.array_equal(one[name], two[name]), name
    assert one["torque"][0] < 0.0 < one["t"]
