"""A run, its files and its pictures ask no more of a scene than what every scene has: here one without walls.

The scheme is a stand-in that carries particles with the exact flow: all errors are those of its few large steps.
"""

import json
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from tisph import config, registry, simulation
from tisph.folder import Folder
from tisph.observers.history import read_history
from tisph.schemes._protocol import SampleEstimate
from tisph.snapshot import Snapshot

pytestmark = pytest.mark.taichi

CASE = """
scene: taylor_green
fluid: {density: 2.0, kinematic_viscosity: 0.01}
geometry: {length: 1.0, cells: [2, 1]}
initial: {velocity: 1.0, jitter: 0.2}
discretisation: {particles_across: 12}
scheme: {type: wcsph}
time: {end: 0.2, samples: [0.1, 0.2]}
output: {video: {frames: 2, width: 640, height: 320, color_by: pressure}}
"""
STEPS = 10


class Carried:
    """Particles on the path lines of the exact flow, by midpoint steps."""

    def __init__(self, settings, scene, targets, serial):
        self.channel, self.end = scene, settings.time.end
        self.time, self.steps = scene.start_time, 0
        self.shortest = self.longest = settings.time.end / STEPS

    def start(self, position, velocity, stress=None):
        self.place = position.T.copy()
        assert velocity.shape == position.shape
        assert stress is None

    @property
    def finished(self):
        return self.steps == STEPS

    def advance(self):
        middle = self.place + 0.5 * self.longest * self._velocity(self.place, self.time)
        self.place = self.place + self.longest * self._velocity(middle, self.time + 0.5 * self.longest)
        self.steps += 1
        self.time = self.end * self.steps / STEPS

    def _velocity(self, place, t):
        return np.stack([self.channel.exact(name, *place, t) for name in "uv"])

    def output_times(self, due):
        return [self.time]

    def snapshot(self, at=None):
        x, y = self.place % np.array(self.channel.extent)[:, None]
        u, v = self._velocity(self.place, self.time)
        pressure = self.channel.exact("pressure", x, y, self.time)
        return Snapshot(self.time, self.steps, x, y, u, v, np.full_like(x, 2.0), pressure)

    def numbers(self):
        return {}

    def momentum_balance(self):
        return {"final": 0.0}


def estimates(settings, scene):
    sample = SampleEstimate(t=0.2, steps=STEPS, l2=None, rms=None)
    numbers = {"mach": 0.0, "sound_speed": None, "time_step": 0.02, "binding_limit": "cfl"}
    return {**numbers, "steps": STEPS, "run_time": 1.0, "lost": False, "samples": [sample]}


@pytest.fixture
def settings(tmp_path, monkeypatch):
    load = registry.load
    scheme = SimpleNamespace(build=Carried, estimates=estimates, Parameters=load("schemes", "wcsph").Parameters)
    monkeypatch.setattr(registry, "load", lambda *name: scheme if name == ("schemes", "wcsph") else load(*name))
    monkeypatch.setattr("tisph.config.schema._boxes", lambda scheme: [(True, True)])
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    return config.load(path)


def test_a_run_leaves_all_its_files(settings, tmp_path):
    folder = Folder(simulation.run(settings, tmp_path / "out"))
    summary = json.loads(folder.summary.read_text())
    assert summary["status"] == "done"
    first, last = summary["samples"]
    assert (first["t"], first["t_star"], last["t"]) == (0.1, 0.1, 0.2)
    assert max(last["l2"], last["l2_pressure"]) < 1e-14  # places wrapped into the box: roundings of phases
    assert last["kinetic_energy"] == pytest.approx(last["kinetic_energy_exact"], rel=1e-12)  # sums of 288 squares
    assert 0.3 < last["min_distance"] < 1.0 < last["max_void_radius"] + 0.3
    times, energy = read_history(folder.history)
    assert len(times) == STEPS + 1
    assert np.all(np.diff(energy[:, 0]) < 0)
    with h5py.File(folder.samples) as file:
        assert file.attrs["scene"] == "taylor_green"
        assert file.attrs["cells"].tolist() == [2, 1]
        assert {"u_exact", "v_exact", "pressure_exact"} < set(file["sample_001"])
    with h5py.File(folder.frames) as file:
        assert "pressure" in file["frame_00000"]
    for picture in (folder.profiles_picture, folder.history_picture, folder.movie):
        assert picture.stat().st_size > 0
    assert config.load(folder.config) == settings
    before = folder.profiles_picture.read_bytes()
    assert set(simulation.render(folder.root)) == {folder.profiles_picture, folder.history_picture, folder.movie}
    assert folder.profiles_picture.read_bytes() == before
