"""Checks of a suite: which numbers pass and which fail, and which entries are refused."""

import math
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from fake_runs import make_result

from tisph.config.yaml_text import dump, parse
from tisph.errors import ConfigError
from tisph.studies import checks, measures, suites
from tisph.studies.expressions import SuiteError, filled
from tisph.studies.processes import Result


def criterion(**entry):
    """The only criterion of an entry."""
    (found,) = checks.criteria(entry, {"a", "b", "c"})
    return found


def ended(*samples, folder=None):
    """A run that reached its end."""
    return Result(folder or Path(), {"status": "done", "samples": list(samples)})


def test_an_entry_is_a_criterion_for_each_run_time_and_number():
    entry = {"run": ["a", "b"], "t": [1.0, 2.0], "at_most": {"l2": [1e-3, 1e-4], "linf": 1e-2}}
    found = list(checks.criteria(entry, {"a", "b"}))
    assert [(one.case, one.quantity, one.bound) for one in found[:4]] == [
        ("a", "l2 at t = 1", "<= 0.001"),
        ("a", "l2 at t = 2", "<= 0.0001"),
        ("a", "linf at t = 1", "<= 0.01"),
        ("a", "linf at t = 2", "<= 0.01"),
    ]
    assert len(found) == 8


def with_sample(**numbers):
    result = make_result(t18=1e-3)
    result.summary["samples"][0] |= numbers
    return result


AT = {"run": "a", "t_star": 0.018}
NEAR = {**AT, "near": "b", "within": {"l2": 0.05}}
RATIO = {**AT, "over": "b", "at_most": {"l2": 0.5}}
ORDER = {"order": "l2", "runs": {"a": 25, "b": 50, "c": 100}, "t_star": 0.018, "at_least": 1.85}
OFF = {**AT, "off_exact": {"kinetic_energy": 0.05}}
ENDS = {"run": "a", "number": "drag", "expected": 10.0, "within": 0.2}
SHEAR = {"wall_shear_bottom": 0.1, "wall_shear_bottom_exact": 0.1, "wall_shear_top": 1.97, "wall_shear_top_exact": 2.0}
JUDGED = [
    # entry, runs, value, whether it passes
    ({**AT, "at_most": {"l2": 1.5e-3}}, [make_result(t18=1.5e-3)], 1.5e-3, True),
    ({**AT, "at_most": {"l2": 1.5e-3}}, [make_result(t18=1.51e-3)], 1.51e-3, False),
    ({**AT, "at_least": {"l2": 0.55}}, [make_result(t18=0.55)], 0.55, True),
    ({**AT, "at_least": {"l2": 0.55}}, [make_result(t18=0.549)], 0.549, False),
    ({**AT, "at_least": {"l2": 0.55}}, [make_result(t18=None)], math.nan, False),
    (OFF, [with_sample(kinetic_energy=0.11, kinetic_energy_exact=0.1)], 0.1, False),
    (OFF, [with_sample(kinetic_energy=0.09, kinetic_energy_exact=0.1)], 0.1, False),
    (OFF, [with_sample(kinetic_energy=0.104, kinetic_energy_exact=0.1)], 0.04, True),
    (OFF, [with_sample(kinetic_energy=None, kinetic_energy_exact=0.1)], math.nan, False),
    # transverse velocity is measured in wall speeds, wall shear by the larger stress
    ({**AT, "at_most": {"transverse": 1e-6}}, [make_result(speed=0.5, t18=0.0)], 2e-7, True),
    ({**AT, "at_most": {"wall_shear": 0.01}}, [with_sample(**SHEAR)], 0.015, False),
    *[(NEAR, [make_result(t18=each * 1e-3), make_result(t18=1e-3)], None, True) for each in (1.049, 0.951)],
    *[(NEAR, [make_result(t18=each * 1e-3), make_result(t18=1e-3)], None, False) for each in (1.051, 0.949)],
    (RATIO, [make_result(t18=0.5e-3), make_result(t18=1e-3)], 0.5, True),
    (RATIO, [make_result(t18=0.51e-3), make_result(t18=1e-3)], 0.51, False),
    (ORDER, [make_result(t18=3.0 * number**-1.9) for number in (25, 50, 100)], 1.9, True),
    (ORDER, [make_result(t18=3.0 * number**-1.8) for number in (25, 50, 100)], 1.8, False),
    (
        {"order": "drag", "runs": {"a": 25, "b": 50}, "expected": 2.0, "at_least": 2.9},
        *([ended({"drag": 2.0 * (1 + number**-3.0)}) for number in (25, 50)], 3.0, True),
    ),
    # only a run that reached its end ends at a value
    (ENDS, [ended({"drag": 5.0}, {"drag": 11.0})], 0.1, True),
    (ENDS, [Result(Path(), {"status": "diverged", "samples": [{"drag": 11.0}]})], math.nan, False),
]


