"""The study of the verdicts of ``tisph compare``: its configs are valid, and a wrong verdict counts as wrong."""

from types import SimpleNamespace

import pytest

from tisph.assessment.judge import has_reference
from tisph.config.loader import loaded
from tisph.studies import comparisons, suites

FLOWS = suites.study("comparisons")["flows"]


@pytest.mark.parametrize("name", FLOWS)
def test_flows_are_valid_and_have_no_exact_solution(name):
    flow = FLOWS[name]
    config = loaded({"name": name, **flow["config"]}, {})
    assert not has_reference(config)
    for given in flow["data"].values():
        assert loaded(config, {**flow["finer"], **given.get("keys", {})}).spacing < config.spacing


def judged(change, by, verdicts, explained):
    findings = [SimpleNamespace(verdict=each, difference=0.01, bar=0.001) for each in verdicts]
    names = [SimpleNamespace(name=name, values=(value,), uncertain=(0.001,), words="") for name, value in explained]
    found = SimpleNamespace(findings=findings, explained=names)
    return comparisons.judged("flow", change, by, found).judged


@pytest.mark.parametrize(
    ("change", "by", "verdicts", "explained", "expected"),
    [
        ("right", None, ["agrees", "agrees"], [], "right"),
        ("right", None, ["agrees", "differs"], [], "WRONG"),
        ("right", None, ["undecided"], [], "neither"),
        ("viscosity", 0.01, ["agrees", "differs"], [("drive", -0.01), ("viscosity", 0.011)], "right"),
        ("viscosity", 0.01, ["differs"], [("viscosity", 0.03)], "WRONG"),
        ("viscosity", 0.01, ["differs"], [("drive", -0.01)], "WRONG"),
        ("viscosity", 0.01, ["differs"], [], "neither"),
        ("viscosity", 0.01, ["agrees"], [], "WRONG"),
        ("viscosity", 0.01, ["undecided", "agrees"], [], "neither"),
        ("relaxation_time", 0.1, ["differs"], [("relaxation time", 0.1)], "right"),
    ],
)
def test_a_verdict_is_right_only_with_the_change_and_its_value(change, by, verdicts, explained, expected):
    assert judged(change, by, verdicts, explained) == expected
