"""How the comparison of wall treatments is run: which runs when, what is kept, what is left. Nothing is simulated."""

import itertools
import json
import math

import numpy as np
import pytest
from fake_runs import FakeRuns, make_result
from PIL import Image

from tisph import registry
from tisph.errors import ConfigError
from tisph.studies import processes, store, walls

TREATMENTS = ["comoving_image", "consistent_image"]
SMALL = {"resolutions": [25, 50], "measured_at": 50, "arrangements": ["lattice", "jitter 0.2"]}
RUNS_OF_A_FLOW = 2 * 2 * 2
LAPLACIAN = {
    "treatment": "comoving_image",
    "profile": "bent",
    "arrangement": "lattice",
    "kernel": "quintic_spline",
    "ratio": 1.0,
    "errors": {25: (0.1, 0.0), 50: (0.4, 0.0)},
    "orders": [-2.0, math.nan],
}


@pytest.fixture
def runs(monkeypatch):
    """Runs of two flows with two treatments, whose errors fall with the second order."""

    def summary(config):
        across = config["discretisation"]["particles_across"]
        consistent = config["walls"]["treatment"]["type"] == "consistent_image"
        error = (0.5 if consistent else 1.0) / across**2
        shears = {f"wall_shear_{wall}{end}": 1.0 for wall in ("bottom", "top") for end in ("", "_exact")}
        result = make_result(t27=error, t100=error).summary
        for sample in result["samples"]:
            sample |= {**shears, "rms": error}
        return {**result, "cost": {"wall_loop_s": 1.2 if consistent else 1.0, "steps": 1000}}

    fake = FakeRuns(summary)
    monkeypatch.setattr(processes, "start", fake)
    monkeypatch.setattr(processes, "POLL_SECONDS", 0.0)
    monkeypatch.setattr(registry, "names", lambda family: TREATMENTS)
    monkeypatch.setitem(walls.DATA, "full", SMALL)
    flows = {name: walls.FLOWS[name] for name in ("couette", "poiseuille")}
    monkeypatch.setattr(walls, "FLOWS", flows)
    monkeypatch.setattr(walls, "laplacians", lambda treatments, resolutions: [LAPLACIAN])
    return fake


@pytest.fixture
def unseen(monkeypatch):
    """No picture is drawn: it takes a second, and others look at it."""
    monkeypatch.setattr(walls, "plot_walls", lambda path, rows, laplacians: None)


def test_the_table_the_picture_and_the_numbers(runs, tmp_path, capsys):
    assert walls.run(tmp_path / "out") is True
    output = capsys.readouterr().out
    lines = [line for line in output.splitlines() if line.startswith(("| Couette", "| Poiseuille"))]
    assert len(lines) == 2 * 2 * 2
    assert output.count("recommended: consistent_image") == 1
    numbers = json.loads((tmp_path / "out" / "walls.json").read_text())
    assert numbers["recommended"] == "consistent_image"
    assert numbers["rows"][2]["cost"] == pytest.approx(1.2, rel=1e-12)
    assert numbers["rows"][0]["order"] == pytest.approx(2.0, rel=1e-12)
    assert numbers["laplacians"][0]["orders"] == [pytest.approx(-2.0, rel=1e-12), None]
    assert "1.0e-01, 4.0e-01" in output
    with Image.open(tmp_path / "out" / "verify_walls.png") as picture:
        assert picture.size[0] > 1000


@pytest.mark.usefixtures("unseen")
def test_finished_runs_are_used_again(runs, tmp_path, capsys):
    walls.run(tmp_path)
    first = len(runs.configs)
    assert first == 2 * RUNS_OF_A_FLOW
    table = capsys.readouterr().out
    walls.run(tmp_path)
    assert len(runs.configs) == first
    assert capsys.readouterr().out == table


@pytest.mark.usefixtures("unseen")
def test_an_interrupted_comparison_goes_on_where_it_was(runs, tmp_path, monkeypatch, capsys):
    stop = RUNS_OF_A_FLOW - 3
    start, count = FakeRuns.__call__, itertools.count(1)
    started = []

    def interrupted(self, *arguments):
        process = start(self, *arguments)
        started.append(process)
        if next(count) == stop:
            raise KeyboardInterrupt
        return process

    monkeypatch.setattr(FakeRuns, "__call__", interrupted)
    with pytest.raises(KeyboardInterrupt):
        walls.run(tmp_path)
    assert "the same command goes on" in capsys.readouterr().out
    assert not [process for process in started[:-1] if process.status is None]  # none is left behind
    done = sum((tmp_path / "runs" / config["name"] / "summary.json").is_file() for config in runs.configs)
    assert 0 < done < stop
    begun = len(runs.configs)
    assert walls.run(tmp_path) is True
    assert len(runs.configs) - begun == 2 * RUNS_OF_A_FLOW - done


