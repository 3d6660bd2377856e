"""The command line: exit statuses, one message on standard error, and nothing written on bad input."""

import json
import shlex
import sys
import types
from importlib import metadata
from pathlib import Path

import pytest
from typer.testing import CliRunner

import tisph
from tisph import cli, runtime
from tisph.config.yaml_text import parse
from tisph.errors import DivergedError, TisphError
from tisph.folder import RESULTS, held
from tisph.schemes._estimate import step_counts

CONFIG = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
scheme: {type: wcsph}
time: {end: 2.7}
"""

SAMPLE = {"t": 2.7, "l2": 1.234e-3, "rms": 4e-4, "wall_shear_top": 0.125, "resolved": True, "reason": None}
COST = {"steps": 10, **{f"wall_{part}_s": 0.5 for part in ("total", "import", "compile", "loop", "output")}}


@pytest.fixture
def case(tmp_path, monkeypatch):
    """Work in an empty folder that holds case.yaml and bad.yaml."""
    monkeypatch.chdir(tmp_path)
    Path("case.yaml").write_text(CONFIG)
    Path("bad.yaml").write_text(CONFIG.replace("2.7", "-1"))
    return tmp_path


@pytest.fixture
def simulation(monkeypatch):
    """Stand in for the simulation: record the calls, leave a summary, raise what ``error`` holds."""
    stand_in = types.ModuleType("tisph.simulation")
    stand_in.calls, stand_in.error, stand_in.drawn = [], None, []
    stand_in.summary = {"status": "done", "samples": [SAMPLE], "cost": COST, "provenance": {}}
    stand_in.__path__ = [str(Path(tisph.__file__).parent / "simulation")]  # its other modules are the real ones

    def run(config, folder, *, pictures, video, resume):
        stand_in.calls.append((config.name, folder, pictures, video, resume))
        (folder / "summary.json").write_text(json.dumps(stand_in.summary))
        print("50%  t = 1.35", file=sys.stderr)
        if stand_in.error:
            raise stand_in.error
        return folder

    stand_in.run = run
    stand_in.render = lambda *asked: stand_in.calls.append(asked) or stand_in.drawn
    monkeypatch.setitem(sys.modules, "tisph.simulation", stand_in)
    monkeypatch.setattr(tisph, "simulation", stand_in, raising=False)
    return stand_in


def tisph_command(*arguments):
    return CliRunner().invoke(cli.app, list(arguments))


@pytest.mark.parametrize("command", [[], ["run"], ["check"], ["list"], ["verify"], ["render"]])
def test_help_has_examples(command):
    result = tisph_command(*command, "--help")
    assert result.exit_code == 0
    assert f"  tisph {' '.join(command)}" in result.stdout.split("Examples:")[1]


def test_version_names_taichi_or_quadrants():
    name = runtime.PACKAGE
    shown = f"tisph {tisph.__version__} ({name.capitalize()} {metadata.version(name)})\n"
    assert tisph_command("--version").stdout == shown


REFUSED = parse((Path(__file__).parent / "data" / "refused.yaml").read_text(encoding="utf-8")).data


@pytest.mark.parametrize(
    ("line", "words"), [*REFUSED.items(), (f"run case.yaml --out {'x' * 300}", "cannot be written")]
)
def test_bad_input_is_one_message_and_nothing_is_written(case, simulation, line, words):
    for folder in ("empty", "full"):
        Path(folder).mkdir()
    Path("full/notes.txt").write_text("mine")
    before = sorted(case.rglob("*"))
    result = tisph_command(*shlex.split(line))
    assert (result.exit_code, result.stdout, sorted(case.rglob("*")), simulation.calls) == (2, "", before, [])
    assert words in " ".join(result.stderr.split())
    one_line = (result.stderr.count("\n"), result.stderr[:7]) == (1, "error: ")
    assert one_line or result.stderr.startswith("Usage: ")


def test_run_makes_its_folder_and_names_the_results(case, simulation):
    result = tisph_command("run", "case.yaml", "--no-video")
    assert result.exit_code == 0
    folder = Path("runs/case")
    assert simulation.calls == [("case", folder, True, False, False)]
    assert str(folder / "summary.json") in result.stdout
    assert "movie" not in result.stdout  # names only what is there


def test_a_run_ends_with_errors_forces_and_time_used(case, simulation):
    thin = {**SAMPLE, "t": 0.5, "l2": None, "resolved": False, "reason": "the layer is too thin"}
    simulation.summary["samples"] = [thin, {**SAMPLE, "zero_within_error": "lift, torque"}]
    simulation.summary["error_estimate"] = {"samples": [{"fields": {"velocity": {"error": 0.02}}}, {"fields": {}}]}
    shown = tisph_command("run", "case.yaml").stdout
    header, _, first, second, reason, zero, cost = [line.split("|") for line in shown.splitlines()[:7]]
    assert [cell.strip() for cell in header[1:-1]] == ["sample", "t [s]", "L2 error", "wall shear top", "resolved"]
    assert [cell.strip() for cell in first[2:-1]] == ["0.5", "2.0e-02 (estimate)", "0.125", "no"]
    assert [cell.strip() for cell in second[2:-1]] == ["2.7", "1.23e-03", "0.125", "yes"]
    assert reason == ["sample 0 is not resolved: the layer is too thin"]
    assert zero == ["sample 1: zero within the error: lift, torque"]
    assert cost == ["10 steps, 0.5 s: 0.5 s in the steps, 0.5 s compiling, 0.5 s for output, 0.5 s getting ready"]
    assert shown.splitlines()[7].startswith("results in ")


def test_a_quiet_run_prints_errors_only(case, simulation):
    warned = ["--set", "scheme.equation_of_state={sound_speed: 2.0}"]
    assert "warning" in tisph_command("run", "case.yaml", *warned).stderr
    assert tisph_command("run", "case.yaml", *warned, "--overwrite", "--quiet").output == ""
    simulation.error = DivergedError("density of particle 7")
    failed = tisph_command("run", "case.yaml", "--overwrite", "--quiet")
    assert (failed.exit_code, failed.stdout) == (3, "")
    assert failed.stderr.startswith("error: density of particle 7")


def test_samples_and_cost_as_json_are_all_of_the_output(case, simulation):
    printed = json.loads(tisph_command("run", "case.yaml", "--json").stdout)
    assert printed == {"status": "done", "samples": [SAMPLE], "cost": COST}


def test_run_estimates_its_error_after_coarser_runs(case, simulation, monkeypatch):
    from tisph.studies import error_estimate

    def report(self):
        assert (self.root / "summary.json").is_file()
        return "error 1e-5"

    monkeypatch.setattr(error_estimate.Coarser, "run", lambda self: simulation.calls.append(self.names))
    monkeypatch.setattr(error_estimate.Coarser, "report", report)
    done = tisph_command("run", "case.yaml", "--estimate-error")
    assert done.exit_code == 0
    assert done.stdout.endswith("\nerror 1e-5\n")
    assert simulation.calls == [["across_25", "across_35"], ("case", Path("runs/case"), True, True, False)]


def test_no_error_is_estimated_of_a_run_that_finds_its_own_places(case, simulation):
    past_a_circle = CONFIG.replace("{type: wcsph}", "{type: implicit}").replace(
        "time:", "bodies: [{centre: [1.0, 0.5], radius: 0.2}]\ntime:"
    )
    Path("case.yaml").write_text(f"{past_a_circle}discretisation: {{refine: auto}}\n")
    done = tisph_command("run", "case.yaml", "--estimate-error")
    assert done.exit_code == 2
    assert "run it without, and then its config.resolved.yaml" in done.stderr
    assert not simulation.calls


def test_overwrite_removes_results_and_nothing_else(case, simulation):
    Path("full").mkdir()
    for name in (*RESULTS, "notes.txt"):
        Path("full", name).write_text("old")
    assert tisph_command("run", "case.yaml", "--out", "full", "--overwrite").exit_code == 0
    assert sorted(path.name for path in Path("full").iterdir()) == ["notes.txt", "summary.json"]


def test_resume_goes_on_in_a_folder_with_a_checkpoint(case, simulation):
    Path("old").mkdir()
    Path("old/checkpoint.h5").write_text("")
    assert tisph_command("run", "case.yaml", "--out", "old", "--resume").exit_code == 0
    assert simulation.calls == [("case", Path("old"), True, True, True)]


@pytest.mark.parametrize("how", [[], ["--overwrite"], ["--resume"]])
def test_a_folder_in_use_is_said_to_be_in_use(case, simulation, how):
    with held(Path("out")):
        Path("out/checkpoint.h5").write_text("")
        result = tisph_command("run", "case.yaml", "--out", "out", *how)
        assert (case / "out/.lock").exists()
    assert result.exit_code == 2
    assert result.stderr == "error: --out out: is in use, another run is writing there; choose another folder\n"
    assert simulation.calls == []


@pytest.mark.parametrize(
    ("met", "status", "verdict"),
    [
        ((True, True), 0, "2 of 2 cells meet their requirement"),
        ((True, False), 1, "1 of 2 cells meet their requirement; FAIL: b"),
    ],
)
def test_the_matrix_ends_with_a_verdict(case, monkeypatch, met, status, verdict):
    from tisph.studies import stability_report

    def leave_numbers(folder, *_):
        cells = [{"name": name, "met": each} for name, each in zip("ab", met, strict=True)]
        folder.mkdir()
        (folder / "stability.json").write_text(json.dumps({"cells": cells}))
        return all(met)

    monkeypatch.setattr(stability_report, "run", leave_numbers)
    done = tisph_command("stability", "--quick", "--out", "matrix")
    assert (done.exit_code, done.stdout.splitlines()[-1]) == (status, verdict)


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (None, 0, "t = 1.35"),
        (DivergedError("density of 7"), 3, f"density of 7\npartial results are in {Path('runs/case')}"),
        (TisphError("no encoder"), 1, "error: no encoder"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_exit_status_of_a_run_which_leaves_no_lock(case, simulation, error, status, message):
    simulation.error = error
    result = tisph_command("run", "case.yaml")
    assert result.exit_code == status
    assert message in result.stderr
    assert "Traceback" not in result.output
    assert [path.name for path in Path("runs/case").iterdir()] == ["summary.json"]


def test_steps_end_on_every_target():
    # 0 -> 1 takes 4 steps of at most 0.3, 1 -> 1.5 takes 2; an exact multiple costs no extra step
    assert step_counts(0.0, [1.0, 1.5, 1.5], 0.3) == [4, 6, 6]
    assert step_counts(0.0, [0.3], 0.1) == [3]


def test_list(case):
    everything = tisph_command("list").stdout
    assert "walls\n" in everything
    assert "kernels\n" in everything
    assert "comoving_image" in tisph_command("list", "walls").stdout


@pytest.mark.parametrize(("passed", "status"), [(True, 0), (False, 1)])
def test_verify_tells_by_its_status(monkeypatch, passed, status):
    calls = []
    called = lambda *given: calls.append(given) or passed  # noqa: E731
    suite = types.SimpleNamespace(run=called)
    monkeypatch.setitem(sys.modules, "tisph.studies.verify", suite)
    import tisph.studies

    monkeypatch.setattr(tisph.studies, "verify", suite, raising=False)
    assert tisph_command("verify", "--quick").exit_code == status
    assert tisph_command("verify", "free_bodies", "--long").exit_code == status
    whole, part = calls
    assert whole == (None, True, False, None, False)
    assert part == ("free_bodies", False, True, None, False)


def test_render(case, simulation):
    Path("config.resolved.yaml").write_text("")
    simulation.drawn = [Path("profiles.png")]
    done = tisph_command("render", ".", "--set", "output.video.fps=10")
    assert (done.exit_code, done.output) == (0, "profiles.png\n")
    assert simulation.calls == [(Path("."), ["output.video.fps=10"], False)]
