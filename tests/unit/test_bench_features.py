"""``tisph bench features``: scenes that are valid, ratios of pairs, what is deleted from the program, the verdicts."""

import ast
import dataclasses

import pytest
from typer.testing import CliRunner

from tisph.cli import app
from tisph.config import load
from tisph.errors import TisphError
from tisph.study.bench import features, lockstep
from tisph.study.bench.feature_cases import AGAIN, GROUPS, PARTS, WITHOUT_CODE, Comparison, Scene
from tisph.study.bench.stripped import STRIPPED, WHOLE, Deletion, added_kernels, copy_twice
from tisph.study.store import config_text

SCENES = [(name, scene) for name, group in GROUPS.items() for scene in group.scenes]


def measured(seconds, **fields):
    return {"seconds": seconds, "advanced": [2.0] * len(seconds), "particles": 10, "fields": fields}


@pytest.mark.parametrize(("group", "scene"), SCENES)
def test_every_scene_is_a_valid_config_of_5000_particles(tmp_path, group, scene):
    path = tmp_path / "scene.yaml"
    path.write_text(config_text("scene", GROUPS[group].scenes[scene].config))
    config = load(path, ())
    assert config.particles_across * config.columns == 5000
    assert config.scheme.type == {"explicit": "wcsph", "implicit": "implicit"}[group]


@pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS)
def test_every_scene_is_compared_with_another(group):
    compared = {name for one in group.comparisons for name in (one.scene, one.without)}
    assert compared == set(group.scenes)
    assert all(one.scene != one.without for one in group.comparisons)


def test_ratios_are_of_what_was_measured_in_the_same_turn():
    # the machine is ten times slower in the second turn: a ratio of medians would be 0.55 or 11 here, not 2
    first = {"part": measured([2.0, 20.0, 2.0]), "plain": measured([1.0, 10.0, 1.0])}
    second = {"part": measured([2.0, 2.0, 2.0]), "plain": measured([1.0, 1.0, 1.0])}
    row = features.row("explicit", Comparison("a part", "part"), [first, second])
    assert (row["ratio"], row["low"], row["high"]) == (2.0, 2.0, 2.0)


def test_bytes_and_steps_of_a_part_are_what_it_adds():
    with_it = measured([1.0, 1.0], position=160, stress=240) | {"advanced": [1.0, 1.0]}
    row = features.row("explicit", Comparison("a part", "part"), [{"part": with_it, "plain": measured([1.0, 1.0])}])
    assert row["steps"] == 2.0
    one = {"part": with_it, "plain": measured([1.0, 1.0], position=160)}
    row = features.row("explicit", Comparison("a part", "part"), [one])
    assert (row["bytes_without"], row["bytes_with"], row["added_fields"]) == (160, 400, {"stress": 240})


def test_an_event_counts_as_many_steps():
    plain = measured([0.002, 0.004, 0.002]) | {"records": {"seconds": 0.01, "bytes": 5}}
    row = features.event_row("explicit", "records", [{"plain": plain}])
    assert (row["steps"], row["bytes"]) == (pytest.approx(5.0), 5)


def verdicts(carried=1.0, others=0, less=0, same=True, frame=10.0):
    rows = [
        {"scene": AGAIN, "without_part": "plain", "ratio": 1.01},
        {
            "scene": "plain",
            "without_part": WITHOUT_CODE,
            "ratio": carried,
            "bytes_with": 80,
            "bytes_without": 80 - less,
        },
    ]
    kernels = {"plain": 40, "others_without_unused_parts": others}
    found = features.judge(rows, [{"same_config": True}, {"same_config": same}], kernels, {"one": {"total_ms": frame}})
    return list(found.values())


@pytest.mark.parametrize(
    ("fault", "place"),
    [({"same": False}, 0), ({"others": 1}, 1), ({"less": 8}, 2), ({"carried": 1.04}, 3), ({"frame": 26.0}, 4)],
)
def test_each_bound_can_be_missed(fault, place):
    assert verdicts() == [True] * 5
    assert [number for number, met in enumerate(verdicts(**fault)) if not met] == [place]


def test_only_what_a_flag_compiles_in_is_deleted():
    source = """
if ti.static(self.flag):
    first
else:
    second
if ti.static(self.other):
    third
if self.flag:
    fourth
"""
    deletion = Deletion({"flag"})
    left = ast.unparse(ast.fix_missing_locations(deletion.visit(ast.parse(source)))).split()
    assert [word for word in left if word in ("first", "second", "third", "fourth")] == ["second", "third", "fourth"]
    assert deletion.found == {"flag": 1}


def test_every_flag_has_code_to_delete(tmp_path):
    flags = {flag for part in PARTS for flag in part.flags}
    assert set(copy_twice(tmp_path, flags)) == flags
    branch = "if ti.static(self.liquid.carries_stress)"
    whole, stripped = ((tmp_path / copy / "tisph/operators/consistent.py").read_text() for copy in (WHOLE, STRIPPED))
    assert branch in whole
    assert branch not in stripped


def test_kernels_are_counted_once_they_are_new():
    def compile_into(*names):
        def use(environment):
            for name in names:
                with open(f"{environment['HOME']}/{name}.tic", "w"):
                    pass

        return use

    assert added_kernels([compile_into("a", "b"), compile_into("b"), compile_into("b", "c")]) == [
        {"a.tic", "b.tic"},
        set(),
        {"c.tic"},
    ]


def test_a_round_is_measured_once_for_a_group_of_scenes(tmp_path):
    calls = []

    def measure():
        calls.append(1)
        return {"plain": 1}

    def ask(group, cycles):
        return features.kept_round(tmp_path / "round.json", features._mark("code", group, cycles), measure)

    group = GROUPS["explicit"]
    assert ask(group, 5) == ask(group, 5) == {"plain": 1}
    assert len(calls) == 1
    ask(dataclasses.replace(group, steps=group.steps + 1), 5)
    ask(group, 6)
    assert len(calls) == 3


def test_a_scene_that_cannot_start_is_an_error_in_its_words():
    remote = lockstep.Remote(Scene({"scene": "nowhere"}))
    try:
        with pytest.raises(TisphError, match="nowhere"):
            remote.facts()
    finally:
        remote.close()


@pytest.mark.parametrize(("met", "status"), [(True, 0), (False, 1)])
def test_the_exit_status_says_whether_a_bound_is_missed(monkeypatch, met, status):
    monkeypatch.setattr(features, "run", lambda folder, quick: met)
    assert CliRunner().invoke(app, ["bench", "features"]).exit_code == status
