"""A chain of runs until a number has an error bar inside its goal: on numbers that are known, and on two small runs."""

import json
import math
from dataclasses import dataclass, field, replace

import pytest
from typer.testing import CliRunner

from tisph import run as tisph_run
from tisph.cli import app
from tisph.config.goals import goal
from tisph.errors import ConfigError, TisphError
from tisph.studies import until
from tisph.studies.until import Chain, Point, extrapolated


@dataclass
class Numbers:
    """A source of runs with 10 / factor particles across, whose number is ``of(spacing)``; a run costs h^-3."""

    of: object
    coarsest: float = 1.0
    orders: tuple = (2.0, 6.0)
    rounding: float = 1e-12
    change: float = 0.0
    scatter: float = 0.0
    ends: dict = field(default_factory=dict)
    kept: set = field(default_factory=set)
    made: list = field(default_factory=list)
    spent: float = 0.0

    def across(self, factor):
        return round(10 / factor)

    def run(self, factor):
        across = self.across(factor)
        self.spent += self.seconds(factor)
        self.made.append(across)
        h = 1.0 / across
        return Point(across, h, (across / 10) ** 3, f"across_{across}", {"drag": self.of(h)}, {"drag": self.scatter})

    def time_errors(self):
        return {"drag": self.change}

    def end_errors(self):
        return self.ends

    def seconds(self, factor):
        return 0.0 if self.across(factor) in self.kept else (self.across(factor) / 10) ** 3

    def norms(self, name, points):
        raise AssertionError("there are no fields")


def chain(of, asked, at_most=math.inf, **options):
    said = []
    made = Chain(Numbers(of, **options), [goal("drag", asked)], at_most, said.append)
    made.run()
    return made, made.entries()["drag"], said


