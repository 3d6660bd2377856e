"""Whole runs through the command line: files, repeatability, restart, and what happens when things go wrong."""

import json
import os
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from tisph import config, simulation
from tisph.simulation import checkpoint

CASE = """
name: small
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 1.0}
walls: {top: {velocity: 0.5}}
discretisation: {particles_across: 12}
initial: {jitter: 0.2}
scheme: {type: wcsph}
time: {end: 1.0, samples: [0.4, 1.0]}
output: {video: {frames: 5, width: 640, height: 320}}
"""


@pytest.fixture
def tisph(tmp_path):
    """Return a function that runs the command line on the small case in a fresh process."""
    (tmp_path / "small.yaml").write_text(CASE)

    def call(command, *arguments, status=0, **environment):
        done = subprocess.run(
            [sys.executable, "-m", "tisph", command, *arguments],
            cwd=tmp_path,
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
        )
        assert done.returncode == status, done.stderr
        return done

    return call


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def samples(folder):
    with h5py.File(folder / "samples.h5") as file:
        return {name: {key: group[key][...] for key in group} | dict(group.attrs) for name, group in file.items()}


def same_bits(one, other):
    assert one.keys() == other.keys()
    for name in one:
        for key in one[name]:
            assert np.array_equal(one[name][key], other[name][key]), f"{name}/{key}"


def test_a_run_leaves_all_that_is_promised(tisph, tmp_path):
    tisph("run", "small.yaml", "--out", "out")
    out = tmp_path / "out"
    for name in (
        "config.resolved.yaml",
        "summary.json",
        "samples.h5",
        "history.csv",
        "profiles.png",
        "history.png",
        "movie.mp4",
        "run.log",
    ):
        assert (out / name).stat().st_size > 0, name
    numbers = summary(out)
    assert numbers["status"] == "done"
    assert [sample["t"] for sample in numbers["samples"]] == [0.4, 1.0]
    stored = samples(out)
    assert [stored[name]["t"] for name in sorted(stored)] == [0.4, 1.0]
    for name in ("x", "y", "u", "v", "density", "pressure"):
        assert stored["sample_001"][name].shape == (144,)
    lines = [line for line in (out / "history.csv").read_text().splitlines() if not line.startswith("#")]
    history = np.loadtxt(lines, delimiter=",", skiprows=1)
    assert history[0, 0] == 0.0
    assert history[-1, 0] == 1.0
    assert history.shape[1] == 1 + 10 + 1 + 10  # t, u, resolved, u_exact


def test_a_run_begins_with_the_warnings_of_check(tisph):
    # a Mach number of 1/6
    soft = ["--set", "scheme.equation_of_state={sound_speed: 3.0}", "--set", "time={end: 0.05}"]
    checked = tisph("check", "small.yaml", *soft)
    expected = [line.strip() for line in checked.stdout.splitlines() if "warning" in line]
    assert expected
    case = ["run", "small.yaml", *soft, "--out", "out", "--no-video", "--set", "output.checkpoint_every=0.02"]
    assert tisph(*case).stderr.splitlines()[: len(expected)] == expected
    assert tisph(*case, "--resume").stderr.splitlines()[: len(expected)] == expected


def test_a_run_of_which_check_warns_of_nothing_warns_of_nothing(tisph):
    resolved = ["small.yaml", "--set", "fluid.kinematic_viscosity=0.1"]  # two spacings from t = (2/12)^2/0.1 = 0.28 on
    assert "warning" not in tisph("check", *resolved).stdout
    done = tisph("run", *resolved, "--out", "out", "--no-video")
    assert "warning" not in done.stdout + done.stderr


def test_the_resolved_config_reproduces_the_run(tisph, tmp_path):
    tisph("run", "small.yaml", "--out", "one", "--no-video")
    tisph("run", "one/config.resolved.yaml", "--out", "two", "--no-video")
    same_bits(samples(tmp_path / "one"), samples(tmp_path / "two"))


