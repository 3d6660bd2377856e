"""Runs from Python: the same bits, files and messages as on the command line, in a process of their own."""

import copy
import json
import os
import subprocess
import sys
from base64 import b64decode
from pathlib import Path

import h5py
import numpy as np
import pytest
from couette import couette
from typer.testing import CliRunner

import tisph
from tisph import cli, simulation
from tisph.errors import ConfigError, DivergedError
from tisph.folder import held
from tisph.results.export import export

pytestmark = pytest.mark.taichi

OUTPUT = {"video": {"frames": 3, "width": 640, "height": 320}}
CASE = couette(scheme={"type": "wcsph"}, time={"end": 1.0, "samples": [0.4, 1.0]}, output=OUTPUT)

BESIDE_TAICHI = """
import json, sys
import taichi as ti
ti.init(arch=ti.cpu, default_fp=ti.f32, log_level=ti.ERROR)
kept = ti.field(float, 3)
kept.fill(2.0)

@ti.kernel
def double():
    for i in kept:
        kept[i] *= 2.0

double()
import tisph
config = json.loads(sys.argv[1])
tisph.check(config)
run = tisph.run(config, "own", video=False, **{"discretisation.precision": "f32", "runtime.threads": 2})
assert run.samples[0]["u"].dtype == "f4" and run.summary.provenance.threads == 2
assert abs(run.exact("u", 0.5, 1.0, 1.0) - 0.5) < 1e-6
double()
assert kept.to_numpy().tolist() == [8.0, 8.0, 8.0] and kept.to_numpy().dtype == "f4"
made_later = ti.field(float, 3)

@ti.kernel
def halve():
    for i in kept:
        made_later[i] = kept[i] / 2.0

halve()
assert made_later.to_numpy().tolist() == [4.0, 4.0, 4.0] and made_later.to_numpy().dtype == "f4"
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Results of the small case."""
    return tisph.run(CASE, tmp_path_factory.mktemp("finished") / "out")


def test_bitwise_the_same_as_on_the_command_line(finished, tmp_path):
    (tmp_path / "small.yaml").write_text(json.dumps(CASE))
    done = CliRunner().invoke(
        cli.app, ["run", str(tmp_path / "small.yaml"), "--no-video", "--out", str(tmp_path / "o")]
    )
    assert done.exit_code == 0, done.stderr
    with h5py.File(tmp_path / "o/samples.h5") as file:
        for sample, group in zip(finished.samples, file.values(), strict=True):
            assert all(np.array_equal(sample[name], group[name]) for name in group)
    assert finished.summary.provenance.config_hash == tisph.open(tmp_path / "o").summary.provenance.config_hash


def test_summary_and_samples_are_those_of_the_files(finished):
    raw = json.loads((finished.folder / "summary.json").read_text())
    assert (finished.summary.name, finished.summary.status) == ("small", "done")
    assert [sample.l2 for sample in finished.summary.samples] == [sample["l2"] for sample in raw["samples"]]
    measures = finished.summary.samples[-1]
    assert measures.wall_shear_top == measures["wall_shear_top"] == raw["samples"][-1]["wall_shear_top"]
    assert dict(measures) == measures.measures
    assert copy.deepcopy(measures) == measures
    assert finished.summary.cost.steps == raw["cost"]["steps"]
    assert [sample.t for sample in finished.samples] == [0.4, 1.0]
    last = finished.samples[-1]
    assert len(finished.samples[:1]) == 1
    assert {"x", "y", "u", "v", "density", "pressure", "u_exact"} <= set(last)
    assert (last["u"].shape, last.units["u"]) == ((144,), "m/s")
    assert np.array_equal(last.u, last["u"])


@pytest.mark.parametrize(
    ("of", "wrong", "right"),
    [
        (lambda run: run.samples[-1], "densty", "density"),
        (lambda run: run.summary.samples[-1], "wall_shear_tpo", "wall_shear_top"),
        (lambda run: run.history, "resolvd", "resolved"),
    ],
)
def test_a_wrong_name_is_answered_with_the_nearest(finished, of, wrong, right):
    with pytest.raises(KeyError, match=f"{wrong}.* nearest: {right}"):
        of(finished)[wrong]


