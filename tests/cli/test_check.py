"""tisph check of all flows: numbers, limits of the time step, warnings, and the errors that it states."""

import functools
import json
import math
import re
from pathlib import Path

import estimates as study
import pytest
from typer.testing import CliRunner

from tisph import cli, scenes
from tisph.config import load
from tisph.schemes import resolve
from tisph.schemes._estimate import off_layers
from tisph.schemes._forecast import estimates
from tisph.schemes._protocol import SampleEstimate
from tisph.schemes.wcsph.equation_of_state import Tait, sound_speed
from tisph.studies import stability as matrix
from tisph.studies.stability import flow_of
from tisph.studies.store import config_text

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
CONFIG = """\
scene: channel
units: {length: cm, mass: g, time: s}
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
scheme: {type: wcsph}
time: {end: 2.0}
"""
AT_REST = "walls.top.velocity=0"
DRIVE = "drive.acceleration=-0.02"
POLYMER = "fluid={density: 1.0, kinematic_viscosity: 1.0, rheology: {type: oldroyd_b, relaxation_time: %s, %s}}"


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(CONFIG)
    return path


@pytest.fixture
def checked(case):
    """Return the lines that ``tisph check`` prints for CONFIG with overrides."""

    def run(*overrides):
        options = [part for override in overrides for part in ("--set", override)]
        result = CliRunner().invoke(cli.app, ["check", str(case), *options])
        assert result.exit_code == 0, result.output
        return [" ".join(line.split()) for line in result.stdout.splitlines()]

    return run


def starting(lines, *wanted):
    return [line for line in lines if line.startswith(wanted)]


# U dx / nu by hand: 0.5 * 0.02 / nu, of the solvent's viscosity where there is polymer
@pytest.mark.parametrize(
    ("override", "number"),
    [
        ("fluid.kinematic_viscosity=1.7e-4", None),  # 58.8
        ("fluid.kinematic_viscosity=1.6e-4", "62.5; above 60"),
        (POLYMER.replace("viscosity: 1.0", "viscosity: 0.01") % (1.0, "solvent_fraction: 0.11"), None),  # 9.1
        (POLYMER.replace("viscosity: 1.0", "viscosity: 0.008") % (1.0, "solvent_fraction: 0.1"), "12.5; above 10"),
    ],
)
def test_a_high_cell_reynolds_number_is_warned_of(checked, override, number):
    warnings = [line for line in checked(override) if "cell Reynolds number" in line]
    assert len(warnings) == (number is not None)
    assert all(f"is {number} " in line for line in warnings)


@pytest.mark.parametrize(("viscosity", "warned"), [(2.6e-5, False), (2.4e-5, True)])  # 385 and 417
def test_the_implicit_scheme_bears_more(checked, viscosity, warned):
    lines = checked(f"fluid.kinematic_viscosity={viscosity}", "scheme={type: implicit}", "time.end=1e4")
    assert len([line for line in lines if "417; above 400" in line]) == len(starting(lines, "warning")) == warned


@pytest.mark.parametrize(("order", "jitter", "warned"), [(2, 0.1, True), (2, 0.0, False), (4, 0.1, False)])
def test_order_2_is_warned_of_in_disorder(checked, order, jitter, warned):
    scheme = f"scheme={{type: implicit, operators: {{order: {order}}}}}"
    slow = "fluid.kinematic_viscosity=0.02"  # cell Reynolds number 0.5
    lines = checked(scheme, f"initial.jitter={jitter}", "fluid.kinematic_viscosity=0.005")
    assert len([line for line in lines if "take order 4" in line]) == len(starting(lines, "warning")) == warned
    assert not starting(checked(scheme, f"initial.jitter={jitter}", slow), "warning")


@pytest.mark.parametrize(("end", "warned"), [(0.4, False), (0.004, True)])  # the layer's depth: 3.2 and 0.3 spacings
def test_a_large_error_is_warned_of(case, checked, end, warned):
    run = ("scheme={type: implicit}", f"time.end={end}")
    stated = estimates(load(case, run))["samples"][-1].l2
    text = f"warning: the L2 error at the last sample, t = {end}, may be as large as {stated:.1g}"
    assert [line for line in checked(*run) if "may be as large" in line] == [text] * warned


