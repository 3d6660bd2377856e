"""The menu of configs, and what is copied from it."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from tisph import cli
from tisph.cli.menu import SHORTEST, first_words, menu
from tisph.config import load


def new(*arguments):
    return CliRunner().invoke(cli.app, ["new", *arguments])


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_the_menu_has_every_config_with_a_line_of_its_own():
    shown = new("--list").stdout.splitlines()
    lines = [line for line in shown if line.startswith("  ")]
    assert sorted(line.split()[0] for line in lines) == [path.stem for path in menu()]
    assert all(len(first_words(path)) >= SHORTEST for path in menu())
    words = dict(line.split(maxsplit=1) for line in lines)
    assert words["couette"] == "Start-up plane Couette flow"
    assert words["cavity"] == "Lid-driven cavity, Re = 100"
    assert words["womersley"].startswith("Pulsating pipe flow (J. R. Womersley 1955)")  # no sentence ends at an initial
    assert list(Path().iterdir()) == []


def test_a_copied_config_is_valid_and_says_how_to_run_it():
    done = new("couette")
    assert (done.exit_code, done.stdout) == (0, "couette.yaml\n")
    original = next(path for path in menu() if path.stem == "couette")
    assert load("couette.yaml") == load(original)
    text = Path("couette.yaml").read_text()
    assert "tisph run   couette.yaml" in text
    assert "configs/" not in text


def test_a_file_that_is_there_is_left_as_it_is():
    Path("couette.yaml").write_text("mine")
    done = new("couette.yaml")
    assert done.exit_code == 2
    assert done.stderr == "error: couette.yaml: is there already, and is left as it is\n"
    assert Path("couette.yaml").read_text() == "mine"


def keys(*arguments):
    return CliRunner().invoke(cli.app, ["keys", *arguments])


def test_keys_of_a_scene_are_its_own():
    lines = keys("taylor_green").stdout.splitlines()
    assert max(map(len, lines)) <= 100
    assert "  fluid.density: number above 0 [mass/length³]; must be given" in lines
    assert lines[lines.index("  fluid.density: number above 0 [mass/length³]; must be given") + 1] == "      Density."
    heads = {line.partition(":")[0] for line in lines if line and not line.startswith(" ")}
    assert heads == {"All scenes", "Scene taylor_green", "Schemes", "Fluid laws"}  # neither walls nor bodies
    assert "\nShapes: circle\n" in keys("lattice").stdout


def test_keys_of_one_section_are_no_others():
    lines = keys("channel", "walls").stdout.splitlines()
    assert lines[0] == "Scene channel: Channel flow."
    shown = [line for line in lines if line.startswith("  ") and line[2] != " "]
    own = [line for line in shown if line.startswith(("  walls:", "  walls."))]
    assert len(own) > 20
    assert shown[: len(own)] == own  # the keys of wall treatments follow
    assert {line.partition(":")[0] for line in lines if line and line[0] != " "} == {"Scene channel", "Wall treatments"}
