"""The table of references: sources of every value, planted wrong numbers, names in suites, what the command prints."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tisph import cli
from tisph.config.yaml_text import parse
from tisph.errors import ConfigError
from tisph.references import table
from tisph.studies import checks, suites, verify
from tisph.studies.expressions import SuiteError
from tisph.studies.processes import Result

NAMES = [(flow, name) for flow in table.flows() for name in table.flow_named(flow)["numbers"]]
CONFIRMED = sorted(
    {(pair.flow, pair.name) for flow in table.flows() for pair in table.pairs(flow) if pair.verdict == table.AGREES}
)


@pytest.fixture
def planted(monkeypatch):
    """Return a function that replaces the entry ``index`` of the values of a number in the table."""

    def plant(flow, name, index=0, **changes):
        found = json.loads(json.dumps(table.flows()))
        entry = found[flow]["numbers"][name]["values"][index]
        entry.pop("computed", None)
        entry.update(changes)
        monkeypatch.setattr(table, "flows", lambda: found)

    return plant


@pytest.mark.parametrize("flow", table.flows())
def test_every_value_has_a_source_that_says_how_and_whether_checked(flow):
    data = table.flow_named(flow)
    used = {value.source for name in data["numbers"] for value in table.values(flow, name)}
    assert used == set(data["sources"])
    for source in data["sources"].values():
        assert source["how"] in table.WAYS
        assert ("command" in source) == (source["how"] == "own computation")
        assert source["checked"] is False or len(source["checked"]) > 10


@pytest.mark.parametrize("flow", table.flows())
def test_values_that_disagree_have_a_reason(flow):
    assert [pair for pair in table.pairs(flow) if pair.verdict == table.DISAGREES] == []


@pytest.mark.parametrize(("flow", "name"), CONFIRMED)
def test_a_wrong_number_makes_a_row_fail_where_a_source_confirms_it(planted, flow, name):
    """By 5 %: more than the spreads of all pairs."""
    planted(flow, name, value=1.05 * table.values(flow, name)[0].value)
    suite = verify.suite_of("references")
    failed = {row.case for row in map(verify.Runner(suite, Path()).judge, suite.criteria) if not row.passed}
    assert failed == {flow}


def test_values_are_taken_from_the_references_of_exact_solutions():
    assert table.number("lid_driven_cavity.v_min_1000") == -0.5270771
    assert table.number("dfg_2d_1.drag_coefficient") == 5.57953523384
    assert table.number("-0.5*contraction.corner_vortex") == -0.75


def test_a_wrong_number_in_the_table_fails_the_row_of_a_suite(planted):
    entry = {"run": "cylinder", "number": "drag", "expected": "0.002*dfg_2d_1.drag_coefficient", "within": 3.0e-3}
    result = Result(Path(), {"status": "done", "samples": [{"drag": 0.011159}]})

    def passed():
        (row,) = checks.criteria(entry, {"cylinder"})
        return row.judge(result).passed

    assert passed()
    planted("dfg_2d_1", "drag_coefficient", value=5.61)
    assert not passed()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("dfg_2d1.drag_coefficient", "no reference flow 'dfg_2d1'; nearest: dfg_2d_1"),
        ("dfg.drag_coefficient", "no reference flow 'dfg'; there are dfg_2d_1, dfg_2d_2, dfg_2d_3"),
        ("dfg_2d_1.drag", "dfg_2d_1 has no number 'drag'"),
        ("5,6", "'5,6': must be a number, or a reference such as"),
    ],
)
def test_a_name_that_does_not_exist_is_refused(name, message):
    entry = {"run": "a", "number": "drag", "expected": name, "within": 0.1}
    with pytest.raises(SuiteError, match=message):
        list(checks.criteria(entry, {"a"}))


def test_suites_repeat_no_value_of_the_table():
    """No reference of five digits or more stands in a suite as a number; frontier.yaml has a test of its own."""
    digits = {f"{abs(table.values(*each)[0].value):.12g}" for each in NAMES}
    long = {text for text in digits if len(re.sub(r"\D", "", text).lstrip("0")) >= 5}
    for name in suites.PARTS:
        checked = parse((suites.FOLDER / f"{name}.yaml").read_text(encoding="utf-8")).data
        found = re.findall(r"expected': (-?[\d.e-]+)", str(checked))
        assert {text.lstrip("-") for text in found} & long == set()


def test_the_command_prints_lines_of_eighty_columns():
    for words in [[], *[[flow] for flow in table.flows()]]:
        shown = CliRunner().invoke(cli.app, ["references", *words])
        assert shown.exit_code == 0
        assert max(map(len, shown.stdout.splitlines())) <= table.COLUMNS


def test_the_command_marks_contradictions_and_unchecked_sources():
    shown = CliRunner().invoke(cli.app, ["references", "oldroyd_b_cylinder"]).stdout
    assert "contradicts" in shown
    assert "NOT CHECKED" in shown
    assert "drag_0.1 [viscosity V] NO SECOND SOURCE" in shown
    assert "contradicts lid_driven_cavity.u_min_100" in CliRunner().invoke(cli.app, ["references"]).stdout


def test_the_command_fails_where_two_sources_disagree(planted):
    planted("dfg_2d_1", "drag_coefficient", value=5.61)
    shown = CliRunner().invoke(cli.app, ["references", "dfg_2d_1"])
    assert shown.exit_code == 1
    assert "DISAGREES" in shown.stdout


def test_an_unknown_flow_is_answered_with_the_nearest_name():
    shown = CliRunner().invoke(cli.app, ["references", "dfg_2d"])
    assert shown.exit_code == 2
    assert "there are dfg_2d_1, dfg_2d_2, dfg_2d_3" in shown.output


def test_json_has_the_values_of_computed_numbers_and_verdicts():
    found = json.loads(CliRunner().invoke(cli.app, ["references", "taylor_vortices", "--json"]).stdout)
    numbers = found["taylor_vortices"]["numbers"]
    assert numbers["critical_0.5"]["value"] == pytest.approx(68.18627, abs=1e-5)
    assert {pair["verdict"] for pair in found["taylor_vortices"]["compared"]} == {"agrees", "contradicts"}


def test_there_is_no_long_section():
    with pytest.raises(ConfigError, match="references has no long section"):
        verify.suite_of("references", long=True)
