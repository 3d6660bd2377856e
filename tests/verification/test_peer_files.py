"""Files that the peers themselves write, judged by ``tisph compare`` as ``tisph bench`` judges their velocities."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from flows import flow_text

import tisph
from tisph.assessment import judge
from tisph.config import load
from tisph.exact import couette

PEERS = Path(tisph.__file__).parents[1] / "benchmarks" / "peers"

CASE = flow_text("couette_of_peers")

CODES = {
    "pysph": (PEERS / "env-pysph/bin/python", "pysph_couette.py", "end.npz", None, 1e-9),
    "lammps": (Path(sys.executable), "lammps_couette.py", "end.dump", "1", 1e-6),  # the dump has nine digits
}
"""Program, script, file, what to select in it, and how far the errors of file and velocities may differ."""


@pytest.mark.slow
@pytest.mark.parametrize("code", CODES)
def test_the_error_is_that_of_the_bench(tmp_path, code):
    python, script, name, select, rounding = CODES[code]
    if not (PEERS / f"env-{code}").exists():
        pytest.skip(f"benchmarks/peers has no env-{code}: make -C benchmarks/peers env-{code}/installed")
    end, words = 2.7, ["--across", "20", "--steps", "1200", "--end", "2.7"]
    files = ["--profile", tmp_path / "profile.txt", "--dump", tmp_path / name]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run([python, PEERS / script, *words, *files], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr[-2000:]
    assert json.loads(done.stdout.splitlines()[-1])["particles"] == 800

    y, u = np.loadtxt(tmp_path / "profile.txt", unpack=True)
    exact = couette.velocity(y, end, gap=1.0, kinematic_viscosity=0.01, bottom=0.0, top=0.5)
    measured = np.sqrt(np.sum((u - exact) ** 2) / np.sum(exact**2))  # the formula of benchmarks/peers/measure.py
    (tmp_path / "couette.yaml").write_text(CASE)
    written = next(tmp_path.glob("end.*"))  # PySPH writes HDF5 where it has h5py
    found = judge.judge(load(tmp_path / "couette.yaml"), [written], judge.Question(times=(end,), select=select))
    assert found.samples[0].numbers["l2"] == pytest.approx(measured, rel=rounding)
    assert found.samples[0].scene.rows == 20