@pytest.mark.parametrize(("entry", "runs", "value", "passed"), JUDGED)
def test_a_criterion_judges_its_runs(entry, runs, value, passed):
    check = criterion(**entry).judge(*runs)
    assert check.passed is passed
    assert value is None or check.value == pytest.approx(value, rel=1e-6, nan_ok=True)


def test_a_criterion_is_said_in_words():
    found = criterion(**AT, at_most={"l2": 1.5e-3})
    assert (found.case, found.quantity, found.bound) == ("a", "l2 at t* = 0.018", "<= 0.0015")
    assert criterion(**ENDS).quantity == "drag off 10"


@pytest.mark.parametrize("ours", [{}, {"t27": 1e-9}, {"t18": None}])
def test_a_run_without_the_number_fails(ours):
    """It stopped before the sample, or its velocities are not finite."""
    stopped, good = make_result(**ours), make_result(t18=1e-3)
    at, near = {"run": "a", "t_star": 0.018}, {"near": "b", "within": {"l2": 0.05}}
    order = {"order": "l2", "runs": {"a": 25, "b": 50}, "t_star": 0.018, "at_least": 1.0}
    for entry, results in (
        ({**at, "at_most": {"l2": 1.0}}, [stopped]),
        ({**at, **near}, [stopped, good]),
        ({**at, **near}, [good, stopped]),
        (order, [good, stopped]),
        ({**at, "over": "b", "at_most": {"l2": 0.5}}, [stopped, good]),
        ({"run": "a", "momentum_closes": 0.01}, [stopped]),
    ):
        check = criterion(**entry).judge(*results)
        assert math.isnan(check.value)
        assert not check.passed


@pytest.mark.parametrize(("closure", "passed"), [(0.01, True), (0.011, False), (None, False)])
def test_the_momentum_balance_closes_within_its_bound(closure, passed):
    result = make_result(t18=1e-3)
    result.summary["momentum"] = {"closure": closure}
    assert criterion(run="a", momentum_closes=0.01).judge(result).passed is passed


def test_a_number_is_arithmetic_of_the_numbers_of_sample_and_run():
    result = ended({"drag": 6.0, "angle": 0.0})
    result.summary["cost"] = {"steps": 40}
    found = criterion(run="a", number="2*hypot(3, 4)*cos(angle)/drag + cost.steps", called="sum", at_most=1.0)
    assert found.judge(result).value == pytest.approx(10 / 6 + 40, rel=1e-14)
    assert found.quantity == "sum"


@pytest.mark.parametrize("text", ["9**9**9**9", "1/(drag - 1)", "sqrt(-drag)", "(-drag)**0.5", "exp(1e9)"])
def test_a_number_without_a_value_fails_at_once(text):
    assert not criterion(run="a", number=text, at_most=1e300).judge(ended({"drag": 1.0})).passed


def test_a_number_that_no_sample_has_is_named():
    with pytest.raises(ConfigError, match="drga: no such number; nearest: drag"):
        criterion(run="a", at_most={"drga": 1.0}).judge(ended({"drag": 1.0}))


OTHER = ["__import__('os').getcwd()", "drag.__class__.__mro__", "(lambda: 1)()", "[1][0]", "'a'", "drag if 1 else 2"]


@pytest.mark.parametrize("text", [*OTHER, "open(drag)", "1 +"])
def test_a_number_is_nothing_but_arithmetic(text):
    """Other Python is refused when the suite is read, or when its names are looked up as numbers."""
    with pytest.raises((SuiteError, ConfigError)):
        criterion(run="a", number=text, at_most=1.0).judge(ended({"drag": 1.0}))


MISTAKES = parse((Path(__file__).parent / "data" / "mistakes.yaml").read_text(encoding="utf-8")).data["checks"]