def test_a_start_that_the_explicit_scheme_mixes_away_is_refused(case):
    """Cell Reynolds number 1000; the implicit scheme takes it, and the explicit one a later sample."""
    thin = ["--set", "fluid.kinematic_viscosity=1e-5"]
    refusal = CliRunner().invoke(cli.app, ["check", str(case), *thin])
    assert refusal.exit_code == 2
    assert "cell Reynolds number U spacing / nu is 1e+03" in refusal.stderr
    assert "scheme implicit" in refusal.stderr
    for more in ("scheme={type: implicit}", "time.end=2e4"):
        assert CliRunner().invoke(cli.app, ["check", str(case), *thin, "--set", more]).exit_code == 0


def test_driven_flow(checked):
    lines = checked(AT_REST, DRIVE)
    # by hand: g H^2 / (12 nu) = 1/6, times H / nu
    assert "mean speed U 0.166667 cm/s" in lines
    assert "Reynolds number 16.6667 (U H / nu)" in lines
    drive = "drive -0.02 cm/s^2 along x, of which the developed flow has the mean speed -0.166667 cm/s"
    assert drive in lines
    # the walls are faster than the mean speed, but the peak counts for the sound speed
    assert {"wall speed U 0.5 cm/s", "sound speed c 7.5 cm/s", drive} <= set(checked(DRIVE))


@pytest.mark.parametrize(("name", "mean"), [("power_law_poiseuille", 0.5), ("bingham_poiseuille", 0.11733)])
def test_mean_speed_of_the_developed_flow_is_of_the_fluid_itself(name, mean):
    """By hand, see ``test_mean_velocity_between_plates``; regularised to 1e-3. Newtonian: 0.3333 and 0.1667."""
    output = CliRunner().invoke(cli.app, ["check", str(CONFIGS / f"{name}.yaml")]).output
    (drive,) = starting([line.strip() for line in output.splitlines()], "drive")
    assert float(drive.split()[-2]) == pytest.approx(mean, rel=1e-3)
    assert "in a Newtonian fluid of the viscosity nu" in output


def test_no_mean_speed_is_stated_where_walls_have_a_part_in_it(checked):
    thinning = "fluid.rheology={type: power_law, index: 0.5, reference_rate: 1.0, least_rate: 0.01}"
    for other in (["walls.bottom={shear_stress: 0.01}", "walls.top.velocity=0"], [thinning]):
        (drive,) = starting(checked(DRIVE, "scheme.type=auto", *other), "drive")
        assert drive == "drive -0.02 cm/s^2 along x"


def test_every_config_names_the_length_of_its_reynolds_number():
    """With its value, or with the word for a value that stands on another line."""
    for path in sorted(CONFIGS.glob("*.yaml")):
        lines = dict(scenes.of(load(path)).parameters())
        letter = re.search(r"\(U (\w) / nu", lines["Reynolds number"])[1]
        named = [text for label, text in lines.items() if label.split()[-1] == letter]
        assert named or f", {letter} the " in lines["Reynolds number"], path


def test_only_what_no_run_can_change_is_called_resolved(case):
    """The run judges divergence, and free bodies move: samples of suspension.yaml are not resolved for their gaps."""
    assert estimates(load(case, ["time.samples=[1e-4, 2.0]"]))["resolved"] == [False, True]
    two_dimensional = "drafting_kissing_tumbling", "cavity", "confined_cylinder_oldroyd_b", "circular_couette"
    for name in ("suspension", *two_dimensional):
        numbers = estimates(load(CONFIGS / f"{name}.yaml"))
        assert numbers["resolved"] == [None] * len(numbers["samples"])


def test_the_getting_started_page_shows_what_the_command_prints():
    page = (CONFIGS.parent / "docs" / "getting-started.md").read_text(encoding="utf-8")
    shown = re.search(r"^```\n(  time step .*?)^```$", page, flags=re.MULTILINE | re.DOTALL)[1]
    assert shown in CliRunner().invoke(cli.app, ["check", str(CONFIGS / "cylinder_in_channel.yaml")]).output