@pytest.mark.parametrize("order", [2.0, 3.0, 4.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_bar_of_a_number_with_an_order_has_the_safety_factor(order, sign):
    _made, found, _ = chain(lambda h: 5.0 + sign * 20.0 * h**order, "0.1%")
    assert found["reached"]
    error = abs(found["value"] - 5.0)
    assert error <= found["bar"] <= 1.01 * until.SAFETY * error
    assert found["bar"] <= found["goal"] == pytest.approx(1e-3 * found["value"])
    assert found["order"] == pytest.approx(order, rel=1e-4)


def test_a_chain_stops_at_the_cheapest_run_and_skips_others():
    made, _found, said = chain(lambda h: 1.0 + h**2, 1e-5)
    # 1.5 h^2 <= 1e-5 needs 387 across, and 0.9 of it 408
    assert made.source.made[:3] == [10, 14, 20]
    assert 387 <= made.source.made[-1] <= 440
    ratios = [finer / coarser for coarser, finer in zip(made.source.made[2:], made.source.made[3:], strict=False)]
    assert max(ratios) > 2.0
    assert said[0] == "first run: about 1 s"
    assert "by the scheme's order the goal needs" in said[2]
    assert "by the observed order the goal needs" in said[3]


def test_only_three_runs_where_they_do():
    made, found, _ = chain(lambda h: 1.0 + h**4, "1%")
    assert made.source.made == [10, 14, 20]
    assert [each["particles_across"] for each in found["runs"]] == [10, 14, 20]


def test_parts_of_the_bar_are_summed_in_squares():
    _, found, _ = chain(lambda h: 1.0 + h**3, 0.1, change=0.01, scatter=1e-3)
    assert found["parts"]["time"] == pytest.approx(0.01 * 0.5**3)
    assert found["parts"]["scatter"] == pytest.approx(2e-3)
    assert found["bar"] == pytest.approx(math.hypot(*found["parts"].values()))


@pytest.mark.parametrize(
    ("of", "asked", "reason"),
    [
        (lambda h: 1.0 + h**0.5, 1e-4, "order 0.5 where 1.5 to 6"),
        (lambda h: 1.0 + 1e6 * h**9, 1e-9, "order 9 where 1.5 to 6"),
        (lambda h: 1.0 + math.sin(1e4 / h**1.7), 1e-3, "it "),
        (lambda h: 1.0 + 1.0 / h, 1e-3, "does not converge"),
        (lambda h: 1.0 + h**4, 1e-14, "below the rounding error"),
        (lambda h: 1e-9 + h**4, "1%", "zero within its bar"),
    ],
)
def test_a_goal_is_refused_with_a_reason_and_a_bar(of, asked, reason):
    _, found, _ = chain(of, asked)
    assert not found["reached"]
    assert reason in found["reason"]
    assert found["bar"] > 0.0
    assert len(found["runs"]) >= 3


def test_numbers_that_go_up_and_down_have_their_spread_as_bar():
    values = {10: 1.0, 14: 1.002, 20: 1.001}
    _, found, _ = chain(lambda h: values[round(1 / h)], "1%")
    assert found["reached"]
    assert found["bar"] == pytest.approx(until.SAFETY * 0.001)
    assert "goes up and down" in found["reason"]


def test_scatter_around_an_order_is_in_the_bar_of_four_runs():
    scatter = {10: 0.0, 14: 3e-3, 20: -3e-3, 28: 1e-3}
    values = {across: 1.0 + 30 * across**-3.0 + each for across, each in scatter.items()}
    spacings = [1 / across for across in values]
    wide, order = until.fitted(spacings, list(values.values()))
    assert until.ORDERS[0] <= order <= until.ORDERS[1]
    assert abs(values[28] - 1.0) < wide < 0.02
    exact, _ = until.fitted(spacings, [1.0 + 30 * h**3 for h in spacings])
    assert exact == pytest.approx(until.SAFETY * 30 / 28**3, rel=1e-3)


def test_a_number_of_low_order_has_the_bar_of_that_order():
    spacings = [1 / 10, 1 / 14, 1 / 20]
    values = [h**1.2 for h in spacings]
    norms = [values[0] - values[1], values[1] - values[2], values[0] - values[2]]
    error, order, doubt = extrapolated(spacings, norms, True, 0.0, 3.0)
    assert error == pytest.approx(until.SAFETY * values[2], rel=1e-3)
    assert doubt == "order 1.2 where 1.5 to 6 is to be expected"
    assert order == pytest.approx(1.2, rel=1e-3)


def test_an_order_that_is_too_good_is_not_extrapolated_with():
    h = [0.1, 0.07, 0.05]
    error, order, doubt = extrapolated(
        h, [0.1**5.5 - 0.07**5.5, 0.07**5.5 - 0.05**5.5, 0.1**5.5 - 0.05**5.5], True, 0.0, 2.0
    )
    assert (order, doubt) == (pytest.approx(5.5, rel=1e-4), "")
    assert error > until.SAFETY * 0.05**5.5


class Fields(Numbers):
    """A source of runs without an exact solution, with an error of the velocity of h^4."""

    def run(self, factor):
        return replace(super().run(factor), values={})

    def time_errors(self):
        return {}

    def norms(self, name, points):
        a, b, c = (each.spacing**4 for each in points)
        return [a - b, b - c, a - c]


def test_a_norm_of_the_error_is_estimated_from_three_runs():
    made = Chain(Fields(lambda h: 0.0), [goal("l2", "0.001%")], say=lambda _: None)
    made.run()
    found = made.entries()["l2"]
    assert found["reached"]
    assert found["goal"] == 1e-5
    assert found["value"] == found["bar"] == pytest.approx(until.SAFETY * made.points[-1].spacing ** 4, rel=1e-3)


def test_runs_that_agree_but_for_rounding_have_the_rounding_error_as_bar():
    _, found, _ = chain(lambda h: 3.0, "0.1%")
    assert (found["reached"], found["bar"]) == (True, pytest.approx(3e-12))


def test_the_next_run_may_cost_too_much():
    made, found, _ = chain(lambda h: 1.0 + h**2, 1e-6, at_most=30.0)
    assert made.source.spent <= 30.0
    assert "more than --at-most" in found["reason"]
    assert found["bar"] > 1e-6
    assert not found["reached"]
    assert found["value"] == 1.0 + made.points[-1].spacing ** 2


def test_kept_runs_cost_nothing():
    made, _, _ = chain(lambda h: 1.0 + h**2, 1e-3, at_most=0.0, kept=set(range(1000)))
    assert not made.stopped


def test_a_run_that_fails_ends_the_chain():
    def of(h):
        if h < 0.06:
            raise TisphError("the run across_20 did not finish")
        return 1.0 + h

    _, found, _ = chain(of, 1e-3)
    assert (found["reached"], found["reason"]) == (False, "the run across_20 did not finish")
    assert found["value"] == 1.0 + 1 / 14


@pytest.mark.parametrize("given", ["0", "-1%", "nan", "inf", "nan%", "1e", "", "1,5%", True])
def test_what_is_no_goal_is_named(given):
    with pytest.raises(ValueError, match=r"drag = .*: must be a"):
        goal("drag", given)


CASE = """\
scene: pipe
fluid: {density: 1.0, kinematic_viscosity: 1.0}
geometry: {radius: 1.0, length: 2.0}
drive: {acceleration: 4.0}
initial: {jitter: 0.2}
discretisation: {particles_across: 14}
time: {end: 0.1}
runtime: {threads: 1}
"""


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path / "case.yaml"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--until", "force_outr=1%"], "--until force_outr: no number of a sample"),
        (["--until", "force_outr=1%"], "force_outer"),
        (["--until", "force_outer=0"], "must be a finite number greater than 0"),
        (["--until", "force_outer"], "must be a number"),
        (["--until", "reason=1%"], "no number of a sample"),
        (["--until", "force_outer=1%", "--at-most", "soon"], "such as 90s, 10min or 2h"),
        (["--at-most", "10min"], "--at-most: is for --until"),
        (["--vary", "geometry.length=2"], "--vary: is for --until"),
        (["--until", "force_outer=1%", "--vary", "geometry.lenth=2"], "must be a length of the geometry: geometry."),
        (["--until", "force_outer=1%", "--vary", "geometry.length=1"], "must be a factor, such as 1.25"),
        (["--until", "force_outer=1%", "--vary", "geometry.length=0.01"], "--vary: "),
        (["--until", "force_outer=1%", "--resume"], "--resume: is not for --until"),
        (["--set", "accuracy={force_outer: nan}"], "accuracy"),
    ],
)
def test_bad_options_are_named(case, options, message):
    found = CliRunner().invoke(app, ["run", str(case), *options])
    assert found.exit_code == 2
    assert message in " ".join(found.stderr.split())