@pytest.mark.parametrize(("entry", "key", "message"), MISTAKES)
def test_a_mistake_names_its_key(entry, key, message):
    with pytest.raises(SuiteError, match=message) as raised:
        list(checks.criteria(entry, {"a", "b", "c"}))
    assert raised.value.key == key


def make_samples(folder, u, v=0.0):
    """A results folder with one sample of three particles."""
    folder.mkdir()
    with h5py.File(folder / "samples.h5", "w") as file:
        group = file.create_group("sample_000")
        group["x"] = np.array([0.1, 0.2, 0.3])
        group["u"] = np.array([0.0, 1.0, 2.0]) + u
        group["v"] = np.full(3, v)
    return folder


def test_velocities_are_compared_in_wall_speeds(tmp_path):
    reference = make_result(make_samples(tmp_path / "a", 0.0), speed=0.5)
    shifted = make_result(make_samples(tmp_path / "b", 1e-7), speed=0.5)
    transverse = make_result(make_samples(tmp_path / "c", 0.0, v=-1e-6), speed=0.5)
    found = criterion(run="a", same_velocities_as="b", within=1e-6)
    assert found.judge(shifted, reference).value == pytest.approx(2e-7, rel=1e-6)
    assert found.judge(shifted, reference).passed
    assert found.judge(transverse, reference).value == pytest.approx(2e-6, rel=1e-6)
    assert not found.judge(transverse, reference).passed


def test_one_bit_makes_a_difference(tmp_path):
    reference = make_result(make_samples(tmp_path / "a", 0.0))
    found = criterion(run="a", same_bits_as="b")
    assert found.judge(make_result(make_samples(tmp_path / "b", 0.0)), reference).passed
    one_bit = make_result(make_samples(tmp_path / "c", np.array([0.0, 2.3e-16, 0.0])))
    signed_zero = make_result(make_samples(tmp_path / "d", 0.0, v=-0.0))
    for different in (one_bit, signed_zero):
        assert found.judge(different, reference).value == 1
        assert not found.judge(different, reference).passed


def test_missing_arrays_are_not_equal_arrays(tmp_path):
    for entry in ({"same_bits_as": "b"}, {"same_velocities_as": "b", "within": 1e-6}):
        nothing = make_result(tmp_path / "nothing")
        assert not criterion(run="a", **entry).judge(nothing, nothing).passed


def with_bodies(samples, **fields):
    """A finished run whose bodies had these fields at its samples."""
    result = ended(*samples)
    object.__setattr__(result, "bodies", lambda field: np.array(fields[field], dtype=float))
    return result


def test_the_second_of_a_pair_mirrors_the_first():
    expected = {"field": "velocity", "expected": [0.09, 0.001], "scale": 0.09}
    mirrored = with_bodies([{}], velocity=[[[0.09, 0.001], [-0.09, -0.001]]])
    assert measures.pair_off(mirrored, **expected) == pytest.approx(0.0, abs=1e-15)
    assert measures.pair_off(with_bodies([{}], velocity=[[[0.09, 0.001]] * 2]), **expected) > 1.0


@pytest.mark.parametrize("factor", [1.0, 1.01])
def test_momentum_that_a_body_loses_is_found(factor):
    """Constant net forces on both, and velocities by them or 1 % more."""
    times, density, load = np.linspace(0.06, 6.0, 100), 3.0, 0.02
    area = math.pi * 0.1**2
    net = 0.25 * load * np.array([1.0, -1.0])
    force = np.tile(np.stack([net - [load, -load], [0.0, 0.0]], axis=1), (100, 1, 1))
    velocity = np.zeros((100, 2, 2))
    velocity[..., 0] = factor * times[:, None] * net / (density * area)
    run = with_bodies([{"t": time, "superficial_velocity": 0.0} for time in times], velocity=velocity, force=force)
    off = measures.momentum_of_bodies(run, density=density, area=area, loads=[load, -load], first=20)
    assert off == pytest.approx(0.25 * (factor - 1), abs=1e-12)
    assert measures.momentum_of_all(run, density=density, area=area, load=load) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("factor", [1.0, 1.01])
def test_momentum_that_is_lost_in_a_cell_is_found(factor):
    """A drag that is 1 % too large, on a liquid that is driven by what its momentum says."""
    drive, times = 400.0, [0.0, 0.1, 0.2, 0.4, 0.6]
    samples = [{"t": t, "superficial_velocity": 0.5 * drive * t, "drag": 0.5 * factor * drive} for t in times]
    off = measures.momentum_off(ended(*samples), drive=drive)
    assert off == pytest.approx(0.5 * (factor - 1), abs=1e-9)


