"""The verification suite: its runs, and how they are run and judged. Nothing is simulated."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from ruamel.yaml import YAML

from tisph.config import load
from tisph.studies import verify
from tisph.studies.processes import Result
from tisph.studies.verification import suite, two_dimensional_polymers
from tisph.studies.verification.criteria import at_most, ends_at, near


def listed(quick):
    """Every run and every bound of the suite, a line each."""
    criteria = [f"{one.case}: {one.quantity} {one.bound}" for one in suite.criteria(quick)]
    return [*criteria, *(f"{name}: {json.dumps(config)}" for name, config in suite.runs(quick).items())]


@pytest.mark.parametrize("quick", [True, False])
def test_cases_and_bounds_are_those_that_the_words_about_them_quote(quick):
    """README.md and docs quote what these runs gave: whoever changes a case or a bound changes it here and there."""
    path = Path(__file__).parent / "data" / f"suite_{'quick' if quick else 'full'}.txt"
    assert listed(quick) == path.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("quick", [True, False])
def test_runs_that_show_an_order_differ_in_their_spacing_only(quick):
    runs = suite.runs(quick)
    for criterion in suite.criteria(quick):
        if "order" in criterion.quantity:
            rest = [{**runs[name], "discretisation": None} for name in criterion.runs]
            assert all(config == rest[0] for config in rest)


@pytest.mark.parametrize("quick", [True, False])
def test_every_run_is_needed_and_every_needed_run_exists(quick):
    needed = {name for criterion in suite.criteria(quick) for name in criterion.runs}
    assert needed == set(suite.runs(quick))


@pytest.mark.parametrize("quick", [True, False])
def test_every_bound_accepts_what_it_says(quick):
    """A number beyond it by a hundredth does not pass, one within it by as much does."""
    ways = {"<=": 1.0, ">=": -1.0}
    for criterion in suite.criteria(quick):
        sign, _, number = criterion.bound.partition(" ")
        if sign in ways:
            bound, way = float(number), ways[sign]
            beyond, within = (bound + side * way * 0.01 * abs(bound) for side in (1, -1))
            assert (criterion.accepts(beyond), criterion.accepts(within)) == (False, True), criterion.quantity


@pytest.mark.parametrize("quick", [True, False])
def test_orders_are_those_of_the_spacings_that_the_runs_have(quick):
    runs, found = suite.runs(quick), []
    for criterion in suite.criteria(quick):
        if " order at " in criterion.quantity:
            across = [runs[name]["discretisation"]["particles_across"] for name in criterion.runs]
            results = [SimpleNamespace(measure=lambda t, quantity, n=n: n**-2.5) for n in across]
            found.append(criterion.value(*results))
    assert found == pytest.approx([2.5] * len(found), rel=1e-9)
    assert found


def test_drag_of_a_confined_cylinder_is_read_at_its_weissenberg_number():
    """117.78 at Wi = 0.6 (Hulsen et al. 2005), over viscosity and velocity; the drive pushes the area, pi, too."""
    criterion = two_dimensional_polymers._drag("confined_cylinder")
    fluid = two_dimensional_polymers.CONFINED["fluid"]
    velocity = 0.6 / fluid["rheology"]["relaxation_time"]
    force = 117.78 * fluid["kinematic_viscosity"] * velocity
    pushed = force - math.pi * two_dimensional_polymers.CONFINED["drive"]["acceleration"]
    result = SimpleNamespace(last={"superficial_velocity": velocity, "drag": pushed})
    assert criterion.value(result) == pytest.approx(0.0, abs=1e-9)


def time_scale(config):
    geometry = config["geometry"]
    if config["scene"] == "channel":
        return geometry["gap"] ** 2 / config["fluid"]["kinematic_viscosity"]
    if config["scene"] in ("annulus", "eccentric_annulus"):
        gap = geometry["outer_radius"] - geometry["inner_radius"]
        return gap**2 / config["fluid"]["kinematic_viscosity"]
    if config["scene"] == "pipe":
        gap = geometry["radius"] - geometry.get("inner_radius", 0.0)
        return gap**2 / config["fluid"]["kinematic_viscosity"]
    if config["scene"] == "cavity":
        return geometry["width"] / config["walls"]["lid"]["velocity"]
    return geometry["length"] / config["initial"]["velocity"]


@pytest.mark.parametrize("quick", [True, False])
def test_all_couette_runs_are_the_same_flow(quick):
    """Re = 50, whatever the units and the walls."""
    for config in suite.couette.runs(quick).values():
        speed = max(abs(config["walls"][name]["velocity"]) for name in ("bottom", "top"))
        reynolds = speed * config["geometry"]["gap"] / config["fluid"]["kinematic_viscosity"]
        assert reynolds == pytest.approx(50, rel=1e-14)


def test_creeping_and_fast_flow_have_the_reynolds_numbers_of_their_names():
    runs = suite.runs(quick=False)
    for name, expected in (("implicit_creeping", 0.0125), ("implicit_re_1000", 1000.0)):
        config = runs[name]
        speed, gap = config["walls"]["top"]["velocity"], config["geometry"]["gap"]
        assert speed * gap / config["fluid"]["kinematic_viscosity"] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("quick", [True, False])
def test_the_si_run_is_the_base_in_other_units(quick):
    """1 cm = 0.01 m, mass and time the same."""
    runs = suite.runs(quick)
    ours, base = runs["si"], runs["across_25" if quick else "across_50"]
    powers = {"density": -3, "kinematic_viscosity": 2, "gap": 1, "length": 1}
    for part in ("fluid", "geometry"):
        for key, value in base[part].items():
            assert ours[part][key] == pytest.approx(value * 0.01 ** powers[key], rel=1e-14)
    assert ours["walls"]["top"]["velocity"] == pytest.approx(0.01 * base["walls"]["top"]["velocity"], rel=1e-14)


@pytest.mark.parametrize("quick", [True, False])
def test_every_run_has_the_samples_that_are_asked_of_it(quick):
    runs = suite.runs(quick)
    for criterion in suite.criteria(quick):
        if "t*" in criterion.quantity:
            t_star = float(criterion.quantity.rpartition(" ")[2])
            for name in criterion.runs:
                times = [t / time_scale(runs[name]) for t in runs[name]["time"]["samples"]]
                assert any(math.isclose(time, t_star, rel_tol=1e-9) for time in times)


@pytest.mark.parametrize("quick", [True, False])
def test_runs_have_names_of_their_own(quick):
    parts = [part.runs(quick) for part in suite.PARTS]
    assert len(suite.runs(quick)) == sum(map(len, parts))


def test_every_flow_has_bounds_of_wall_shear_and_momentum():
    criteria = suite.criteria(quick=False)
    for part in (suite.channel, suite.viscoelastic):
        for name, flow in part.FLOWS.items():
            own = [criterion.quantity for criterion in criteria if criterion.case == name]
            assert "momentum closure" in own
            assert {f"wall_shear at t* = {t_star:g}" for t_star in flow.samples} <= set(own)


def test_the_fluid_without_polymer_differs_in_its_rheology_only():
    runs = suite.runs(quick=False)
    ours, newtonian = runs["oldroyd_b_without_polymer"], runs["newtonian"]
    assert ours["fluid"].pop("rheology")["solvent_fraction"] == 1.0
    assert ours == newtonian


@pytest.mark.parametrize("quick", [True, False])
def test_every_run_is_a_valid_config(quick, tmp_path):
    for name, config in suite.runs(quick).items():
        path = tmp_path / f"{name}.yaml"
        YAML(typ="safe", pure=True).dump({"name": name, **config}, path)
        assert load(path).time.samples == tuple(config["time"]["samples"])


def test_a_number_whose_reference_a_sample_lacks_is_none():
    """Of a flow that is not yet steady there is none; to be judged by it is to fail."""
    sample = {"t_star": 1.0, "u_extreme": -0.2, "u_extreme_exact": None}
    result = Result(Path(), {"status": "done", "samples": [sample]})
    assert math.isnan(result.measure(1.0, "u_extreme off exact"))
    assert not at_most("cavity", 1.0, "u_extreme off exact", 1.0).judge(result).passed


@pytest.mark.parametrize(("status", "value"), [("done", 0.1), ("diverged", math.nan)])
def test_only_a_run_that_reached_its_end_ends_at_a_value(status, value):
    criterion = ends_at("array", "drag", 10.0, 0.2, lambda run: run.last["drag"])
    check = criterion.judge(Result(Path(), {"status": status, "samples": [{"drag": 5.0}, {"drag": 11.0}]}))
    assert check.value == pytest.approx(value, nan_ok=True)
    assert check.passed == (status == "done")


def test_momentum_that_is_lost_is_found():
    """A force that is 1 % too large, on a liquid that is driven by what its momentum says."""
    (criterion,) = [one for one in suite.bodies.criteria(False) if "momentum" in one.quantity]
    config = suite.bodies.runs(False)["array_0.2"]
    drive = config["drive"]["acceleration"] * (1 - math.pi * config["bodies"][0]["radius"] ** 2)
    for factor, passed in ((1.0, True), (1.01, False)):
        samples = [
            {"t": t, "superficial_velocity": 0.5 * drive * t, "drag": 0.5 * factor * drive}
            for t in config["time"]["samples"]
        ]
        check = criterion.judge(Result(Path(), {"status": "done", "samples": samples}))
        assert check.passed == passed
        assert check.value == pytest.approx(0.5 * (factor - 1), abs=1e-9)


def spheric_run(factor, steady=True):
    """The last sample of the cavity at Re = 1000: numbers ``factor`` times as large as those of Botella and Peyret."""
    exact = {"u_extreme": -0.3885698, "v_max": 0.3769447, "v_min": -0.5270771}
    sample = {"t_star": 60.0, "energy_change": 1e-5 if steady else 1e-2}
    sample |= {name: factor * value for name, value in exact.items()}
    sample |= {f"{name}_exact": value if steady else None for name, value in exact.items()}
    return Result(Path(), {"status": "done", "samples": [sample]})


@pytest.mark.parametrize(
    ("result", "failing"),
    [
        (spheric_run(1.0), 0),
        (spheric_run(1.1), 3),
        (spheric_run(1.0, steady=False), 4),
        (Result(Path(), {"status": "diverged", "samples": []}), 4),
    ],
    ids=["exact", "off", "unsteady", "stopped"],
)
def test_a_steady_cavity_has_the_extremes_of_botella_and_peyret(result, failing):
    for number in (50, 70, 100):
        criteria = [one for one in suite.LONG["cavity"].criteria() if one.runs == (f"cavity_re1000_{number}",)]
        assert sum(not criterion.judge(result).passed for criterion in criteria) == failing
        assert len(criteria) == 4


@pytest.mark.parametrize(
    ("status", "resolved", "passed"),
    [("done", [False, False], True), ("diverged", [], True), ("done", [False, True], False), ("failed", [], False)],
)
def test_a_cavity_with_too_few_particles_stops_or_is_not_resolved(status, resolved, passed):
    criterion = suite.LONG["cavity"].criteria()[-1]
    assert suite.LONG["cavity"].runs()[criterion.case]["fluid"]["kinematic_viscosity"] == 1e-4
    summary = {"status": status, "samples": [{"resolved": each} for each in resolved]}
    assert criterion.judge(Result(Path(), summary)).passed == passed


@pytest.fixture
def small_suite(monkeypatch):
    runs = {name: suite.runs(True)[name] for name in ("lattice", "jitter_0.2")}
    monkeypatch.setattr(suite, "runs", lambda quick: runs)
    monkeypatch.setattr(
        suite,
        "criteria",
        lambda quick: [at_most("lattice", 0.018, "l2", 1.5e-3), near("jitter_0.2", "lattice", 0.018, 0.15)],
    )
    return runs


def test_each_case_runs_once_with_its_config(fake_process, small_suite, capsys):
    seen, _ = fake_process
    assert verify.run(quick=True) is True
    assert seen == [{"name": name, **config} for name, config in small_suite.items()]
    output = capsys.readouterr().out
    assert output.count("pass |") == 2
    assert output.endswith("\n\n2 of 2 rows passed\n")


def test_a_failed_bound_fails_the_suite(fake_process, small_suite, capsys):
    fake_process[1]["jitter_0.2"] = 1.2e-3
    assert verify.run(quick=True) is False
    output = capsys.readouterr().out
    assert "FAIL |" in output
    assert output.endswith("\n1 of 2 rows passed; FAIL: jitter_0.2 l2 off lattice at t* = 0.018\n")


def test_a_diverged_run_fails_its_checks_and_says_why(fake_process, small_suite, capsys):
    fake_process[1]["jitter_0.2"] = "diverged: velocity of particle 7"
    assert verify.run(quick=True) is False
    output = capsys.readouterr().out
    assert "nan" in output
    assert "jitter_0.2 did not finish: diverged: velocity of particle 7" in output


def test_a_suite_with_a_folder_takes_finished_runs_from_there(fake_process, small_suite, monkeypatch, tmp_path, capsys):
    seen, l2 = fake_process
    monkeypatch.setattr(suite, "one", lambda *chosen: (small_suite, suite.criteria(True)))
    assert verify.run_part("couette", quick=True, out=tmp_path / "kept") is True
    first = capsys.readouterr().out
    l2["lattice"] = 1.0  # were it run again it would fail
    assert verify.run_part("couette", quick=True, out=tmp_path / "kept") is True
    assert capsys.readouterr().out == first
    assert len(seen) == len(small_suite)
    assert verify.run_part("couette", quick=True) is False  # nothing is kept without one


def test_the_resistance_of_an_array_is_all_that_drives_its_cell():
    """Once the drag holds the drive on the liquid, the body and the falling pressure take up that on the whole cell."""
    (criterion,) = (one for one in suite.criteria(False) if one.runs == ("array_0.05",))
    config = suite.runs(False)["array_0.05"]
    (body,), drive = config["bodies"], config["drive"]["acceleration"]
    cell, viscosity = (
        config["geometry"]["length"] * config["geometry"]["height"],
        config["fluid"]["kinematic_viscosity"],
    )
    drag = config["fluid"]["density"] * drive * (cell - math.pi * body["radius"] ** 2)
    sample = {"t": config["time"]["end"], "drag": drag, "superficial_velocity": 0.5}
    result = Result(Path(), {"status": "done", "samples": [sample]})
    expected = drive * cell / (viscosity * 0.5)
    assert criterion.judge(result).value == pytest.approx(abs(expected / suite.bodies.RESISTANCES[0.05] - 1), rel=1e-12)
