"""A run's own samples, judged as those of any code: the numbers of its summary."""

import json

import pytest

from tisph import simulation
from tisph.assessment import judge
from tisph.config.loader import loaded

pytestmark = pytest.mark.taichi

COMMON = {"fluid": {"density": 1.0, "kinematic_viscosity": 0.01}, "runtime": {"threads": 1}}
COMMON |= {"discretisation": {"particles_across": 12}}
FLOWS = {
    "channel": {
        "geometry": {"gap": 1.0, "length": 1.0},
        "walls": {"top": {"velocity": 0.5}},
        "initial": {"jitter": 0.2},
        "time": {"end": 2.7, "samples": [1.8, 2.7]},
    },
    "taylor_green": {
        "geometry": {"length": 1.0},
        "initial": {"velocity": 1.0, "jitter": 0.2},
        "time": {"end": 0.02, "samples": [0.01, 0.02]},
    },
}


@pytest.mark.parametrize("flow", FLOWS)
def test_the_assessment_says_what_the_run_said(tmp_path, flow):
    settings = loaded({"name": "case", "scene": flow, **COMMON, **FLOWS[flow]}, {})
    simulation.run(settings, tmp_path, video=False)
    own = json.loads((tmp_path / "summary.json").read_text())["samples"]
    found = judge.judge(settings, [tmp_path / "samples.h5"], judge.Question()).samples
    assert [each.numbers["t"] for each in found] == [sample["t"] for sample in own]
    for each, sample in zip(found, own, strict=True):
        assert each.aligned.notes == ()
        for key in sample.keys() - {"t", "step"}:
            expected = sample[key]
            if isinstance(expected, float):
                # the same functions read the same numbers: but for rounding in the spacing nothing may differ
                expected = pytest.approx(expected, rel=1e-6, abs=1e-14)
            assert each.numbers[key] == expected, key
