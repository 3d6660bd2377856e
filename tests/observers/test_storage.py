"""Snapshots in HDF5 files: what is written is read again, in the order of time."""

from types import SimpleNamespace

import h5py
import numpy as np

from tisph.observers._storage import write_snapshot
from tisph.observers.samples import Frames, read_frames, read_samples
from tisph.snapshot import Bodies, Snapshot


def test_samples_are_read_in_the_order_of_time(tmp_path):
    """By name the thousandth would come before the second: sample_1000 < sample_101."""
    times = (100, 101, 999, 1000, 1001)
    with h5py.File(tmp_path / "samples.h5", "w") as file:
        for t in times:
            write_snapshot(file.create_group(f"sample_{t:03d}"), Snapshot(float(t), t, *np.full((6, 3), t)))
    found = read_samples(tmp_path / "samples.h5")
    assert [snapshot.t for snapshot in found] == list(times)
    assert all(np.array_equal(snapshot.u, np.full(3, snapshot.t)) for snapshot in found)


def make_snapshot(t):
    """Three particles and two bodies, with numbers that single precision cannot hold."""
    bodies = {name: t + np.full((2, 2), 0.1) for name in ("centre", "velocity", "force", "pressure_force")}
    turns = {name: t + np.full(2, 0.3) for name in ("angle", "angular_velocity", "torque", "pressure_torque")}
    normal = t + np.full(2, 0.7) if t else None  # as of a polymer, which one snapshot has and the other not
    return Snapshot(t, 1, *np.full((6, 3), t), bodies=Bodies(**bodies, **turns, normal_stress=normal))


def assert_same_bodies(found, expected):
    assert vars(found).keys() == vars(expected).keys()
    for name, values in vars(expected).items():
        assert np.array_equal(getattr(found, name), values), name


def test_bodies_are_read_as_they_were_written(tmp_path):
    with h5py.File(tmp_path / "samples.h5", "w") as file:
        write_snapshot(file.create_group("sample_000"), make_snapshot(0.5))
        write_snapshot(file.create_group("sample_001"), Snapshot(1.0, 2, *np.ones((6, 3))))
    first, last = read_samples(tmp_path / "samples.h5")
    assert_same_bodies(first.bodies, make_snapshot(0.5).bodies)
    assert last.bodies is None


def test_the_frames_of_an_interrupted_run_are_drawn_again_with_their_bodies(tmp_path):
    drawn = []
    film = SimpleNamespace(add=drawn.append, close=lambda: None)
    path, times = tmp_path / "frames.h5", [0.0, 0.5, 1.0]
    frames = Frames(path, film, times)
    for t in times[:2]:
        frames.observe(make_snapshot(t))
    frames.flush()
    for resumed_at, expected in ((0.5, times[:2]), (0.25, times[:1])):
        drawn.clear()
        Frames(path, film, times, resumed_at).close()
        assert [frame.t for frame in drawn] == expected
        for frame in (*drawn, *read_frames(path)):
            assert_same_bodies(frame.bodies, make_snapshot(frame.t).bodies)
