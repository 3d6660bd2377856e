"""Every flow with a reference, in every file that tisph writes of it, and with few points: the error that it has.

The states are the exact solution and a disturbance, at the times of the samples of each config; a run's own come last.
"""

import contextlib
import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tisph
from tisph import cli, scenes, simulation
from tisph.assessment import judge
from tisph.config import load
from tisph.config.loader import loaded
from tisph.errors import ConfigError
from tisph.exact.cavity import RegularCavity
from tisph.measures.metrics import sample_metrics
from tisph.observers.samples import Description, Samples
from tisph.results.export import FORMATS, export
from tisph.snapshot import Bodies, Snapshot

CONFIGS = {path.stem: path for path in sorted((Path(__file__).parents[2] / "configs").glob("*.yaml"))}
KNOWN = [name for name, path in CONFIGS.items() if {"u", "v"} & set(scenes.of(load(path)).fields)]
ERRORS = ("l2", "rms", "linf")
FEW = 12, 20, 25
"""Particles across: enough for a file; the first number that the length of a config allows."""


def coarse(path):
    """The config with few particles, and its scene."""
    for across in FEW:
        with contextlib.suppress(ConfigError):
            config = load(path, [f"discretisation.particles_across={across}", "discretisation.spacing=null"])
            return config, scenes.of(config)
    raise AssertionError(f"{path}: refuses {FEW} across")


def places(scene):
    """Places of the particles: displaced at random from a lattice, or, between curved walls, random ones."""
    if not scene.bodies:
        return scene.jittered(0, 0.2)
    points = scene.origin + scene.extent * np.random.default_rng(0).random((4 * scene.particles, 2))
    return points[scene.contains(points, scene.start_time)][: scene.particles].T


def state(scene, t):
    """The exact state, every field with a disturbance of 1e-3 of its size."""
    x, y = places(scene)
    rest = {"u": np.zeros_like(x), "v": np.zeros_like(x), "density": np.full_like(x, scene.density), "pressure": 0 * x}
    wave = np.sin(7 * x / scene.extent[0]) * np.cos(5 * y / scene.extent[1])
    exact = {name: scene.exact(name, x, y, t) for name in scene.fields}
    found = {
        name: field + 1e-3 * (index + 1) * np.abs(field).max() * wave
        for index, (name, field) in enumerate(exact.items())
    }
    bodies = Bodies.at(t, scene.bodies) if scene.bodies else None
    return Snapshot(t=t, step=1, x=x, y=y, **(rest | found), bodies=bodies)


@pytest.fixture
def undiagnosed(monkeypatch):
    """No faults are looked for: other tests do."""
    monkeypatch.setattr(judge, "_diagnoses", lambda series: {})