@pytest.mark.parametrize(
    "choice",
    ["walls.treatment.type=comoving_image", "walls.treatment.type=adami", "scheme={type: implicit}"],
)
def test_the_same_bits_whatever_is_observed_and_on_one_thread_or_two(tisph, tmp_path, choice):
    # 25 across: 625 particles, which two threads share; each particle is summed by one thread in list order
    case = ["--set", "discretisation.particles_across=25", "--set", choice]
    tisph("run", "small.yaml", "--out", "one", *case, "--set", "runtime.threads=1")
    tisph("run", "small.yaml", "--out", "two", *case, "--set", "runtime.threads=2", "--no-video")
    same_bits(samples(tmp_path / "one"), samples(tmp_path / "two"))


def test_an_interrupted_run_goes_on_to_the_same_bits(tmp_path, monkeypatch):
    (tmp_path / "small.yaml").write_text(CASE)
    settings = config.load(tmp_path / "small.yaml", ["output.checkpoint_every=0.5"])
    simulation.run(settings, tmp_path / "whole")
    save = checkpoint.save

    def interrupted_save(*arguments):
        monkeypatch.setattr(checkpoint, "save", save)
        signal.raise_signal(signal.SIGINT)
        save(*arguments)

    monkeypatch.setattr(checkpoint, "save", interrupted_save)
    with pytest.raises(KeyboardInterrupt):
        simulation.run(settings, tmp_path / "cut")
    stopped = summary(tmp_path / "cut")
    assert stopped["status"] == "interrupted"
    assert [sample["t"] for sample in stopped["samples"]] == [0.4]
    simulation.run(settings, tmp_path / "cut", resume=True)
    assert summary(tmp_path / "cut")["status"] == "done"
    same_bits(samples(tmp_path / "cut"), samples(tmp_path / "whole"))
    assert (tmp_path / "cut/history.csv").read_text() == (tmp_path / "whole/history.csv").read_text()
    with h5py.File(tmp_path / "cut/frames.h5") as cut, h5py.File(tmp_path / "whole/frames.h5") as whole:
        assert [cut[name].attrs["step"] for name in cut] == [whole[name].attrs["step"] for name in whole]


def test_checkpoints_of_the_config_can_be_resumed(tisph, tmp_path):
    tisph("run", "small.yaml", "--out", "out", "--no-video", "--set", "output.checkpoint_every=0.3")
    before = samples(tmp_path / "out")
    tisph("run", "small.yaml", "--out", "out", "--no-video", "--set", "output.checkpoint_every=0.3", "--resume")
    same_bits(samples(tmp_path / "out"), before)


def test_a_foreign_or_broken_checkpoint_is_refused(tisph, tmp_path):
    every = ["--no-video", "--set", "output.checkpoint_every=0.3"]
    tisph("run", "small.yaml", "--out", "out", *every)
    other = tisph("run", "small.yaml", "--out", "out", *every, "--set", "initial.seed=1", "--resume", status=2)
    assert "another config" in other.stderr
    (tmp_path / "out/checkpoint.h5").write_bytes(b"not a checkpoint")
    broken = tisph("run", "small.yaml", "--out", "out", *every, "--resume", status=2)
    assert "cannot be read" in broken.stderr
    assert summary(tmp_path / "out")["status"] == "done"


def test_a_run_that_goes_wrong_says_what_and_keeps_what_it_had(tisph, tmp_path):
    # four times the stable time step
    failed = tisph("run", "small.yaml", "--out", "out", "--set", "time.cfl=1.0", "--set", "time.end=30.0", status=3)
    for word in ("particle", "step", "t ="):
        assert word in failed.stderr
    assert "Traceback" not in failed.stderr
    out = tmp_path / "out"
    assert summary(out)["status"] == "diverged"
    for name in ("last_good.png", "last_good.h5", "movie.mp4", "history.csv"):
        assert (out / name).stat().st_size > 0, name
    with h5py.File(out / "last_good.h5") as file:
        last = file.attrs["step"]
        assert np.isfinite(file["u"][...]).all()
    step = int(failed.stderr.split("at step ")[1].split(",")[0])
    assert step - last <= 100


