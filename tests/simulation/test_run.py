"""Whole runs through the command line: files, repeatability, restart, and what happens when things go wrong."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from couette import couette_text
from PIL import Image
from typer.testing import CliRunner

from tisph import cli, config, runtime, scenes, simulation
from tisph.config import yaml_text
from tisph.observers.history import read_history
from tisph.observers.samples import write_snapshot
from tisph.snapshot import Snapshot

pytestmark = pytest.mark.taichi

VORTEX = Path(__file__).parents[2] / "configs/taylor_green.yaml"

OUTPUT = {"video": {"frames": 5, "width": 640, "height": 320}, "checkpoint_every": 0.5}
FLOW = {"scheme": {"type": "wcsph"}, "initial": {"jitter": 0.2}, "time": {"end": 1.0, "samples": [0.4, 1.0]}}
CASE = couette_text(**FLOW, output=OUTPUT)
POLYMER = "oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4"


@pytest.fixture
def tisph(tmp_path):
    """Return a function that calls the command line in this process; small.yaml is the small case."""
    (tmp_path / "small.yaml").write_text(CASE)

    def call(command, *arguments, status=0):
        done = CliRunner().invoke(cli.app, [command, *map(str, arguments)])
        assert done.exit_code == status, done.stderr
        return done

    return call


@pytest.fixture
def run(tisph, tmp_path):
    """Return a function that calls ``tisph run``."""

    def call(*options, config="small.yaml", out="out", status=0):
        return tisph("run", tmp_path / config, "--out", tmp_path / out, *options, status=status)

    return call


def in_a_process(folder, *options, without=(), **environment):
    """Run the small case in a process of its own, into ``out`` in ``folder``."""
    (folder / "small.yaml").write_text(CASE)
    kept = {key: value for key, value in os.environ.items() if key not in without}
    program = [sys.executable, "-m", "tisph", "run", "small.yaml", "--out", "out", *options]
    done = subprocess.run(program, cwd=folder, env={**kept, **environment}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Folder of a finished run of the small case."""
    folder = tmp_path_factory.mktemp("finished")
    in_a_process(folder)
    return folder / "out"


@pytest.fixture
def copied(finished, tmp_path):
    """Folder of a finished run of the small case, for a test to change: that of ``run``."""
    return shutil.copytree(finished, tmp_path / "out")


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def samples(folder):
    with h5py.File(folder / "samples.h5") as file:
        return {name: {key: group[key][...] for key in group} | dict(group.attrs) for name, group in file.items()}


def changed(*texts):
    """Options of the command line that change a config."""
    return [word for text in texts for word in ("--set", text)]


def same_bits(one, other):
    assert one.keys() == other.keys()
    for name in one:
        assert [key for key in one[name] if not np.array_equal(one[name][key], other[name][key])] == [], name


def test_a_run_leaves_all_that_is_promised(finished):
    files = "config.resolved.yaml summary.json samples.h5 history.csv run.log checkpoint.h5"
    for name in (*files.split(), "profiles.png", "history.png", "movie.mp4"):
        assert (finished / name).stat().st_size > 0, name
    numbers = summary(finished)
    assert numbers["status"] == "done"
    mean = 1.0 / numbers["cost"]["steps"]  # steps to a sample are equal, and shorter by one in so many at most
    assert 0.5 * mean < numbers["numbers"]["dt_min"] <= mean * (1 + 1e-12)
    assert mean * (1 - 1e-12) <= numbers["numbers"]["dt_max"] < 2.0 * mean
    assert [sample["t"] for sample in numbers["samples"]] == [0.4, 1.0]
    stored = samples(finished)
    assert [stored[name]["t"] for name in sorted(stored)] == [0.4, 1.0]
    assert {stored["sample_001"][name].shape for name in ("x", "y", "u", "v", "density", "pressure")} == {(144,)}
    lines = [line for line in (finished / "history.csv").read_text().splitlines() if not line.startswith("#")]
    history = np.loadtxt(lines, delimiter=",", skiprows=1)
    assert history[[0, -1], 0].tolist() == [0.0, 1.0]
    assert history.shape[1] == 1 + 10 + 1 + 10  # t, u, resolved, u_exact