def test_critical_value_is_where_the_rate_is_zero():
    at = [0.95, 1.0, 1.05]
    exact = [ended({"growth_rate": 0.3 * e - 0.5 * e**2}) for e in np.subtract(at, 1.0)]
    assert measures.critical_value(*exact, at=at, expected=68.0) == pytest.approx(0.0, abs=1e-12)
    off = [ended({"growth_rate": 0.3 * (part - 1.003)}) for part in at]
    assert measures.critical_value(*off, at=at, expected=68.0) == pytest.approx(3e-3, rel=1e-6)


def test_the_largest_of_all_samples_and_the_time_of_a_value():
    falling = [ended(*({"t": t, "y": 4.0 - speed * t} for t in (0.0, 1.0, 2.0))) for speed in (1.0, 1.25)]
    assert measures.largest(falling[0], number="y - 4") == 2.0
    assert measures.largest(falling[0], number="y", off=[4.0, 3.5, 2.0]) == 0.5
    assert measures.time_difference(*falling, number="y", value=3.0) == pytest.approx(0.25, rel=1e-12)


def test_expressions_in_a_config_are_replaced_by_their_values():
    names = {"nu": 1 / 3, "force": "=2*nu", "body": {"radius": "=size/2"}, "size": 0.5, "across": 25, "kind": "pipe"}
    template = {"drive": [0.0, "=-force"], "body": "=body", "across": "=across", "scene": "=kind", "video": None}
    assert filled(template, names) == {
        "drive": [0.0, -0.666666666667],  # twelve digits
        "body": {"radius": 0.25},
        "across": 25,
        "scene": "pipe",
        "video": None,
    }
    assert filled({"points": {"repeat": 3, "each": ["=k*size", 1.0]}}, names) == {
        "points": [[0.0, 1.0], [0.5, 1.0], [1.0, 1.0]]
    }
    with pytest.raises(SuiteError, match="the functions are"):
        filled({"drive": "=open(nu)"}, names)


@pytest.mark.parametrize(("stated", "passed"), [(3.1e-3, False), (2.9e-3, True), (3.4e-4, True), (3.2e-4, False)])
def test_a_stated_error_is_judged_beside_the_true_one_at_each_time(stated, passed):
    entry = {"run": "a", "t": [0.5, 1.0], "measure": "stated_error", "with": {"field": "pressure"}, "within_factor": 3}
    estimates = [{"fields": {"pressure": {"error": error}}} for error in (5e-4, stated)]
    run = ended({"t": 0.5, "l2_pressure": 5e-4}, {"t": 1.0, "l2_pressure": 1e-3})
    run.summary["error_estimate"] = {"samples": estimates}
    first, second = (one.judge(run) for one in checks.criteria(entry, {"a"}))
    assert (first.passed, first.value, first.bound) == (True, 1.0, "1/3 to 3")
    assert (second.passed, second.quantity) == (passed, "stated error at t = 1")


def test_without_an_estimate_no_stated_error_passes():
    found = criterion(run="a", t=0.5, measure="stated_error", **{"with": {"field": "velocity"}}, within_factor=3)
    run = ended({"t": 0.5, "l2": 1e-3})
    run.summary["error_estimate"] = {"reason": "a coarser run did not finish"}
    assert not found.judge(run).passed


