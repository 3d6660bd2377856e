"""The examples of docs/how-to/extending.md work as they stand there, in files as many as it says."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import tisph

pytestmark = pytest.mark.taichi

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "extending.md").read_text(encoding="utf-8")
COUETTE = str(ROOT / "configs" / "couette_minimal.yaml")
QUICK = ["--no-video", "--no-pictures", "--set", "runtime.threads=1"]
FEW = ["--set", "discretisation.particles_across=20"]


def examples():
    """Files of the page by their paths: those to which it links, and the blocks of code after a path."""
    blocks = re.findall(r"`([\w/]+\.(?:py|yaml))`:\n\n```(?:python|yaml)\n(.*?)```\n", PAGE, re.DOTALL)
    links = re.findall(r"\[`(tisph/[\w/]+\.py)`\]\(\.\./examples/(\w+\.py)\)", PAGE)
    files = {path: (ROOT / "docs" / "examples" / name).read_text(encoding="utf-8") for path, name in links}
    return {**dict(blocks), **files}


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """Return a folder with a copy of the package to which the files of the page were added."""
    folder = tmp_path_factory.mktemp("extended")
    shutil.copytree(Path(tisph.__file__).parent, folder / "tisph", ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in examples().items():
        assert not (folder / name).exists()
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def run(extended, tmp_path):
    """Return a function that runs the command line of the copy and returns the last sample of the run."""

    def start(*arguments):
        command = [sys.executable, "-m", "tisph", "run", *arguments, *QUICK, "--out", str(tmp_path / "run")]
        done = subprocess.run(command, cwd=extended, env=environment(extended), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads((tmp_path / "run" / "summary.json").read_text())["samples"][-1]

    return start


def environment(folder):
    """Variables of a process that imports the package from a ``folder``."""
    return {**os.environ, "PYTHONPATH": str(folder)}


@pytest.mark.parametrize(
    ("what", "files"),
    [("rheology", 1), ("scenes", 1), ("observers", 1), ("schemes/wcsph/kernels", 1), ("schemes/wcsph/walls", 1)],
)
def test_an_example_is_as_few_files_as_the_page_says(what, files):
    assert sum(name.startswith(f"tisph/{what}/") for name in examples()) == files


def test_a_fluid_law_is_one_file(run):
    law = "fluid.rheology={type: cross, time: 2.0}"
    assert run(COUETTE, *FEW, "--set", law, "--set", "time.end=20.0")["l2"] < 3e-3  # of the numerical reference


def test_a_scene_is_one_file(run):
    assert run("shear_wave.yaml")["l2"] < 1e-5


def test_an_observer_is_one_file(extended):
    shutil.copy(COUETTE, extended / "couette.yaml")
    command = [sys.executable, "watch.py"]
    done = subprocess.run(command, cwd=extended, env=environment(extended), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    header, *lines = (extended / "fastest.csv").read_text().split()
    assert header == "t,speed"
    assert [float(line.split(",")[0]) for line in lines] == pytest.approx([0.5, 1.0, 1.5, 2.0])
    assert all(0 < float(line.split(",")[1]) <= 0.005 for line in lines)  # the wall's velocity


def test_a_kernel_is_one_file(run):
    kernel = ["discretisation.kernel=cubic_spline", "discretisation.smoothing_ratio=1.3", "scheme={type: wcsph}"]
    assert run(COUETTE, *FEW, *(word for each in kernel for word in ("--set", each)))["l2"] < 2e-2


def test_a_wall_treatment_is_one_file(run):
    changes = ["walls.treatment={type: slip_image}", "walls.top.velocity=0.0", "drive.acceleration=1e-3"]
    changes += ["scheme={type: wcsph}", "time.end=0.5"]
    sample = run(COUETTE, *FEW, *(word for each in changes for word in ("--set", each)))
    assert sample["centreline"] == pytest.approx(5e-4, rel=1e-9)  # g t: without friction all particles fall freely


def test_examples_are_on_the_menu_without_taichi(extended):
    program = """
import sys
from tisph import registry
for name in sys.argv[1:]:
    family, member = name.split("/")
    assert member in registry.names(family), name
    assert registry.summary(family, member), name
    registry.load(family, member)
    assert "taichi" not in sys.modules, name
"""
    names = ["rheology/cross", "scenes/shear_wave", "walls/slip_image", "kernels/cubic_spline"]
    command = [sys.executable, "-c", program, *names]
    done = subprocess.run(command, cwd=extended, env=environment(extended), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