def test_a_run_begins_with_the_warnings_of_check(tisph, run, tmp_path):
    soft = changed("scheme.equation_of_state={sound_speed: 3.0}", "time={end: 0.05}")  # a Mach number of 1/6
    checked = tisph("check", tmp_path / "small.yaml", *soft)
    expected = [line.strip() for line in checked.stdout.splitlines() if "warning" in line]
    assert expected
    case = [*soft, "--no-video", *changed("output.checkpoint_every=0.02")]
    for more in ([], ["--resume"]):
        assert run(*case, *more).stderr.splitlines()[: len(expected)] == expected


@pytest.mark.other_program
@pytest.mark.parametrize(
    "choice",
    [
        pytest.param("walls.treatment.type=comoving_image", marks=pytest.mark.slow),  # images are those of implicit
        pytest.param("walls.treatment.type=adami", marks=pytest.mark.slow),
        "scheme={type: implicit}",
    ],
)
def test_bitwise_the_same_whatever_is_observed_and_on_one_thread_or_two(run, tmp_path, choice):
    # 25 across: 625 particles, which two threads share; each particle is summed by one thread in list order
    case = changed("discretisation.particles_across=25", "time={end: 0.3, samples: [0.1, 0.3]}", choice)
    run(*case, *changed("runtime.threads=1"), out="one")
    run(*case, *changed("runtime.threads=2"), "--no-video", out="two")
    same_bits(samples(tmp_path / "one"), samples(tmp_path / "two"))


def test_a_foreign_or_broken_checkpoint_is_refused(run, copied):
    assert "another config" in run("--no-video", *changed("initial.seed=1"), "--resume", status=2).stderr
    (copied / "checkpoint.h5").write_bytes(b"not a checkpoint")
    assert "cannot be read" in run("--no-video", "--resume", status=2).stderr
    assert summary(copied)["status"] == "done"


def test_a_run_that_goes_wrong_says_what_and_keeps_what_it_had(run, tmp_path):
    # four times the stable time step
    failed = run("--set", "time.cfl=1.0", "--set", "time.end=30.0", status=3)
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


def test_render_draws_what_the_files_of_the_folder_allow(tisph, copied):
    names = ("movie.mp4", "profiles.png", "history.png")
    for name in names:
        (copied / name).unlink()
    tisph("render", copied)
    assert min((copied / name).stat().st_size for name in names) > 0
    (copied / "samples.h5").unlink()
    drawn = tisph("render", copied).stdout
    assert ("history.png" in drawn, "profiles.png" in drawn) == (True, False)
    (copied / "frames.h5").unlink()
    refused = tisph("render", copied, *changed("output.video.fps=10"), status=2)
    assert "the run kept no frames (frames.h5)" in refused.stderr
    (copied / "history.csv").unlink()
    assert "has nothing to draw" in tisph("render", copied, status=2).stderr


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time.end=3.0", "--set time.end=3.0: a finished run is drawn again with other output.video.KEY only"),
        ("output.video.frames=9", "KEY: fps, width, height, renderer, color_by, limits"),
        ("output.video.overlay=arrow", "must be 'none', 'vectors', 'streamlines' or 'tracks'"),
    ],
)
def test_render_refuses_what_a_finished_run_cannot_show(tisph, copied, text, message):
    before = (copied / "movie.mp4").read_bytes()
    assert message in tisph("render", copied, "--set", text, status=2).stderr
    assert (copied / "movie.mp4").read_bytes() == before