@pytest.mark.parametrize(("name", "seconds"), [("couette", (5.3, 7.6, 19.8)), ("suspension", (37.1,))])
def test_the_time_of_a_run_has_all_its_parts(name, seconds):
    """Measured whole: with kernels compiled before, new ones, beside others; of a suspension a quarter of the run."""
    least, most = estimates(load(CONFIGS / f"{name}.yaml"))["total_time_range"]
    assert all(least < each < most for each in seconds)


# sqrt(2 * 0.01 / w) over the spacing 0.02: 5 spacings for w = 2, 3.9 for w = 3.3
@pytest.mark.parametrize(("frequency", "depth", "spacings"), [(2.0, "0.1 cm", "5"), (3.3, "0.07785 cm", "3.89")])
def test_penetration_depth(checked, frequency, depth, spacings):
    lines = checked(f"walls.bottom={{amplitude: 0.1, angular_frequency: {frequency}}}")
    assert f"penetration depth {depth}, {spacings} spacings (sqrt(2 nu / w), bottom wall)" in lines
    thin = "warning: samples not resolved: 1 of 1; at t = 2 the layer at the oscillating bottom wall is 1.9 spacings"
    assert len(starting(lines, thin)) == len(starting(lines, "warning")) == (frequency == 3.3)


@pytest.mark.parametrize(("fraction", "warned"), [(0.1, False), (0.09, True)])
def test_polymer(checked, fraction, warned):
    lines = checked(POLYMER % (2.0, f"solvent_fraction: {fraction}"))
    assert "Weissenberg number 1 (relaxation time * U / H)" in lines
    assert "elasticity number 2 (relaxation time * nu / H^2)" in lines
    assert bool(starting(lines, "warning: fluid.rheology.solvent_fraction is below 0.1")) == warned


# modulus 0.9 / 1, (0.02 / 0.1)^2 times that, and with a hundredth of solvent (0.02 / 0.01)^2
@pytest.mark.parametrize(("fraction", "warned"), [(0.1, False), (0.01, False), (0.009, True)])
def test_polymer_that_relaxes_before_the_layer_is_one_spacing_thick(checked, fraction, warned):
    liquid = POLYMER % (1.0, f"solvent_fraction: {fraction}")
    lines = checked(liquid, "scheme={type: auto}", "time.end=0.1")
    assert bool(starting(lines, "warning: the polymer stress grows at an impulsively started wall")) == warned
    assert not starting(lines, "warning: fluid.rheology.solvent_fraction")


@pytest.mark.parametrize(("name", "known"), [("taylor_green", True), ("cavity_regular", False)])
def test_predicted_steps_of_an_unknown_flow_are_called_a_guess(name, known):
    output = CliRunner().invoke(cli.app, ["check", str(CONFIGS / f"{name}.yaml")]).output
    lines = [line.strip() for line in output.splitlines()]
    (steps,) = starting(lines, "steps")
    assert steps.endswith("; how the particles will flow is not known beforehand") == (not known)
    assert all(" to " in line for line in (steps, *starting(lines, "at t =")))


# Sound speed by hand, gap 1: ten times the largest of peak speed, sqrt(nu * peak speed) and sqrt(nu_p / relaxation
# time). h = 0.02; acoustic step 0.25 h / (sqrt(c^2 + c_e^2) + peak), viscous 0.125 h^2 / nu_s, relaxation time / 4
@pytest.mark.parametrize(
    ("overrides", "sound", "limit", "step"),
    [
        ([AT_REST, DRIVE], 2.5, "acoustic", 0.005 / 2.75),
        ([DRIVE], 7.5, "acoustic", 0.005 / 8.25),
        (["walls.top={velocity: 0, velocity_before: 0.6}", "initial.state=developed"], 6.0, "acoustic", 0.005 / 6.6),
        (["walls.top={amplitude: -0.6, angular_frequency: 1}"], 6.0, "acoustic", 0.005 / 6.6),
        ([POLYMER % (0.01, "solvent_fraction: 0.19")], 90.0, "acoustic", 0.005 / (math.hypot(90, 9) + 0.5)),
        ([POLYMER % (1.0, "solvent_fraction: 0.5")], 7.0710678118654755, "viscous", 5e-5 / 0.5),
        ([POLYMER % (1e-5, "solvent_fraction: 0.9")], 1000.0, "relaxation", 2.5e-6),
        ([POLYMER % (1e-5, "solvent_fraction: 1.0")], 7.0710678118654755, "viscous", 5e-5),
    ],
)
def test_sound_speed_and_time_step(case, overrides, sound, limit, step):
    numbers = estimates(load(case, overrides))
    assert numbers["sound_speed"] == pytest.approx(sound, rel=1e-14)  # a few roundings
    assert numbers["binding_limit"] == limit
    assert numbers["time_step"] == pytest.approx(step, rel=1e-14)


