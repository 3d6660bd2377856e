"""Samples and history: written and read again, with names, units and the exact solution beside."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from report_scene import make_snapshot

from tisph import __version__
from tisph.config import load
from tisph.observers.history import History, read_history
from tisph.observers.samples import Description, Frames, Samples, read_frames, read_samples, write_snapshot
from tisph.scenes.channel import Channel
from tisph.snapshot import Bodies, Snapshot


def tiny_snapshot(t):
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
        write_snapshot(file.create_group("sample_000"), tiny_snapshot(0.5))
        write_snapshot(file.create_group("sample_001"), Snapshot(1.0, 2, *np.ones((6, 3))))
    first, last = read_samples(tmp_path / "samples.h5")
    assert_same_bodies(first.bodies, tiny_snapshot(0.5).bodies)
    assert last.bodies is None


def test_the_frames_of_an_interrupted_run_are_drawn_again_with_their_bodies(tmp_path):
    drawn = []
    film = SimpleNamespace(add=drawn.append, close=lambda: None)
    path, times = tmp_path / "frames.h5", [0.0, 0.5, 1.0]
    frames = Frames(path, film, times)
    for t in times[:2]:
        frames.observe(tiny_snapshot(t))
    frames.flush()
    for resumed_at, expected in ((0.5, times[:2]), (0.25, times[:1])):
        drawn.clear()
        Frames(path, film, times, resumed_at).close()
        assert [frame.t for frame in drawn] == expected
        for frame in (*drawn, *read_frames(path)):
            assert_same_bodies(frame.bodies, tiny_snapshot(frame.t).bodies)


POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4}"
SMALL = ("discretisation.particles_across=12", "units={length: cm, mass: g, time: s}")
TIMES = [0.5, 2.0]


@pytest.fixture
def run(case):
    """Return a function that gives the channel and the description of the case with overrides."""

    def build(*overrides):
        config = case(*SMALL, *overrides)
        channel = Channel.from_config(config)
        return channel, Description(config, channel)

    return build


def written_samples(path, channel, about=None):
    samples = Samples(path, channel, TIMES, about=about)
    for t in TIMES:
        samples.observe(make_snapshot(channel, t, slip=1e-3))
    samples.close()
    return samples


def test_samples_have_attributes_and_units(tmp_path, run):
    channel, about = run(POLYMER)
    written_samples(tmp_path / "samples.h5", channel, about)
    with h5py.File(tmp_path / "samples.h5") as file:
        said = dict(file.attrs)
        units = {name: data.attrs["units"] for name, data in file["sample_001"].items()}
    assert said["tisph_version"] == __version__
    assert (said["scene"], said["rheology"]) == ("channel", "oldroyd_b")
    assert (said["gap"], said["length"], said["density"], said["kinematic_viscosity"]) == (1.0, 2.0, 1.0, 0.01)
    assert (said["relaxation_time"], said["solvent_fraction"]) == (0.5, 0.4)
    assert said["units"] == "length cm, mass g, time s"
    (tmp_path / "again.yaml").write_text(said["config"])
    assert load(tmp_path / "again.yaml") == about.config
    assert (units["y"], units["u"], units["u_exact"], units["density"]) == ("cm", "cm/s", "cm/s", "g/cm^3")
    assert units["stress_xy"] == units["stress_xy_exact"] == units["pressure"] == "g/(cm s^2)"


def test_an_interrupted_run_resumes_with_samples_of_older_versions(tmp_path, run):
    channel, about = run()
    path = tmp_path / "samples.h5"
    written_samples(path, channel, about)
    kept = Samples(path, channel, TIMES, resumed_at=1.0, about=about).snapshots
    assert [snapshot.t for snapshot in kept] == [0.5]
    with h5py.File(path, "r+") as file:  # as it was before there was anything but snapshots
        assert set(file) == {"sample_000"}
        file.attrs.clear()
        del file["sample_000"]["u_exact"]
    (old,) = read_samples(path)
    assert np.array_equal(old.u, kept[0].u)
    (again,) = Samples(path, channel, TIMES, resumed_at=1.0, about=about).snapshots
    assert np.array_equal(again.reference["u"], kept[0].reference["u"])


def history_lines(path):
    lines = path.read_text().splitlines()
    comments = [line for line in lines if line.startswith("#")]
    return comments, lines[len(comments) :]


def test_history_says_what_it_is_and_what_is_exact(tmp_path, run):
    channel, about = run()
    path = tmp_path / "history.csv"
    history = History(path, channel, channel.time_series(3), 20.0, about=about)
    for t in (0.0, 0.25, 20.0):
        history.observe(make_snapshot(channel, t))
    before = read_history(path)
    assert history_lines(path)[1][0] == "t,u(y=0.166667),u(y=0.5),u(y=0.833333),resolved"
    history.close()
    comments, (names, *rows) = history_lines(path)
    assert {"# units: length cm, mass g, time s", "# gap: 1.0", "#   scene: channel"} <= set(comments)
    assert names.split(",")[4:] == ["resolved", "u_exact(y=0.166667)", "u_exact(y=0.5)", "u_exact(y=0.833333)"]
    table = np.array([[float(value) for value in row.split(",")] for row in rows])
    # two spacings of 1/12 are crossed at t = (1/6)^2 / 0.01 = 2.8
    assert table[:, 4].tolist() == [0.0, 0.0, 1.0]
    # the series is cut where it is below rounding, which depends on the times that are asked for together
    exact = channel.exact_velocity(history.time_series.places, table[:, :1])
    assert np.array_equal(table[:, 5:], exact)
    after = read_history(path)
    assert all(np.array_equal(one, other) for one, other in zip(before, after, strict=True))
    assert np.array_equal(after[1], table[:, 1:4])


def test_numbers_that_are_none_leave_their_cells_empty(tmp_path, run):
    channel, _ = run()
    path = tmp_path / "history.csv"
    history = History(path, channel, channel.time_series(2), 20.0)
    for t, values in ((0.0, [np.nan, np.inf]), (10.0, [0.25, -0.5])):
        history.record(t, values, channel)
    history.close()
    assert history_lines(path)[1][1].startswith("0.0,,inf,0,")
    times, values = read_history(path)
    assert times.tolist() == [0.0, 10.0]
    assert np.array_equal(values, [[np.nan, np.inf], [0.25, -0.5]], equal_nan=True)


def test_the_history_of_older_versions_is_read(tmp_path):
    path = tmp_path / "history.csv"
    path.write_text("t,u(y=0.25),u(y=0.75)\n0.0,0.0,0.0\n1.5,0.25,0.5\n2.0,0.3")
    times, velocities = read_history(path)
    assert times.tolist() == [0.0, 1.5]
    assert velocities.tolist() == [[0.0, 0.0], [0.25, 0.5]]