def test_render_recolours_a_vortex_by_what_its_frames_have(tisph, tmp_path):
    settings = config.load(VORTEX, ["discretisation.particles_across=10", "output.video={width: 640, height: 320}"])
    (tmp_path / "config.resolved.yaml").write_text(yaml_text.dump(settings.resolved()))
    scene = scenes.of(settings)
    start = {**dict.fromkeys(("x", "y", "u", "v", "density", "pressure")), **scene.initial(*scene.lattice())}
    start |= dict(zip("xy", scene.lattice(), strict=True)) | {"density": None, "pressure": None}
    with h5py.File(tmp_path / "frames.h5", "w") as frames:
        for number in range(3):
            write_snapshot(frames.create_group(f"frame_{number:05d}"), Snapshot(t=0.1 * number, step=number, **start))
    h5py.File(tmp_path / "samples.h5", "w").close()
    (tmp_path / "history.csv").write_text("t\n")
    movies = []
    for colour in ("speed", "vorticity"):
        tisph("render", tmp_path, "--set", f"output.video.color_by={colour}")
        movies.append((tmp_path / "movie.mp4").read_bytes())
    assert movies[0] != movies[1]
    tisph("render", tmp_path, "--set", "output.video.color_by=dye", "--set", "output.video.fps=10", "--gif")
    with Image.open(tmp_path / "movie.gif") as film, Image.open(tmp_path / "poster.jpg") as still:
        assert (film.format, film.size, film.is_animated, still.size) == ("GIF", (640, 320), True, (640, 320))
    movies.append((tmp_path / "movie.mp4").read_bytes())
    refused = tisph("render", tmp_path, "--set", "output.video.color_by=pressure", status=2)
    assert f"output.video.color_by = pressure: {tmp_path / 'frames.h5'} has no pressure" in refused.stderr
    assert (tmp_path / "movie.mp4").read_bytes() == movies[2]


@pytest.mark.other_program
@pytest.mark.parametrize(
    ("scheme", "treatment", "across", "rheology"),
    [
        pytest.param(*("wcsph", "consistent_image", 12, POLYMER), marks=pytest.mark.slow),
        ("wcsph", "adami", 6, "newtonian"),
        pytest.param(*("implicit", "virtual_image", 6, "newtonian"), marks=pytest.mark.slow),
        ("implicit", "consistent_image", 12, POLYMER),
    ],
)
def test_no_kernel_reads_or_writes_out_of_bounds(run, monkeypatch, scheme, treatment, across, rheology):
    # Taichi checks every index in debug mode; without it a bad one passes silently
    monkeypatch.setenv("TI_DEBUG", "1")
    case = changed(f"discretisation.particles_across={across}", "geometry.length=2.0", "time={end: 0.3}")
    case += changed(f"walls.treatment.type={treatment}", "initial.jitter=0.3", f"scheme={{type: {scheme}}}")
    run("--no-video", *case, *changed(f"fluid.rheology={{type: {rheology}}}"))
    runtime.start("f64", 1)
    assert runtime.ti.lang.impl.current_cfg().debug


@pytest.mark.skipif(os.name == "nt", reason="HOME decides on POSIX systems only")
@pytest.mark.parametrize(
    ("home", "options"),
    [({"HOME": "/proc/nowhere"}, []), ({}, ["--no-video"])],  # what draws looks for one too
    ids=["unwritable", "unknown"],
)
def test_runs_without_a_home_to_keep_compiled_kernels_in(tmp_path, home, options):
    in_a_process(tmp_path, "--set", "time={end: 0.01}", *options, without=["HOME", "XDG_CACHE_HOME"], **home)


@pytest.mark.parametrize(
    ("name", "settings", "share"),
    # measured: 0.18 and 0.13; with a history of 401 lines, and a mean over the cell in each, 0.4 and 1.4. The share of
    # a short run is larger, as files and provenance cost the same in every run.
    [("couette", (), 0.33), ("cylinder_lattice", ("time={end: 0.02, samples: [0.02]}",), 0.33)],
)
def test_output_takes_a_small_part_of_a_run(tmp_path, name, settings, share):
    case = config.load(VORTEX.parent / f"{name}.yaml", ("runtime.threads=1", *settings))
    simulation.run(case, tmp_path, pictures=False, video=False)
    cost = summary(tmp_path)["cost"]
    times, _ = read_history(tmp_path / "history.csv")
    assert len(times) <= cost["steps"] + 1
    assert (times[1:] > times[:-1]).all()
    assert cost["processor_output_s"] <= share * cost["processor_loop_s"]