def test_a_given_sound_speed_knows_no_elastic_waves():
    numbers = {"reference_velocity": 1.0, "kinematic_viscosity": 1.0, "length": 1.0, "density": 1.0}
    assert sound_speed(Tait(sound_speed=3.0), elastic_speed=50.0, **numbers) == 3.0


STEPS = {"cavity": 1498, "eccentric_annulus": 160, "free_cylinder": 153, "settling_disc": 93, "sphere_in_tube": 72}


@pytest.mark.parametrize(("name", "taken"), [*STEPS.items(), ("taylor_vortices", 696), ("turned_box", 200)])
def test_steps_are_told_within_a_factor_of_two(name, taken):
    """They are 0.7 to 1.2 times those ``taken`` by whole runs on one thread."""
    assert 0.5 < estimates(load(CONFIGS / f"{name}.yaml"))["steps"] / taken < 2.0


def test_steps_without_inertia_have_no_start():
    """A run of the lattice takes 23 steps without inertia, and 138 with it."""
    numbers = estimates(load(CONFIGS / "cylinder_lattice.yaml", ["fluid.inertia=false"]))
    assert 0.5 < numbers["steps"] / 23 < 2.0


DATA = Path(__file__).parent / "data"
MEASURED = json.loads((DATA / "measured.json").read_text())
ALL_CELLS = json.loads((DATA / "cells.json").read_text())
CELLS = {cell.name: cell for quick in (True, False) for cell in matrix.cells(matrix.sub_matrices(quick))}

LONG = [f"configs-{name}" for name in ("small_amplitude_oscillation", "fene_p_couette", "step_strain", "flow_curve")]
LONG += ["configs-creep_and_recovery", "configs-two_mode_couette"]
"""What takes longest to forecast. Others have walls that oscillate (oscillating_wall_fast), plates that a stress drives
(ringing_plate) and polymers with solved references (giesekus_couette, ptt_poiseuille)."""


UNLIKE = {
    "configs-convection_rolls": "half the steps before rolls have grown",
    "configs-natural_convection": "a third of the steps: the fluid is slower than buoyancy alone would drive it",
    "configs-contraction": "pressure at open ends that scatters shortens the steps",
    "configs-segre_silberberg": "2.8 times as many steps",
    "configs-taylor_vortices": "at t = 10 there are no vortices yet: half the steps",
    "configs-wavy_pipe": "2.2 times as many steps: along the wave fluid goes faster and slower",
}
"""Runs whose steps are not within the stated reach, and why."""


@functools.cache
def of_config(name):
    """The numbers of a config that was measured, up to the end of its run, which several tests look at."""
    run = MEASURED[name]
    times = [sample["t"] for sample in run["samples"]]
    shorter = [f"time.end={run['end']}", f"time.samples={times}"]
    return estimates(load(CONFIGS / f"{name.removeprefix('configs-')}.yaml", shorter))


def stated(name, end, folder):
    """The numbers of a config, or of a cell to its ``end``."""
    if name.startswith("configs-"):
        return of_config(name)
    cell = CELLS[name]
    path = folder / "case.yaml"
    path.write_text(config_text(name, cell.config(end / flow_of(cell.flow).unit_time(cell.reynolds))))
    return estimates(load(path))


DONE = [name for name, run in MEASURED.items() if run["status"] == "done"]


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in DONE])
def test_predicted_errors_steps_and_resolution_are_those_of_runs(name, tmp_path):
    run = MEASURED[name]
    found = study.compare(stated(name, run["end"], tmp_path), run["samples"])
    assert [each for each in found if each.verdict == "FAIL"] == [] or name in UNLIKE


def test_every_sample_of_a_cell_has_its_forecast(tmp_path):
    case = next(case for case in study._cells(tmp_path, quick=True) if case.refusal is None)
    samples = case.numbers["samples"]
    assert [sample.t for sample in samples] == pytest.approx(case.config["time"]["samples"], rel=1e-12)
    assert len(samples) > 1


