"""Faults put in on purpose: each is named with its size; what cannot be told apart is said to be so."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from couette import couette_text

from tisph import scenes
from tisph.assessment import alignment, diagnosis, judge
from tisph.config import load
from tisph.exact import couette

CONFIGS = Path(__file__).parents[2] / "configs"

FACTORS = (0.95, 3.0)

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


SPACING = 0.05
NU, U, G = 0.01, 0.5, 0.02
HEIGHTS = (np.arange(20) + 0.5) * SPACING
DRIVEN = (f"drive.acceleration={G}", "walls.top.velocity=0")


@pytest.fixture
def scene(loader):
    """Return a function that makes the channel of the case with overrides."""
    changes = {"geometry": {"gap": 1.0, "length": 2.0}, "discretisation": {"particles_across": 20}, "time": {"end": 30}}
    config = loader(couette_text(**changes))
    return lambda *overrides: scenes.of(config(*overrides))


def start_up(y, t, gap=1.0, viscosity=NU, bottom=0.0, top=U):
    return couette.velocity(y, t, gap=gap, kinematic_viscosity=viscosity, bottom=bottom, top=top)


def found(scene, *flows):
    """Names of the faults that explain profiles (u, t), and the value of the first one."""
    aligned = [alignment.align({"y": HEIGHTS, "u": u}, scene, t) for u, t in flows]
    result = diagnosis.diagnose(aligned)
    return {each.fault.name for each in result.explaining}, result.explaining[0] if result.explaining else None


def noise(seed=0):
    """Scatter of 1e-4 U, as a code without faults has it."""
    return 1e-4 * U * np.random.default_rng(seed).standard_normal(len(HEIGHTS))


def walls_off(outside):
    shift = outside * SPACING
    return lambda t: start_up(HEIGHTS + shift, t, gap=1.0 + 2 * shift)


LATE = (2.7, 20.0)
AT_START = 0.1 * U  # a uniform velocity, from which the walls differ by as much less
FAULTS = [
    # overrides, profile, times, names of the faults that explain it, value of the first one, tolerance, its words
    # scatter of 1e-4 U over u_y spacing = 0.03 U and more
    ((), walls_off(0.5), LATE, {"walls"}, 0.5, 0.01, "half a spacing outside"),
    ((), walls_off(-0.5), LATE, {"walls"}, -0.5, 0.01, "half a spacing inside"),
    (
        *(("walls.bottom.velocity=0.2",), lambda t: start_up(HEIGHTS - 0.5 * SPACING, t, bottom=0.2)),
        *((20.0,), {"shift"}, None, None, "too high"),
    ),
    # nothing else moves: all velocities are those of the wall times a factor
    ((), lambda t: start_up(HEIGHTS, t, top=0.95 * U), LATE, {"factor", "slip"}, -0.05, 2e-3, "0.95"),
    ((), lambda t: start_up(HEIGHTS, t + 0.5), (2.0, 6.0, 20.0), {"time"}, 0.5, 0.01, "later"),
    ((), lambda t: 0.9 * start_up(HEIGHTS, t) + 0.1 * U * HEIGHTS, LATE, {"start"}, 0.1, 2e-3, ""),
    (
        *((), lambda t: AT_START + start_up(HEIGHTS, t, bottom=-AT_START, top=U - AT_START)),
        *(LATE, {"uniform_start"}, 0.1, 2e-3, ""),
    ),
    ((), lambda t: -start_up(HEIGHTS, t), LATE, {"sign"}, None, None, "the velocities have the wrong sign"),
    ((), lambda t: start_up(HEIGHTS, t), (2.7,), set(), None, None, ""),
    # a flow that none of the faults looks like
    ((), lambda t: start_up(HEIGHTS, t) + 0.05 * np.sin(9 * np.pi * HEIGHTS), (2.7,), set(), None, None, ""),
]


@pytest.mark.parametrize(("overrides", "profile", "times", "names", "value", "tolerance", "words"), FAULTS)
def test_a_fault_is_named_with_its_value(scene, overrides, profile, times, names, value, tolerance, words):
    found_names, first = found(scene(*overrides), *[(profile(t) + noise(), t) for t in times])
    assert found_names == names
    assert value is None or first.value == pytest.approx(value, abs=tolerance)
    assert first is None or all(word in first.words for word in words.split())


def test_one_wall_off_is_that_wall(scene):
    names, first = found(scene(), (start_up(HEIGHTS, 2.7, gap=1.0 + 0.5 * SPACING) + noise(), 2.7))
    assert "top_wall" in names  # at t* = 0.027 the bottom wall feels nothing yet: both or one, or a shift, are the same
    assert "bottom_wall" not in names
    assert first.value == pytest.approx(0.5, abs=0.01)


def test_in_developed_flow_slip_is_a_displaced_wall(scene):
    names, _ = found(scene("initial.state=developed"), (0.95 * U * HEIGHTS, 20.0))
    assert {"slip", "top_wall"} <= names
    length = 0.4 * SPACING
    flow = G / (2 * NU) * (HEIGHTS * (1 - HEIGHTS) + length)  # Navier: u = length du/dy on both walls
    names, first = found(scene(*DRIVEN, "initial.state=developed"), (flow, 20.0))
    assert "walls" in names
    assert first.value == pytest.approx(0.4, rel=0.05)  # the walls' displacement b adds b^2 to the parabola
    assert "slip length" in first.words


@pytest.mark.parametrize("factor", [0.5, 0.95, 1.1, 2.0])
def test_a_viscosity_off_by_a_factor_is_known_from_two_times(scene, factor):
    flows = [(start_up(HEIGHTS, t, viscosity=factor * NU) + noise(), t) for t in LATE]
    names, first = found(scene(), *flows)
    assert names == {"viscosity"}
    assert np.exp(first.value) == pytest.approx(factor, rel=5e-3)
    assert first.remain == pytest.approx(1e-4, rel=0.3)  # the scatter
    assert found(scene(), (start_up(HEIGHTS, 2.7 * 1.1), 2.7))[0] == {"viscosity", "time"}


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "mm/s"), (100.0, "cm/s"), (1e-3, "km/s")])
def test_velocities_in_another_unit(scene, factor, unit):
    names, first = found(scene(), *[(factor * (start_up(HEIGHTS, t) + 10 * noise()), t) for t in LATE])
    assert names == {"unit"}
    assert 1 + first.value == pytest.approx(factor, rel=2e-3)  # scatter of 1e-3 U
    assert f"--unit velocity={unit}" in first.words


def test_another_unit_of_a_fluid_whose_flows_do_not_superpose(scene):
    thinning = scene(
        "fluid.rheology={type: power_law, index: 0.5, reference_rate: 0.5, least_rate: 0.001}",
        "initial.state=developed",
    )
    assert not thinning.superposes
    names, _ = found(thinning, (1000.0 * U * HEIGHTS, 20.0))
    assert names == {"unit"}


def test_a_vortex_that_decays_too_fast():
    vortex = scene_of("taylor_green", "fluid.kinematic_viscosity=0.01", "discretisation.particles_across=12")
    x, y = vortex.lattice()
    decay = np.exp(-2 * 0.2 * NU * (2 * np.pi) ** 2)
    columns = {"x": x, "y": y, **{name: decay * vortex.exact(name, x, y, 1.0) for name in "uv"}}
    result = diagnosis.diagnose([alignment.align(columns, vortex, 1.0)])
    assert {each.fault.name for each in result.explaining} == {"factor", "viscosity", "time"}
    assert {each.fault.name: each.value for each in result.fits}["time"] == pytest.approx(0.2, rel=1e-3)


def test_data_of_a_lattice_are_judged_with_its_spacing():
    vortex = scene_of("taylor_green", "discretisation.refine=[{at: [0.5, 0.5], spacing: 0.01}]")
    x, y = vortex.lattice()
    aligned = alignment.align({"x": x, "y": y, "u": 0 * x, "v": 0 * x}, vortex, 1.0)
    assert vortex.wanted_spacing.smallest == 0.01
    assert aligned.scene.wanted_spacing.smallest == pytest.approx(vortex.spacing)


def test_the_page(tmp_path):
    """A line through mid-gap that is 2 % and later 4 % too flat: walls half a spacing outside, and then a whole one."""
    y = (np.arange(50) + 0.5) / 50
    for t, slope in ((1.8, 0.49), (2.7, 0.48)):
        np.savetxt(tmp_path / f"{t}.csv", np.stack([y, 0.25 + slope * (y - 0.5)], axis=1), header="y u")
    files = [tmp_path / "1.8.csv", tmp_path / "2.7.csv"]
    config = load(CONFIGS / "vm_sph_001_developed.yaml")
    page = judge.judge(config, files, judge.Question(times=(1.8, 2.7)))
    assert [each.numbers["l2"] for each in page.samples] == pytest.approx([0.01, 0.02], rel=1e-3)
    assert page.samples[0].numbers["centreline"] == pytest.approx(0.25)
    assert "grows" in page.trends[0]
    assert not page.diagnoses["50 across"].explaining
    alone = page.diagnoses["50 across, t = 1.8 alone"].explaining
    assert {each.fault.name: each.value for each in alone}["walls"] == pytest.approx(0.51, abs=0.01)
