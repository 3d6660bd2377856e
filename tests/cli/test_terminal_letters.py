"""Letters that a terminal does not have, in paths, names and units, end no command: what it prints has them escaped."""

import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from couette import couette_text

import tisph
from tisph import cli
from tisph.cli import terminal
from tisph.errors import ConfigError
from tisph.studies import processes

pytestmark = pytest.mark.taichi

NAME = "łμ中"
CASE = couette_text(name=NAME, units={"length": "µm"}, output={"video": None})
ESCAPED = r"\u0142\u03bc\u4e2d"

COMMANDS = {
    "run": (["run", f"{NAME}.yaml"], 2),  # its folder is there
    "check": (["check", f"{NAME}.yaml", "--set", "units.length=łm"], 2),
    "list": (["list", NAME], 2),
    "keys": (["keys", NAME], 2),
    "verify": (["verify", NAME], 2),
    "bench": (["bench", NAME], 2),
    "stability": (["stability", f"--{NAME}"], 2),
    "stress": (["stress", NAME], 2),
    "new": (["new", NAME], 2),
    "render": (["render", NAME], 2),
    "report": (["report", f"runs/{NAME}", "--out", f"{NAME}.html"], 0),
    "export": (["export", f"runs/{NAME}", "--to", "csv", "--out", f"{NAME}.csv"], 0),
    "compare": (["compare", f"runs/{NAME}/samples.h5", "--config", f"{NAME}.yaml", "--out", f"compare-{NAME}"], 0),
    "sweep": (["sweep", f"{NAME}.yaml"], 2),
    "fit": (["fit", f"{NAME}.csv", "--config", f"{NAME}.yaml", "--free", "fluid.dynamic_viscosity=1..2"], 2),
    "rheometry": (["rheometry", f"runs/{NAME}"], 2),
    "references": (["references", NAME], 2),
}
"""Arguments of each command that it names in what it prints, and its status."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a finished run whose command had a terminal without most letters."""
    folder = tmp_path_factory.mktemp("letters") / NAME
    folder.mkdir()
    (folder / f"{NAME}.yaml").write_text(CASE, encoding="utf-8")
    environment = {**os.environ, "PYTHONIOENCODING": "cp1252"}
    program = [sys.executable, "-m", "tisph", "run", f"{NAME}.yaml", "--no-pictures"]
    done = subprocess.run(program, cwd=folder, env=environment, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert f"results in runs{os.sep}{ESCAPED}" in done.stdout.decode("cp1252")
    return folder


@pytest.fixture(params=["cp1252", "ascii"])
def printed(request, folder, monkeypatch):
    """Return a function that gives status and text of a command on a terminal of this encoding, as ``tisph`` has it."""
    monkeypatch.chdir(folder)

    def command(arguments):
        written = io.BytesIO()
        for name in ("stdout", "stderr"):
            stream = io.TextIOWrapper(written, request.param)
            monkeypatch.setattr(sys, name, stream)
            monkeypatch.setattr(sys, f"__{name}__", stream)
        terminal.outlive_readers()
        with pytest.raises(SystemExit) as left:
            cli.app(arguments, prog_name="tisph")
        sys.stdout.flush()
        sys.stderr.flush()
        usage = b"Usage: " in written.getvalue()  # click takes a stream of ASCII for misconfigured, and writes UTF-8
        encoding = "utf-8" if usage and request.param == "ascii" else request.param
        return left.value.code, written.getvalue().decode(encoding)

    return command


def test_every_command_is_tried():
    assert set(COMMANDS) == {command.name for command in cli.app.registered_commands}


def test_what_cannot_be_shown_is_escaped(printed):
    for arguments, status in COMMANDS.values():
        found, text = printed(arguments)
        assert found == status, text
        assert r"\u0142" in text or ("Usage: " in text and "ł" in text), text


def test_help_and_menus_are_shown(printed):
    for arguments in (["--help"], *([name, "--help"] for name in COMMANDS), ["list"], ["new", "--list"]):
        status, text = printed(arguments)
        assert (status, bool(text)) == (0, True)


def test_nothing_is_printed_past_the_streams():
    package = Path(tisph.__file__).parent
    texts = {path: path.read_text(encoding="utf-8") for path in package.rglob("*.py")}
    assert [
        path.name for path, text in texts.items() if re.search(r"\b(typer|click)\.(s?echo|secho|prompt)\b", text)
    ] == []


def test_a_run_from_python_finds_its_folder_whatever_the_terminal_shows(folder, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    monkeypatch.chdir(folder)
    with pytest.raises(ConfigError, match=rf"runs.{NAME}: the folder is not empty"):
        tisph.run(f"{NAME}.yaml", video=False)
    assert tisph.run(f"{NAME}.yaml", video=False, overwrite=True, name=f"{NAME}2").folder.name == f"{NAME}2"


def test_messages_of_a_study_s_run_are_utf_8(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONIOENCODING", "cp1252")
    monkeypatch.setattr(processes, "METHOD", "spawn")  # a server may have started with another terminal
    process = processes.start(["check", f"{NAME}.yml"], tmp_path / "messages")
    process.join()
    assert f"error: {NAME}.yml" in (tmp_path / "messages").read_text(encoding="utf-8")