@pytest.mark.usefixtures("unseen")
def test_other_code_or_another_config_is_run_again(runs, tmp_path, monkeypatch):
    walls.run(tmp_path)
    first = len(runs.configs)
    monkeypatch.setattr(store, "fingerprint", lambda: "other")
    walls.run(tmp_path)
    assert len(runs.configs) == 2 * first
    kept = store.Store(tmp_path / "runs")
    config = {key: value for key, value in runs.configs[0].items() if key != "name"}
    assert kept.kept(runs.configs[0]["name"], config)
    assert kept.kept(runs.configs[0]["name"], {**config, "drive": {"acceleration": 1.0}}) is None


def test_a_run_that_diverged_is_kept_and_one_that_failed_is_not(runs, tmp_path):
    keeper = store.Store(tmp_path / "runs")
    for status, kept in (("diverged", True), ("done", True), ("failed", False), ("interrupted", False)):
        runs.summary = lambda config, status=status: {"status": status, "message": "why", "samples": []}
        keeper.launch("case", {}).outcome()
        assert (keeper.kept("case", {}) is not None) is kept


@pytest.mark.usefixtures("unseen")
def test_a_treatment_that_stops_is_shown_and_not_recommended(runs, tmp_path, capsys):
    good = runs.summary
    name = "poiseuille-consistent_image-lattice-50"
    runs.summary = lambda config: "diverged: u of particle 7" if config["name"] == name else good(config)
    assert walls.run(tmp_path) is True
    output = capsys.readouterr().out
    assert f"{name} stopped: diverged: u of particle 7" in output
    assert "recommended: comoving_image" in output
    assert json.loads((tmp_path / "walls.json").read_text())["treatments"][1]["stopped"] == 1


def test_without_any_treatment_that_finishes_the_comparison_fails(runs, tmp_path, capsys):
    runs.summary = lambda config: "refused"
    assert walls.run(tmp_path) is False
    assert "recommended: none" in capsys.readouterr().out
    assert (tmp_path / "verify_walls.png").is_file()


def test_a_folder_that_cannot_be_used_is_bad_input(runs, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        walls.run(tmp_path / "file")
    assert runs.configs == []


def test_the_message_of_a_run_is_its_error_without_its_progress(runs, tmp_path):
    runs.summary = lambda config: "diverged: u of particle 7\npartial results are in there"
    config = tmp_path / "case.yaml"
    config.write_text("name: case\n")
    result, message = processes.run_config(config, tmp_path / "case")
    assert result.summary["status"] == "failed"
    assert message == "diverged: u of particle 7\npartial results are in there"


def test_treatments_and_arrangements_can_be_told_apart_in_the_picture(tmp_path):
    """Each treatment has pixels of its own colour, also where runs stopped."""
    rows = [
        {
            "case": {"flow": "couette", "treatment": name, "arrangement": arrangement},
            "errors": dict(zip((25, 50, 100), errors, strict=True)),
            "t_star": [0.027],
            "measure": "l2",
        }
        for place, name in enumerate(("a", "b", "c", "d", "e"))
        for arrangement, errors in (
            ("lattice", (0.1 * 2**place, 0.02 * 2**place, 0.005 * 2**place)),
            ("jitter 0.2", (0.09 * 2**place, np.nan, np.nan)),
        )
    ]
    walls.plot_walls(tmp_path / "picture.png", rows, [{**LAPLACIAN, "treatment": "a"}])
    pixels = np.asarray(Image.open(tmp_path / "picture.png").convert("RGB")).reshape(-1, 3)
    for colour in ((0xD5, 0x5E, 0x00), (0x00, 0x9E, 0x73), (0x56, 0xB4, 0xE9), (0xCC, 0x79, 0xA7)):
        assert np.sum(np.all(pixels == colour, axis=1)) > 100
