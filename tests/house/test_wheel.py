"""With nothing but the wheel, in an empty folder: from a config of the menu to movie, page and ParaView file."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

import tisph

pytestmark = pytest.mark.taichi

ROOT = Path(tisph.__file__).parents[1]
SMALL = ["discretisation.particles_across=12", "time.end=0.5", "time.samples=[0.5]", "runtime.threads=1"]
VIDEO = "output.video={frames: 3, width: 640, height: 320}"


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Python of an environment that has the wheel, and besides it only what tisph depends on."""
    pytest.importorskip("build", reason="there is no build, which the test extra brings")
    pytest.importorskip("hatchling", reason="there is no hatchling, which the test extra brings")
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "env", with_pip=False)
    inside = Path("Scripts/python.exe" if os.name == "nt" else "bin/python")
    python = folder / "env" / inside
    install = [sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", wheel]
    subprocess.run(install, check=True, capture_output=True)
    program = "import sysconfig; print(sysconfig.get_path('purelib'))"
    packages = subprocess.run([python, "-c", program], check=True, capture_output=True, text=True).stdout.strip()
    # what it depends on is taken from here: paths in such a file are searched after the environment's own
    Path(packages, "beside.pth").write_text(sysconfig.get_path("purelib"))
    return python


def test_three_commands_after_the_wheel(python, tmp_path):
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}

    def call(*arguments):
        command = [python, *arguments]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert not Path(call("-c", "import tisph; print(tisph.__file__)").strip()).is_relative_to(ROOT)
    assert (
        call("-c", "import importlib.resources as r; print(r.files('tisph').joinpath('py.typed').is_file())")
        == "True\n"
    )
    shown = [line for line in call("-m", "tisph", "new", "--list").splitlines() if line.startswith("  ")]
    assert len(shown) == len(list((ROOT / "configs").glob("*.yaml")))
    assert call("-m", "tisph", "new", "couette_minimal") == "couette_minimal.yaml\n"
    assert "  fluid.density: number above 0 [mass/length³]; must be given\n" in call("-m", "tisph", "keys", "cavity")
    overrides = [part for text in (*SMALL, VIDEO) for part in ("--set", text)]
    call("-m", "tisph", "run", "couette_minimal.yaml", *overrides)
    call("-m", "tisph", "report", "runs/couette_minimal")
    call("-m", "tisph", "export", "runs/couette_minimal", "--to", "vtkhdf")
    results = tmp_path / "runs/couette_minimal"
    for name, start in (("movie.mp4", b"ftyp"), ("report.html", b"<!DOCTYPE html>"), ("samples.vtkhdf", b"HDF")):
        assert start in (results / name).read_bytes()[:20], name