def test_without_an_exact_solution_a_finer_run_gives_the_true_error(tmp_path):
    """The velocity is constant on both lattices, a tenth larger on the coarser one."""
    finer, ours = (tmp_path / name for name in ("finer", "ours"))
    config = {"name": "box", **suites.config_of("two_dimensional", "taylor_green")}
    for folder, across, u in ((ours, 12, 1.1), (finer, 24, 1.0)):
        folder.mkdir()
        (folder / "config.resolved.yaml").write_text(dump({**config, "discretisation": {"particles_across": across}}))
        x, y = (np.arange(across**2) % across + 0.5) / across, (np.arange(across**2) // across + 0.5) / across
        with h5py.File(folder / "samples.h5", "w") as file:
            group = file.create_group("sample_000")
            group.attrs["t"], group.attrs["step"] = 0.5, 1
            group["x"], group["y"], group["u"], group["v"] = x, y, np.full_like(x, u), np.zeros_like(x)
            group["density"] = group["pressure"] = np.ones_like(x)
    summary = {"samples": [{"t": 0.5}], "error_estimate": {"samples": [{"fields": {"velocity": {"error": 0.05}}}]}}
    found = measures.stated_error(Result(ours, summary), Result(finer, {}), field="velocity", t=0.5)
    assert found == pytest.approx(0.5, rel=1e-9)


def test_measures_of_histories_are_those_of_a_wave(tmp_path, monkeypatch):
    """Drag 3 + 0.1 cos(2 w t), lift 0.2 + sin(w t) at 400 times of ten periods, from t = 1 on."""
    t = np.linspace(0.0, 11.0, 400)
    history = {"t": t, "lift": 0.2 + np.sin(2 * np.pi * t), "drag": 3.0 + 0.1 * np.cos(4 * np.pi * t)}
    history["drag"][0] = np.nan
    monkeypatch.setattr(measures, "open_run", lambda folder: SimpleNamespace(history=history))
    run = Result(tmp_path, {"status": "done", "samples": []})
    assert measures.frequency(run, number="lift", since=1.0) == pytest.approx(1.0, rel=1e-4)  # chords between times
    assert math.isnan(measures.frequency(run, number="t", since=1.0))
    assert measures.crest(run, number="drag", since=1.0, harmonics=2) == pytest.approx(3.1, rel=1e-4)
    assert measures.mean_of_history(run, number="drag", since=1.0) == pytest.approx(3.0, rel=1e-3)
    assert measures.mean_off(run, run, number="drag", since=1.0) == 0.0
    assert measures.peak(run, number="lift", between=[1.15, 1.35]) == pytest.approx(1.2, rel=1e-3)
    assert measures.peak(run, number="lift", between=[1.15, 1.35], when=True) == pytest.approx(1.25, abs=1e-3)


def test_means_of_particles_are_compared_sample_by_sample(monkeypatch):
    """A stress of 3 (0.4 sin t + 0.5 cos t) + its third harmonic on average, over half a period."""
    t = np.pi * np.arange(8) / 8
    stress = 3.0 * (0.4 * np.sin(t) + 0.5 * np.cos(t)) + 0.2 * np.cos(3.0 * t)
    arrays = {f"sample_{k:03d}/stress_xy": value + np.array([-1.0, 1.0]) for k, value in enumerate(stress)}
    monkeypatch.setattr(Result, "arrays", lambda self: arrays)
    run = ended(*({"t": time} for time in t))
    assert measures.particles_off(run, number="2*stress_xy", expected=[3.4, *7 * [None]]) == pytest.approx(
        0.0, abs=1e-12
    )
    assert measures.particles_off(run, number="stress_xy", expected=[*7 * [None], 1.01 * stress[7]]) > 9e-3
    assert measures.mean_of_particles(run, number="stress_xy") == pytest.approx(stress.mean())
    given = {"number": "stress_xy", "amplitude": 3.0}
    assert measures.modulus_off(run, **given, expected=[0.4, 0.5]) == pytest.approx(0.0, abs=1e-12)
    assert measures.modulus_off(run, **given, expected=[0.41, 0.5]) == pytest.approx(0.02)


def test_a_mode_has_the_rate_and_frequency_of_its_energy(tmp_path, monkeypatch):
    t = np.linspace(0.0, 100.0, 400)
    history = {"t": t, "energy": 1e-9 * np.exp(0.02 * t) * (2.0 + np.cos(0.4 * t + 0.3))}
    monkeypatch.setattr(measures, "open_run", lambda folder: SimpleNamespace(history=history))
    run, given = Result(tmp_path, {"status": "done", "samples": []}), {"number": "energy", "since": 20.0}
    assert measures.mode_off(run, **given, rate=0.01, frequency=0.2) == pytest.approx(0.0, abs=1e-8)
    assert measures.mode_off(run, **given, rate=0.02, frequency=0.2) == pytest.approx(0.05)
    assert measures.mode_off(run, **given, rate=0.01, frequency=0.21) == pytest.approx(0.01 / 0.21)


def test_the_limit_of_a_number_is_linear_in_its_parameter():
    runs = [ended({"y": 3.0 + 0.4}), ended({"y": 3.0 + 0.2})]
    assert measures.limit(*runs, number="y") == pytest.approx(3.0)