def test_every_config_is_measured_and_implicit_ones_of_channels_have_an_error():
    """But for one whose run takes ten minutes; README prints its error, 3e-14. Of long ones the beginning is."""
    configs = {f"configs-{path.stem}": load(path) for path in CONFIGS.glob("*.yaml")}
    assert configs.keys() - MEASURED.keys() == {"configs-vm_sph_001_as_printed"}
    for name, config in configs.items():
        if not config.parallel or name in LONG or name not in MEASURED:
            continue
        without = off_layers(config) or config.temperature or resolve(config)[0].scheme.type == "wcsph"
        assert all((sample.rms is None) == bool(without) for sample in of_config(name)["samples"])


DEVELOPED_OR_DECAYING = (
    "annulus0.5-re100-j0-n12-imp4-t3",
    "taylor_green-re1-j0-n25-imp4-t2",
    "taylor_green-re100-j0-n25-imp4-t20",
)
"""Cells of flows that no configs have: steady from the start, and vortices of which next to nothing is left."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in DEVELOPED_OR_DECAYING else [pytest.mark.slow]) for name in ALL_CELLS],
)
def test_all_cells_are_within_the_factors(name, tmp_path):
    found = study.compare(stated(name, ALL_CELLS[name]["end"], tmp_path), ALL_CELLS[name]["samples"])
    assert [each for each in found if each.verdict == "FAIL"] == []


@pytest.mark.slow
def test_runs_of_today_are_within_the_factors(tmp_path):
    assert study.run(tmp_path, processes=2, quick=True)


def sample(rms=1e-3, step=10, resolved=True):
    return {"t": 1.0, "step": step, "rms": rms, "resolved": resolved}


def numbers_of(*samples, resolved=None):
    return {"samples": samples, "resolved": [resolved] * len(samples), "total_time_range": (3.0, 20.0)}


def forecast_of(rms=1e-3, **others):
    return SampleEstimate(**{"t": 1.0, "steps": 10, "l2": rms, "rms": rms, **others})


@pytest.mark.parametrize(
    ("one", "found", "verdict"),
    [
        # a sample that is not resolved must not be called so
        *[({"said": said}, {"resolved": False}, verdict) for said, verdict in ((True, "FAIL"), (False, "pass"))],
        ({}, {"rms": 2.9e-3}, "pass"),
        ({}, {"rms": 3.1e-3}, "FAIL"),
        ({}, {"rms": 0.32e-3}, "FAIL"),
        ({}, {"rms": 0.35e-3}, "pass"),
        ({"at_most": True}, {"rms": 1e-9}, "pass"),
        ({"at_most": True}, {"rms": 3.1e-3}, "FAIL"),
        ({}, {"rms": 9e-3, "resolved": False}, "pass"),
        ({}, {"rms": 11e-3, "resolved": False}, "FAIL"),
        ({}, {"step": 11}, "FAIL"),
        ({"steps_factors": (0.7, 1.5)}, {"step": 15}, "pass"),
        ({"steps_factors": (0.7, 1.5)}, {"step": 16}, "FAIL"),
        ({"steps_factors": (0.7, 1.5)}, {"step": 6}, "FAIL"),
        ({"rms": None}, {"rms": 1.0}, "no estimate"),
        ({"rms": None}, {"step": 100}, "FAIL"),
    ],
)
def test_verdicts(one, found, verdict):
    estimate = {key: value for key, value in one.items() if key != "said"}
    (comparison,) = study.compare(numbers_of(forecast_of(**estimate), resolved=one.get("said")), [sample(**found)])
    assert comparison.verdict == verdict


def test_a_case_has_the_verdict_of_its_worst_sample():
    case = study.Case("two", {}, numbers_of(forecast_of(), forecast_of(t=2.0, steps=20)))
    for factor, verdict in ((2.0, "pass"), (10.0, "FAIL")):
        samples = [sample(), {**sample(rms=factor * 1e-3, step=20), "t": 2.0}]
        summary = {"status": "done", "samples": samples, "cost": {"wall_total_s": 12.3}}
        assert study._line(case, summary)[0] == verdict
