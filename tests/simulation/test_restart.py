"""A run that goes on from a checkpoint is the uninterrupted run, to the last bit; one that cannot is refused."""

import json
import random
import shutil

import h5py
import numpy as np
import pytest
from couette import couette_text

from tisph import simulation
from tisph.errors import ConfigError
from tisph.folder import Folder
from tisph.results import open_run
from tisph.results.export import export
from tisph.runtime import ti
from tisph.simulation import checkpoint

pytestmark = pytest.mark.taichi

TIMES = {"end": 0.9, "samples": [0.3, 0.45, 0.6, 0.9]}
OUTPUT = {"video": {"frames": 7, "width": 640, "height": 320}, "checkpoint_every": 0.5}
CASE = couette_text(initial={"jitter": 0.2}, time=TIMES, output=OUTPUT)
OLDROYD_B = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4}"
MODES = (
    "fluid.rheology={type: multi_mode, solvent_fraction: 0.4, modes: [{relaxation_time: 0.5, fraction: 0.3}, "
    "{type: fene_p, relaxation_time: 0.2, maximum_extension: 20, fraction: 0.3}]}"
)
OSCILLATION = "walls.top={amplitude: 0.5, angular_frequency: 40.0}"
SCHEDULE = "walls.top={times: [0.0, 0.5, 0.5, 0.7], velocities: [0.5, 0.5, 0.1, 0.3]}"
NO_VIDEO = "output.video=null"
TOUCHING = [
    "bodies=[{centre: [0.3, 0.5], radius: 0.15, motion: free},"
    " {centre: [0.72, 0.5], radius: 0.15, motion: free, density: 2.0}]",
    "contact={distance: 0.15}",
    "discretisation.particles_across=20",
    "time={end: 0.3, tolerance: 1e-4, samples: [0.1, 0.15, 0.2, 0.3]}",
    "output.checkpoint_every=0.17",
    NO_VIDEO,
]
SCENES = {
    "wcsph": ["scheme={type: wcsph}"],
    "implicit": ["scheme={type: implicit}", "time.tolerance=1e-5"],
    "viscoelastic": ["scheme={type: wcsph}", OLDROYD_B, NO_VIDEO],
    "several modes": [MODES, NO_VIDEO, "output.vtk=true"],
    "oscillating": ["scheme={type: wcsph}", "walls.treatment.type=adami", OSCILLATION, NO_VIDEO],
    "scheduled wall": ["scheme={type: implicit}", "time.tolerance=1e-5", SCHEDULE, NO_VIDEO],
    "a plate with a mass": [
        *(OLDROYD_B, NO_VIDEO),
        "walls={bottom: {slip_length: 0.1}, top: {shear_stress: 0.01, mass_per_area: 0.3}}",
    ],
    "free bodies in contact": TOUCHING,
    "single precision": ["scheme={type: wcsph}", "discretisation.precision=f32", NO_VIDEO],
    "a pipe with open ends": [
        *("scene=pipe", "geometry={radius: 1.0, length: 2.0}", "walls={outer: {angular_velocity: 1.0}}", "initial={}"),
        "ends={left: {type: inlet, velocity: 1.0}, right: {type: outlet}}",
        *("fluid.kinematic_viscosity=0.1", "discretisation.particles_across=10", NO_VIDEO),
    ],
    "slip between cylinders": [
        *("scene=annulus", "geometry={inner_radius: 1.0, outer_radius: 2.0}", "initial={}"),
        "walls={inner: {angular_velocity: 1.0, slip_length: 0.2}, outer: {slip_length: infinite}}",
        *("fluid.kinematic_viscosity=0.1", OLDROYD_B, "discretisation.particles_across=10", NO_VIDEO),
    ],
}
SLOW = ["oscillating", "single precision", "a pipe with open ends", "slip between cylinders"]
SLOW += ["viscoelastic", "scheduled wall"]  # of which all goes on from any step, and a run is extended, below


@pytest.fixture
def case(loader, monkeypatch):
    """Return a function that loads the small case with ``key.path=value`` overrides.

    No run of it draws pictures, and its history has a tenth of the lines, which cost as much as the steps of some.
    """
    monkeypatch.setattr("tisph.simulation.recording.begin_pictures", lambda *_: [])
    monkeypatch.setattr("tisph.observers.history.RECORDS", 41)
    return loader(CASE)