def test_samples_become_one_table_of_pandas(finished):
    pytest.importorskip("pandas", reason="there is no pandas")
    table = finished.samples.to_pandas()
    assert list(table.columns[:4]) == ["t", "particle", "x", "y"]
    assert np.array_equal(table[table.t == 1.0].u, finished.samples[-1].u)


def test_errors_can_be_computed_again_from_arrays_and_the_exact_solution(finished):
    last = finished.samples[-1]
    exact = finished.exact("u", last["x"], last["y"], last.t)
    assert np.array_equal(exact, last["u_exact"])
    error = np.linalg.norm(last["u"] - exact) / np.linalg.norm(exact)
    assert error == pytest.approx(finished.summary.samples[-1].l2, rel=1e-12)  # sums of 144 numbers in another order
    with pytest.raises(ConfigError, match="'w': scene channel has no reference for it; it has u"):
        finished.exact("w", 0.0, 0.0, 0.0)


def test_history_is_a_record_array(finished):
    history = finished.history
    assert history.t[0] == 0.0
    assert history.t[-1] == 1.0
    name = history.dtype.names[1]
    exact = finished.exact("u", 0.5, float(name.removeprefix("u(y=").rstrip(")")), history.t)
    assert np.allclose(history[name.replace("u(", "u_exact(")], exact, rtol=1e-12, atol=1e-15)
    pandas = pytest.importorskip("pandas", reason="there is no pandas")
    table = history.to_pandas()
    assert isinstance(table, pandas.DataFrame)
    assert list(table.columns) == list(history.dtype.names)


def test_a_notebook_shows_movie_pictures_and_errors(finished):
    for figure in (finished.profile_figure(), finished.history_figure()):
        assert figure._repr_png_().startswith(b"\x89PNG")
    shown = finished._repr_html_()
    assert shown.count("<img") == 2
    assert "L2, relative" in shown
    movie = shown.split('src="data:video/mp4;base64,')[1].split('"')[0]
    assert b64decode(movie) == Path(finished.movie).read_bytes()
    assert finished.movie._repr_html_().strip().startswith("<video")


def test_nothing_is_printed_and_folders_are_used_as_on_the_command_line(finished, capfd):
    with pytest.raises(ConfigError, match=r"the folder is not empty; choose another one, or add --overwrite"):
        tisph.run(CASE, finished.folder)
    with held(finished.folder), pytest.raises(ConfigError, match="is in use, another run is writing there"):
        tisph.run(CASE, finished.folder, overwrite=True)
    assert finished.samples[-1]["u"].shape == (144,)
    assert capfd.readouterr() == ("", "")


def test_nothing_is_drawn_into_the_folder_of_a_run_that_goes_on(finished, tmp_path):
    before = sorted(path.name for path in finished.folder.iterdir())
    with held(finished.folder):
        for add in (lambda: simulation.render(finished.folder), lambda: export(finished, "csv")):
            with pytest.raises(ConfigError, match="is in use: its run is still going on"):
                add()
        assert export(finished, "csv", tmp_path / "samples.csv").is_file()  # elsewhere is no harm
    assert sorted(path.name for path in finished.folder.iterdir()) == before


def test_a_run_that_diverges_is_an_exception_and_can_be_opened(tmp_path, capfd):
    with pytest.raises(DivergedError, match=r"(?s)particle.*at step.*partial results are in") as raised:
        tisph.run(CASE, tmp_path / "out", video=False, **{"time.cfl": 1.0, "time.end": 30.0})  # four times the stable
    assert "Traceback" not in str(raised.value)
    assert capfd.readouterr() == ("", "")
    opened = tisph.open(tmp_path / "out")
    assert opened.summary.status == "diverged"
    assert opened.summary.message in str(raised.value)
    assert opened.movie is None
    assert "diverged" in opened._repr_html_()


def test_a_taichi_program_beside_it_lives_on(tmp_path):
    (tmp_path / "users.py").write_text(BESIDE_TAICHI)  # Taichi looks for the source of kernels
    program = [sys.executable, "users.py", json.dumps(CASE)]
    path = str(Path(tisph.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(program, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_no_folder_of_results(tmp_path):
    with pytest.raises(ConfigError, match=r"is no folder of results, it has no config.resolved.yaml"):
        tisph.open(tmp_path)
