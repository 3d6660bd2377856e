"""A run's own samples, judged as those of any code: the numbers of its summary."""

import importlib.util
import json

import pytest
from typer.testing import CliRunner

from tisph import cli, config, simulation
from tisph.assessment import judge

pytestmark = pytest.mark.taichi

FLOWS = {
    "channel": """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 1.0}
walls: {top: {velocity: 0.5}}
discretisation: {particles_across: 12}
initial: {jitter: 0.2}
time: {end: 2.7, samples: [1.8, 2.7]}
runtime: {threads: 1}
""",
    "taylor_green": """
scene: taylor_green
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {length: 1.0}
initial: {velocity: 1.0, jitter: 0.2}
discretisation: {particles_across: 12}
time: {end: 0.02, samples: [0.01, 0.02]}
runtime: {threads: 1}
""",
}

ELSEWHERE = ("t", "step")
"""Numbers that are no measure of the particles."""


@pytest.mark.parametrize("flow", FLOWS)
def test_the_assessment_says_what_the_run_said(tmp_path, flow):
    path = tmp_path / "case.yaml"
    path.write_text(FLOWS[flow])
    settings = config.load(path)
    simulation.run(settings, tmp_path, video=False)
    own = json.loads((tmp_path / "summary.json").read_text())["samples"]
    found = judge.judge(settings, [tmp_path / "samples.h5"], judge.Question()).samples
    assert [each.numbers["t"] for each in found] == [sample["t"] for sample in own]
    for each, sample in zip(found, own, strict=True):
        assert each.aligned.notes == ()
        for key in sample.keys() - set(ELSEWHERE):
            expected = sample[key]
            if isinstance(expected, float):
                # the same functions read the same numbers: but for rounding in the spacing nothing may differ
                expected = pytest.approx(expected, rel=1e-6, abs=1e-14)
            assert each.numbers[key] == expected, key
    exported(settings, tmp_path, [sample["l2"] for sample in own])


def exported(settings, folder, expected):
    """What tisph writes for other programs is judged the same."""
    for kind in ("npz", "vtkhdf"):
        if kind == "vtkhdf" and not importlib.util.find_spec("vtk"):
            continue
        path = folder / f"samples.{kind}"
        assert CliRunner().invoke(cli.app, ["export", str(folder), "--to", kind, "--out", str(path)]).exit_code == 0
        found = judge.judge(settings, [path], judge.Question()).samples
        assert [each.numbers["l2"] for each in found] == pytest.approx(expected, rel=1e-6)