def test_a_chain_goes_on_after_it_was_killed(case, monkeypatch):
    made = []
    outcome = until.Store.outcome

    def killed(self, name, config):
        if len(made) == 3:
            raise KeyboardInterrupt
        made.append(name)
        return outcome(self, name, config)

    with monkeypatch.context() as patch:
        patch.setattr(until.Store, "outcome", killed)
        CliRunner().invoke(app, ["run", str(case), "--until", "force_outer=1%", "--out", "out"])
    kept = (case.parent / "out/chain" / made[0] / "summary.json").stat().st_mtime_ns
    results = tisph_run(case, "out", until={"force_outer": "1%"}, overwrite=True)  # as in a sweep
    assert (case.parent / "out/chain" / made[0] / "summary.json").stat().st_mtime_ns == kept
    found = results.accuracy["force_outer"]
    assert found["reached"]
    assert found["bar"] <= found["goal"]
    assert set(found["parts"]) == {"spacing", "time", "scatter", "steadiness"}
    exact = results.summary.samples[-1]["force_outer_exact"]
    assert abs(found["value"] - exact) <= found["bar"]
    assert results.config.particles_across == found["runs"][-1]["particles_across"]
    assert (case.parent / "out/accuracy.png").is_file()
    assert json.loads((case.parent / "out/accuracy.json").read_text()) == results.accuracy
    # a goal that is not reached is no error in Python, and exit status 1 on the command line
    found = CliRunner().invoke(
        app, ["run", str(case), "--until", "force_outer=1e-9", "--at-most", "0.1s", "--out", "out"]
    )
    assert found.exit_code == 1
    assert "a goal is not reached: force_outer: the next run costs" in found.stderr
    # the force on a pipe that is longer by a half is larger by a half, of which the bar knows
    longer = tisph_run(case, "out", until={"force_outer": "1%"}, at_most="0.1s", vary={"geometry.length": 1.5})
    unreached = longer.accuracy["force_outer"]
    assert not unreached["reached"]
    assert unreached["parts"]["ends"] == pytest.approx(0.5 * unreached["value"], rel=1e-3)


def test_a_folder_with_other_results_is_left_alone(case):
    (case.parent / "out").mkdir()
    (case.parent / "out/summary.json").write_text("{}")
    with pytest.raises(ConfigError, match="is not empty"):
        tisph_run(case, "out", until={"force_outer": "1%"})


def test_ends_have_a_part_of_their_own():
    _, found, _ = chain(lambda h: 1.0 + h**3, 0.1, ends={"drag": 2e-3})
    assert found["parts"]["ends"] == 2e-3
    assert found["bar"] == pytest.approx(math.hypot(*found["parts"].values()))
    _, found, _ = chain(lambda h: 1.0 + h**3, 1e-3, ends={"drag": 2e-3})
    assert found["reason"] == "the part ends alone is outside the goal, and finer runs do not change it"
    assert len(found["runs"]) == 3