QUICK = ("couette", "couette_poiseuille_backflow", "oscillating_wall_fast", "oldroyd_b_couette", "creep_and_recovery")
QUICK += ("circular_couette", "circular_couette_oldroyd_b", "pipe", "spin_up", "taylor_green")
"""One config of each scene, kind of fields and motion of walls; the others are slow."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.slow]) for name in KNOWN]
)
def test_every_file_that_tisph_writes_has_the_error_of_the_run(tmp_path, undiagnosed, name):
    config, scene = coarse(CONFIGS[name])
    (tmp_path / "config.resolved.yaml").write_text(config.resolved_yaml())
    writer = Samples(tmp_path / "samples.h5", scene, config.time.samples, about=Description(config, scene))
    for t in config.time.samples:
        writer.observe(state(scene, t))
    writer.close()
    own = [sample_metrics(scene, snapshot, None, errors_alone=True) for snapshot in writer.snapshots]
    kinds = [kind for kind in FORMATS if kind != "vtkhdf" or importlib.util.find_spec("vtk")]
    run = tisph.open(tmp_path)
    for path in (tmp_path / "samples.h5", *(export(run, kind) for kind in kinds)):
        found = judge.judge(config, [path], judge.Question()).samples
        assert [each.numbers["t"] for each in found] == pytest.approx(list(config.time.samples)), path.suffix
        for each, numbers in zip(found, own, strict=True):
            for key in ERRORS:  # sums in another order, and what spacings of jittered particles are found to be
                assert each.numbers[key] == pytest.approx(numbers[key], rel=1e-9), (path.suffix, key)
    few_points(tmp_path, config, scene, writer.snapshots[-1])


def few_points(folder, config, scene, snapshot):
    """The same with 1, 5 and 20 points: their errors, and in words what they are too few for; or a refusal."""
    columns = {key: getattr(snapshot, key) for key in ("x", "y", "u", "v", "w") if getattr(snapshot, key) is not None}
    order = np.argsort(snapshot.y, kind="stable")
    for count in (1, 5, 20):
        chosen = order[np.linspace(0, len(order) - 1, count).astype(int)]
        few = {key: column[chosen] for key, column in columns.items()}
        np.savez(folder / "few.npz", t=snapshot.t, **few)
        if count == 1:
            with pytest.raises(ConfigError, match="at least 5"):
                judge.judge(config, [folder / "few.npz"], judge.Question())
            continue
        found = judge.judge(config, [folder / "few.npz"], judge.Question())
        part = Snapshot(t=snapshot.t, step=0, **few, density=None, pressure=None)
        own = sample_metrics(scene, part, None, errors_alone=True)
        assert found.samples[0].numbers["l2"] == pytest.approx(own["l2"], rel=1e-9)
        assert "fewer than" in judge.text(found, config.name)


RADIUS = (np.arange(20) + 0.5) / 20
PIPE = """
scene: pipe
fluid: {density: 1.0, kinematic_viscosity: 1.0}
geometry: {radius: 1.0, length: 1.0}
drive: {acceleration: 4.0}
discretisation: {particles_across: 20}
time: {end: 20.0}
"""


def compared(folder, monkeypatch, columns, config, *options):
    """What the command prints of a table of ``columns``."""
    monkeypatch.chdir(folder)
    np.savetxt("a.csv", np.stack(list(columns.values()), 1), delimiter=",", header=",".join(columns), comments="")
    done = CliRunner().invoke(cli.app, ["compare", "a.csv", "--config", str(config), *options])
    assert done.exception is None or done.exit_code == 2, done.output
    return done.output


@pytest.mark.parametrize("names", ["r u", "y u", "x y u v", "x y u v w", "x r u u_r u_theta"])
def test_the_profile_of_a_pipe(tmp_path, monkeypatch, names):
    (tmp_path / "pipe.yaml").write_text(PIPE)
    zero, u = 0 * RADIUS, 1 - RADIUS**2  # g (R^2 - r^2) / (4 nu)
    given = {"x": zero + 0.5, "y": RADIUS, "r": RADIUS, "u": u, "v": zero, "w": zero, "u_r": zero, "u_theta": zero}
    columns = {name: given[name] for name in names.split()}
    text = compared(tmp_path, monkeypatch, columns, "pipe.yaml", "--time", "20", "--bound", "1e-12")  # round-off
    assert "0 of 1 errors above 1e-12: pass" in text
    assert "20 points: fewer than 44" in text
    assert ("the data have no v" in text) == ("v" not in columns and "u_r" not in columns)


def steady_couette(r):
    """Velocity around the axis: inner wall of radius 1 at speed 1, outer one of radius 2 at rest."""
    return (4 / r - r) / 3


@pytest.mark.parametrize("names", ["r u_theta", "x y u v", "x y u_theta"])
def test_a_ray_between_cylinders(tmp_path, monkeypatch, names):
    r, angle = 1 + RADIUS, 0.3
    around = steady_couette(r)
    given = {"x": r * np.cos(angle), "y": r * np.sin(angle), "r": r, "u_theta": around}
    given |= {"u": -around * np.sin(angle), "v": around * np.cos(angle)}
    columns = {name: given[name] for name in names.split()}
    config = CONFIGS["circular_couette"]
    text = compared(tmp_path, monkeypatch, columns, config, "--time", "300", "--bound", "1e-8")  # t* = 6
    assert "0 of 1 errors above 1e-08: pass" in text
    assert "spacing 0.05 m" in text


def test_particles_between_cylinders_by_radius_have_the_spacing_of_particles(tmp_path, monkeypatch):
    _, scene = coarse(CONFIGS["circular_couette"])
    r = np.hypot(*places(scene))
    columns = {"r": r, "u_theta": steady_couette(r)}
    text = compared(tmp_path, monkeypatch, columns, CONFIGS["circular_couette"], "--time", "300", "--bound", "1e-8")
    assert "0 of 1 errors above 1e-08: pass" in text
    assert "12 across" in text


def test_what_is_missing_or_outside_is_one_message(tmp_path, monkeypatch):
    (tmp_path / "pipe.yaml").write_text(PIPE)
    still = 0 * RADIUS
    couette, taylor_green = CONFIGS["circular_couette"], CONFIGS["taylor_green"]
    for columns, config, says in (
        ({"r": RADIUS, "u": RADIUS}, CONFIGS["couette"], "this flow needs y, too"),
        ({"r": 1 + RADIUS, "u": RADIUS}, couette, "this flow needs x and y and v, too"),
        ({"y": 1 + RADIUS, "u_theta": RADIUS}, couette, "this flow needs x and u and v, too"),
        ({"y": RADIUS, "u": RADIUS}, taylor_green, "this flow needs x and v, too"),
        ({"r": RADIUS, "u": RADIUS}, CONFIGS["spin_up"], "this flow needs w, too"),
        ({"r": 1000 * RADIUS, "u": RADIUS}, "pipe.yaml", "outside the fluid; give --unit"),
        ({"x": still, "y": 2 * RADIUS - 1, "u": RADIUS}, "pipe.yaml", "outside the fluid; give --unit"),
        ({"x": 1000 + RADIUS, "y": still, "u": RADIUS, "v": RADIUS}, couette, "outside the fluid; give --unit"),
    ):
        text = compared(tmp_path, monkeypatch, columns, config, "--time", "0.5")
        assert text.startswith("error: "), text
        assert says in text


def test_the_start_alone_is_refused(tmp_path, monkeypatch):
    columns = {"y": 0.01 * RADIUS, "u": 0 * RADIUS}
    assert "error: --time 0: is not after the start" in compared(
        tmp_path, monkeypatch, columns, CONFIGS["couette"], "--time", "0"
    )
    columns = {"t": 0 * RADIUS, **columns}
    assert "has t = 0 alone" in compared(tmp_path, monkeypatch, columns, CONFIGS["couette"])


LID = """
scene: cavity
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {width: 1.0, height: 1.0}
walls: {lid: {velocity: 1.0}}
discretisation: {particles_across: 40}
time: {end: 30.0}
"""


@pytest.mark.parametrize("kind", ["sharp", "regular"])
def test_a_cavity_is_compared_with_its_steady_reference(tmp_path, monkeypatch, kind):
    """The flow under the regular lid, 1 % too fast. Under the sharp lid, whose tables have faster flow, it is wrong."""
    (tmp_path / "lid.yaml").write_text(LID.replace("1.0}}", f"1.0, profile: {kind}}}}}"))
    y, x = (np.indices((40, 40)).reshape(2, -1) + 0.5) / 40
    u, v = RegularCavity(1.0, 1.0, 1.0, 0.01).velocity(x, y)
    columns = {"x": x, "y": y, "u": 1.01 * u, "v": 1.01 * v}
    printed = compared(tmp_path, monkeypatch, columns, "lid.yaml", "--time", "30", "--bound", "0.5")
    assert "the data are taken for the steady state" in printed
    numbers = json.loads((tmp_path / "runs" / "compare-a" / "comparison.json").read_text())["samples"][0]
    if kind == "regular":
        assert numbers["l2"] == pytest.approx(0.01, rel=1e-6)
        assert numbers["u_extreme"] / numbers["u_extreme_exact"] == pytest.approx(1.01, abs=1e-3)  # of the fit
    else:
        assert numbers["centre_line_error"] > 0.02
        assert f"at most {numbers['centre_line_error']:.1e} U on the centre lines" in printed


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


@pytest.mark.taichi
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