def datasets(path):
    """Every dataset and attribute of a HDF5 file, by name."""
    found = {}

    def take(name, item):
        found.update({f"{name}@{key}": value for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = item[...]

    with h5py.File(path) as file:
        file.visititems(take)
    return found


def same(one, other):
    """Numbers or text; a number that is none is the same as another."""
    return np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")


def checkpoint_time(folder):
    with h5py.File(folder.checkpoint) as file:
        return json.loads(file.attrs["host"])["time"]


def forget_what_came_after(folder):
    """Leave what a process killed right after the checkpoint would have left, and a torn line of the history."""
    saved = checkpoint_time(folder)
    for path in (folder.samples, folder.frames) if folder.frames.exists() else (folder.samples,):
        with h5py.File(path, "r+") as file:
            late = [name for name, group in file.items() if group.attrs["t"] > saved]
            for name in late:
                del file[name]
            assert 0 < len(late) < 4
    if folder.bodies.exists():
        with h5py.File(folder.bodies, "r+") as file:
            kept = int(np.sum(file["t"][...] <= saved)) + 2
            for name, values in {name: data[...] for name, data in file.items()}.items():
                assert kept < len(values)
                del file[name]
                file[name] = values[:kept]
    text = folder.history.read_text().splitlines(keepends=True)
    first = next(number for number, line in enumerate(text) if line.startswith("t,")) + 1
    header, lines = "".join(text[:first]), text[first:]
    early = [line for line in lines if float(line.split(",")[0]) <= saved]
    folder.history.write_text(header + "".join(early) + lines[len(early)][:30])
    folder.summary.unlink()
    assert 0 < len(early) < len(lines)


@pytest.mark.parametrize("scene", [pytest.param(scene, marks=[pytest.mark.slow] * (scene in SLOW)) for scene in SCENES])
def test_files_of_a_resumed_run_equal_an_uninterrupted_one_bitwise(case, tmp_path, scene):
    settings = case(*SCENES[scene])
    whole, cut = Folder(tmp_path / "whole"), Folder(tmp_path / "cut")
    simulation.run(settings, whole.root)
    shutil.copytree(whole.root, cut.root)
    forget_what_came_after(cut)
    simulation.run(settings, cut.root, resume=True)
    assert whole.vtk.exists() == settings.output.vtk
    assert whole.bodies.exists() == (scene == "free bodies in contact")
    for name in [name for name in ("samples", "frames", "vtk", "bodies") if getattr(whole, name).exists()]:
        expected, found = datasets(getattr(whole, name)), datasets(getattr(cut, name))
        assert expected.keys() == found.keys()
        different = [key for key in expected if not same(expected[key], found[key])]
        assert different == [], name
    if settings.output.vtk:
        exported = datasets(export(open_run(cut.root), "vtkhdf", tmp_path / "exported.vtkhdf"))
        assert exported.keys() == found.keys()
        assert [key for key in exported if not same(exported[key], found[key])] == []
    assert cut.history.read_text() == whole.history.read_text()
    expected, found = (json.loads(folder.summary.read_text()) for folder in (whole, cut))
    for key in ("status", "samples", "numbers", "momentum"):
        assert found[key] == expected[key], key
    assert found["cost"]["steps"] == expected["cost"]["steps"]
    assert bool(found["numbers"].get("contacts")) == whole.bodies.exists()


def end_state(scheme):
    """Run to the end; return all that a scheme then knows, field by field."""
    while not scheme.finished:
        scheme.advance()
    fields = {f"{part}.{name}": values for part, holder in scheme.parts().items() for name, values in arrays(holder)}
    return fields, scheme.host_state(), scheme.numbers(), scheme.momentum_balance()


def arrays(holder):
    return [(name, field.to_numpy()) for name, field in vars(holder).items() if isinstance(field, ti.Field)]


@pytest.mark.parametrize("scene", [pytest.param("wcsph", marks=pytest.mark.slow), "viscoelastic"])
def test_an_explicit_run_goes_on_from_any_step(make, tmp_path, scene):
    # from either buffer, and with lists of any age; those of the implicit scheme are new at every step
    options = [*SCENES[scene], "time={end: 0.3}", "initial.jitter=0.2"]
    scheme = make(*options)
    numbers = [21, 24, 27, 30]
    for number in numbers:
        while scheme.steps < number:
            scheme.advance()
        checkpoint.save(tmp_path / f"{number}.h5", scheme, "fingerprint")
    fields, *others = end_state(scheme)
    resumed = make(*options, started=False)
    for number in numbers:
        checkpoint.restore(tmp_path / f"{number}.h5", resumed, "fingerprint")
        assert resumed.steps == number
        found, *found_others = end_state(resumed)
        assert [name for name in fields if not np.array_equal(fields[name], found[name])] == []
        assert found_others == others


def test_a_run_without_video_goes_on_with_one(case, tmp_path):
    # the frames before the checkpoint are not to be had, the scheme knows no state before it; those after it are
    settings = case(*SCENES["implicit"])
    folder = Folder(tmp_path / "out")
    simulation.run(settings, folder.root, video=False)
    assert not folder.frames.exists()
    simulation.run(settings, folder.root, resume=True)
    with h5py.File(folder.frames) as file:
        times = [frame.attrs["t"] for frame in file.values()]
    assert min(times) > checkpoint_time(folder)
    assert json.loads(folder.summary.read_text())["status"] == "done"


@pytest.mark.parametrize("scene", [pytest.param("wcsph", marks=pytest.mark.slow), "scheduled wall"])
def test_an_extended_run_equals_one_that_was_planned_so_long(case, tmp_path, capsys, scene):
    shorter = "time={end: 0.6, samples: [0.3, 0.45, 0.6]}"  # the old end is a sample: both runs step onto it
    settings = [case(*SCENES[scene], NO_VIDEO, *end) for end in ([], [shorter, *SCENES[scene][1:]])]
    whole, extended = Folder(tmp_path / "whole"), Folder(tmp_path / "extended")
    simulation.run(settings[0], whole.root)
    simulation.run(settings[1], extended.root)
    simulation.run(settings[0], extended.root, resume=True)
    assert "warning" not in capsys.readouterr().err
    expected, found = datasets(whole.samples), datasets(extended.samples)
    assert expected.keys() == found.keys()
    assert [key for key in expected if not np.array_equal(expected[key], found[key])] == []
    expected, found = (json.loads(folder.summary.read_text()) for folder in (whole, extended))
    assert (found["numbers"], found["momentum"]) == (expected["numbers"], expected["momentum"])


def test_an_extended_explicit_run_warns_that_it_is_not_bitwise_equal(case, tmp_path, capsys):
    settings = [
        case("scheme={type: wcsph}", f"time={{end: {end}}}", NO_VIDEO, "output.checkpoint_every=0.3")
        for end in (0.3, 0.6)
    ]
    folder, whole = Folder(tmp_path / "out"), Folder(tmp_path / "whole")
    simulation.run(settings[0], folder.root)
    assert checkpoint_time(folder) == 0.3
    simulation.run(settings[1], folder.root, resume=True)
    assert "the result is not bitwise that of a run with the new time.end" in capsys.readouterr().err
    assert "the result is not bitwise" in folder.log.read_text()
    simulation.run(settings[1], whole.root)
    found, expected = datasets(folder.samples), datasets(whole.samples)
    assert [found[f"sample_00{k}@t"] for k in range(2)] == [0.3, 0.6]  # the sample at the old end is kept
    error = json.loads(whole.summary.read_text())["samples"][0]["l2"]
    difference = np.linalg.norm(found["sample_001/u"] - expected["sample_000/u"])
    assert 0.0 < difference < 0.1 * error * np.linalg.norm(expected["sample_000/u"])  # steps err less than operators


def test_what_is_missing_of_a_run_is_named(case, tmp_path):
    settings = case("scheme={type: wcsph}")
    simulation.run(settings, tmp_path / "out", video=False)
    for name in ("history.csv", "samples.h5", "checkpoint.h5"):
        (tmp_path / "out" / name).unlink()
        with pytest.raises(ConfigError, match=name):
            simulation.run(settings, tmp_path / "out", video=False, resume=True)


# --- damaged and foreign checkpoints


@pytest.fixture
def saved(make, tmp_path):
    """Return the path of a checkpoint, and a function that restores it."""
    path, scheme = tmp_path / "checkpoint.h5", make(jitter=0.2)
    checkpoint.save(path, scheme, "fingerprint")
    return path, lambda: checkpoint.restore(path, scheme, "fingerprint")


def test_a_changed_or_truncated_checkpoint_is_refused(saved):
    path, restore = saved
    restore()
    good = path.read_bytes()
    draw = random.Random(3)
    damaged = [good[: int(part * len(good))] for part in (0.0, 0.0001, 0.5, 0.9999)]
    for place in [0, len(good) - 1, *(draw.randrange(len(good)) for _ in range(100))]:
        damaged.append(good[:place] + bytes([good[place] ^ 1 << draw.randrange(8)]) + good[place + 1 :])
    for content in damaged:
        path.write_bytes(content)
        with pytest.raises(ConfigError, match=r"checkpoint.h5: cannot be read"):
            restore()


@pytest.mark.parametrize("other", ["discretisation.particles_across=14", "scheme={type: implicit}"])
def test_a_checkpoint_with_the_fields_of_another_program_is_refused(make, saved, other):
    # the fingerprint is of the config alone: another version of tisph may have other fields under the same one
    with pytest.raises(ConfigError, match=r"checkpoint.h5: cannot be read"):
        checkpoint.restore(saved[0], make(other, started=False), "fingerprint")