def test_render_draws_again_from_the_files(tisph, tmp_path):
    tisph("run", "small.yaml", "--out", "out")
    names = ("movie.mp4", "profiles.png", "history.png")
    for name in names:
        (tmp_path / "out" / name).unlink()
    tisph("render", "out")
    for name in names:
        assert (tmp_path / "out" / name).stat().st_size > 0


@pytest.mark.parametrize(
    ("scheme", "treatment", "across"),
    [
        ("wcsph", "comoving_image", 6),
        ("wcsph", "comoving_image", 12),
        ("wcsph", "adami", 6),
        ("wcsph", "adami", 12),
        ("implicit", "consistent_image", 12),
        ("implicit", "virtual_image", 6),
    ],
)
def test_no_kernel_reads_or_writes_out_of_bounds(tisph, scheme, treatment, across):
    # Taichi checks every index in debug mode; without it a bad one passes silently
    case = ["--set", f"discretisation.particles_across={across}", "--set", "geometry.length=2.0"]
    walls = ["--set", f"walls.treatment.type={treatment}", "--set", "initial.jitter=0.3"]
    options = [*case, *walls, "--set", f"scheme={{type: {scheme}}}"]
    tisph("run", "small.yaml", "--out", f"{scheme}_{treatment}{across}", "--no-video", *options, TI_DEBUG="1")


@pytest.mark.skipif(os.name == "nt", reason="HOME decides on POSIX systems only")
@pytest.mark.parametrize("home", ["/proc/nowhere", None])
def test_runs_without_a_home_to_keep_compiled_kernels_in(tmp_path, home):
    (tmp_path / "small.yaml").write_text(CASE)
    environment = {key: value for key, value in os.environ.items() if key not in ("HOME", "XDG_CACHE_HOME")}
    command = [sys.executable, "-m", "tisph", "run", "small.yaml", "--out", "out", "--set", "time.end=0.4"]
    done = subprocess.run(
        [*command, "--set", "time.samples=[0.4]"],
        cwd=tmp_path,
        env={**environment, **({"HOME": home} if home else {})},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def test_a_second_run_into_the_same_folder_is_refused(tisph, tmp_path):
    command = [sys.executable, "-m", "tisph", "run", "small.yaml", "--out", "out"]
    first = subprocess.Popen([*command, "--set", "time.end=1000.0"], cwd=tmp_path)  # longer than any machine waits
    history = tmp_path / "out/history.csv"
    while not history.exists() or history.read_text().count("\n") < 10:
        assert first.poll() is None
        time.sleep(0.01)
    try:
        refused = tisph("run", "small.yaml", "--out", "out", "--overwrite", status=2)
        assert "is in use, another run is writing there" in refused.stderr
    finally:
        first.send_signal(signal.SIGTERM)
        first.wait()
    assert summary(tmp_path / "out")["status"] == "interrupted"


def test_a_damaged_history_is_no_traceback_on_resume(tisph, tmp_path):
    every = ["--no-video", "--set", "output.checkpoint_every=0.3"]
    tisph("run", "small.yaml", "--out", "out", *every)
    (tmp_path / "out/history.csv").write_text("t,u\nnonsense\n")
    refused = tisph("run", "small.yaml", "--out", "out", *every, "--resume", status=2)
    assert "cannot be read" in refused.stderr
    assert "Traceback" not in refused.stderr


@pytest.mark.skipif(os.name == "nt", reason="HOME decides on POSIX systems only")
def test_compiled_kernels_are_kept_for_the_next_run(tisph, tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    folders = {"HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache")}
    tisph("run", "small.yaml", "--out", "out", "--no-video", "--set", "time={end: 0.01}", **folders)
    assert list((home / ".cache" / "tisph").rglob("*.tic"))
