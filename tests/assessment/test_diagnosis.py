"""What ``tisph compare`` says of a wrong result is true: the fault that was put in, or its equals, or none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tisph import scenes
from tisph.assessment import alignment, diagnosis
from tisph.config import load

CONFIGS = Path(__file__).parents[2] / "configs"

FACTORS = (0.25, 0.95, 3.0)

TIMES = (0.02, 0.15, 2.0)
"""t* from a layer of three spacings to developed flow."""


def scene_of(name, *overrides):
    return scenes.of(load(CONFIGS / f"{name}.yaml", overrides))


def heights(scene):
    return (np.arange(25) + 0.5) / 25 * scene.gap


def findings(scene, flow, *times, scatter=0.0):
    """Faults by name that explain profiles ``flow(y, t)``, and their values, of the smallest remaining error of all."""
    y, random = heights(scene), np.random.default_rng(1)
    noise = [scatter * scene.reference_velocity * random.standard_normal(len(y)) for _ in times]
    data = [{"y": y, "u": flow(y, t) + more} for t, more in zip(times, noise, strict=True)]
    aligned = [alignment._between_walls(each, scene, t, None, None) for each, t in zip(data, times, strict=True)]
    assert not any(each.notes for each in aligned)
    found = diagnosis.diagnose(aligned)
    if found.fits:
        least = min(each.remain for each in found.fits)
        for each in found.explaining:
            assert each.remain <= 1.05 * least + 1e-8  # none that leaves more error than another one
    return {each.fault.name: each.value for each in found.explaining}


def samples(scene):
    """Each of ``TIMES`` in units of the viscous time alone, and all together."""
    times = [t * scene.viscous_time for t in TIMES]
    return [*[(t,) for t in times], tuple(times)]


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(("name", "equals"), [("couette", {"factor", "slip"}), ("poiseuille", {"factor", "drive"})])
def test_a_plain_factor_is_named_as_one(name, equals, factor):
    scene = scene_of(name)
    for times in samples(scene):
        for scatter in (0.0, 1e-4)[len(times) > 1 :]:
            found = findings(scene, lambda y, t: factor * scene.exact("u", y, y, t), *times, scatter=scatter)
            developed = min(times) > scene.viscous_time
            # a developed flow along one moving wall is also that of a gap, a driven one that of a viscosity
            others = (
                ({"top_wall", "start"} if name == "couette" else {"viscosity", "uniform_start"}) if developed else ()
            )
            assert "factor" in found, (factor, times)
            assert found.keys() <= equals.union(others), (factor, times)
            assert 1 + found["factor"] == pytest.approx(factor, abs=30 * scatter + 1e-9)


@pytest.mark.parametrize("width", [0.9, 2.0])
@pytest.mark.parametrize("name", ["couette", "poiseuille"])
def test_a_gap_that_is_wrong_is_named_or_nothing_is(name, width):
    scene = scene_of(name)
    other = diagnosis.exact(replace(scene, gap=width * scene.gap))
    for times in samples(scene):
        found = findings(scene, lambda y, t: other("u", width * y, width * y, t), *times)
        developed = min(times) > scene.viscous_time
        equals = {"viscosity", "time"} if name == "couette" and len(times) == 1 else {"viscosity"}
        if developed and name != "couette":
            equals |= {"factor", "drive"}  # u = g H^2 / (8 nu) at mid-gap
        assert found.keys() <= equals, times
        if "viscosity" in found:
            assert np.exp(-0.5 * found["viscosity"]) == pytest.approx(width, rel=1e-4)


def test_a_viscosity_is_said_with_the_gap_of_the_same_flow():
    scene = scene_of("poiseuille")
    other = diagnosis.exact(replace(scene, gap=1.25 * scene.gap))
    t = 0.15 * scene.viscous_time
    aligned = alignment.align({"y": heights(scene), "u": other("u", 0, 1.25 * heights(scene), t)}, scene, t)
    (found,) = diagnosis.diagnose([aligned]).explaining
    assert "the viscosity is 0.64 times" in found.words
    assert "the gap 1.25 times as wide" in found.words


@pytest.mark.parametrize("peak_for_mean", [2 / 3, 1.5])
def test_a_mean_velocity_taken_for_the_peak_is_a_factor(peak_for_mean):
    scene = scene_of("poiseuille", "initial.state=developed")
    found = findings(scene, lambda y, t: peak_for_mean * scene.exact("u", y, y, t), 2.0, 10.0)
    assert 1 + found["factor"] == pytest.approx(peak_for_mean)
    assert found.keys() <= {"factor", "drive", "viscosity"}


@pytest.mark.parametrize(
    "name", ["couette_poiseuille_favourable", "couette_poiseuille_backflow", "power_law_poiseuille"]
)
def test_half_the_drive_is_named_or_nothing_is(name):
    scene = scene_of(name)
    half = replace(scene, acceleration=0.5 * scene.acceleration)
    for times in samples(scene)[1:]:
        found = findings(scene, lambda y, t: half.exact("u", y, y, t), *times)
        if scene.superposes:
            developed = min(times) > scene.viscous_time  # where drive over viscosity counts
            assert {"drive"} <= found.keys() <= {"drive", *["viscosity"] * developed}, times
            assert 1 + found["drive"] == pytest.approx(0.5)
        else:  # the velocities fall as drive^(1/n), in developed flow by one factor
            assert found.keys() <= {"factor"}, times


@pytest.mark.parametrize("factor", [3.28084, 39.0, 12.0])
def test_a_factor_near_that_of_a_unit_is_no_unit(factor):
    scene = scene_of("poiseuille")
    found = findings(scene, lambda y, t: factor * scene.exact("u", y, y, t), 2.0, scatter=1e-4)
    assert found.keys() <= {"factor", "drive"}


def test_another_phase_of_vortices_is_an_origin_a_quarter_period_away():
    scene = scene_of("taylor_green")
    x, y = scene.lattice()
    k, decay = 2 * np.pi / scene.length, np.exp(-2 * scene.kinematic_viscosity * (2 * np.pi / scene.length) ** 2)
    data = {"x": x, "y": y, "u": decay * np.sin(k * x) * np.cos(k * y), "v": -decay * np.cos(k * x) * np.sin(k * y)}
    (found,) = diagnosis.diagnose([alignment.align(data, scene, 1.0)]).explaining
    assert "--origin 0.25,0.25" in found.words
    assert diagnosis.diagnose([alignment.align(data, scene, 1.0, origin=(0.25, 0.25))]).error < 1e-12  # round-off


SERIES = [
    ("couette_both_walls", ()),
    ("stopped_wall", ()),
    ("couette_poiseuille_backflow", ()),
    ("couette_poiseuille_backflow", ("initial.state=developed",)),
    ("oldroyd_b_couette", ()),
    ("oldroyd_b_poiseuille", ()),
]


@pytest.mark.parametrize(("name", "overrides"), SERIES)
def test_the_series_of_the_fits_is_the_reference(name, overrides):
    scene = scene_of(name, *overrides)
    y = np.linspace(0.0, scene.gap, 40)
    for t in (0.1, 0.5, 2.0):
        t = t * scene.viscous_time
        difference = diagnosis.exact(scene)("u", y, y, t) - scene.exact("u", y, y, t)
        # the numerical reference is good to 1e-8 of the largest velocity, the series of a polymer cut where it is, too
        assert np.abs(difference).max() < 3e-8 * scene.reference_velocity
