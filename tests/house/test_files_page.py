"""docs/reference/files.md names every key, column and dataset of a run's files; free bodies in contact too."""

import re
from pathlib import Path

import _files
import h5py
import numpy as np
import pytest

import tisph
from tisph import simulation
from tisph.config import loader
from tisph.studies import sweep

pytestmark = pytest.mark.taichi

ROOT = Path(__file__).parents[2]
NAMED = {re.split(r"[/=(]", name)[0] for name in re.findall(r"`([^`\n]+)`", _files.files_page())}
SHORT = {"time": {"end": 1e-3}, "output": {"video": None}, "runtime.threads": 1}
RUNS = {
    "creep_and_recovery": {"walls.top": {"shear_stress": 1.0}},
    "circular_couette_oldroyd_b": {"discretisation.particles_across": 12},
    "eccentric_annulus": {"initial.state": "rest"},
    "spin_up": {"fluid.rheology": {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.5}},
    "sphere_in_stream": {"discretisation.particles_across": 24},
    "carried_circle": {"discretisation.particles_across": 24},
}
OTHERS = "cylinder_in_channel taylor_green shear_layer taylor_vortices falling_ball couette_slip"
HEATED = {"conductivity": 1.0, "heat_capacity": 1.0, "walls": {"left": 1.0, "right": 0.0}}
RUNS["cavity"] = {"temperature": HEATED, "scalars": [{"name": "dye", "diffusivity": 1.0, "initial": "x"}]}
RUNS |= {name: {} for name in (*OTHERS.split(), "pressure_driven_channel", "wavy_pipe")}
FEW = "creep_and_recovery", "cylinder_in_channel", "cavity", "spin_up"
"""A stress-controlled wall, bodies, a scene without a reference, axisymmetric flow with a polymer."""


def run(config, folder, **changes):
    """Return the results of a run in this process, with little history and without pictures, which have no keys."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tisph.observers.history.RECORDS", 21)
        settings = loader.loaded(config, changes)
        return tisph.open(simulation.run(settings, folder, pictures=False, video=False))


def plain(name):
    """A key without the number or the wall of a body, the name of a substance, and the mark of an exact value."""
    name = re.sub(r"_exact$", "", name)
    name = re.sub(r"^(force|torque)_(body_\d+|bottom|top|left|right|around_\d+)$", r"\1_NAME", name)
    name = re.sub(r"^dye(?=_|$)", "NAME", name)
    name = re.sub(r"^((?:heat|NAME)_flow|nusselt)_(bottom|lid|left|right)$", r"\1_WALL", name)
    return re.sub(r"_(\d+|around)$|^(drag|lift)(_pressure)?_(bottom|top)$", r"\2\3", name)


def missing(names):
    """Those of the names that the page does not have."""
    return {name for name in names if not {name, plain(name)} & NAMED}


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=[] if name in FEW else [pytest.mark.slow]) for name in RUNS]
)
def results(request, tmp_path_factory, kept_program):
    """Return the results of a short, coarse run of a scene."""
    folder = tmp_path_factory.mktemp(request.param) / "run"
    changes = {"discretisation.particles_across": 18, **SHORT, **RUNS[request.param]}
    return run(ROOT / "configs" / f"{request.param}.yaml", folder, **changes)


def test_all_names_in_the_files_are_on_the_page(results):
    assert missing(path.name for name, path in vars(tisph.folder.Folder(".")).items() if name != "root") == set()
    summary = results.summary
    keys = {*summary.samples[-1].measures, *summary.numbers, *summary.momentum, *vars(summary.cost)}
    assert missing({*keys, *vars(summary.provenance)}) == set()
    collected = {*sweep.SUMMARY_NAMES.split(), *sweep.sample_names(results.config)}
    assert keys - set(summary.momentum) <= {*collected, "t", "resolved", "reason"}
    lines = (results.folder / "history.csv").read_text(encoding="utf-8").splitlines()
    header = next(line for line in lines if not line.startswith("#"))
    assert missing(re.split(r"[=(]", column)[0] for column in header.split(",")) == set()
    with h5py.File(results.folder / "samples.h5") as file:
        sample = file["sample_000"]
        names = {*sample, *sample.get("bodies", ()), *sample.attrs}
    assert missing(names - {"bodies"}) == set()


CASE = {
    "scene": "channel",
    "fluid": {"density": 2.0, "kinematic_viscosity": 0.1},
    "geometry": {"gap": 1.0, "length": 1.0},
    "walls": {"top": {"velocity": 0.5}},
    "bodies": [
        {"centre": [0.3, 0.35], "radius": 0.15, "motion": "free"},
        {"centre": [0.72, 0.35], "radius": 0.15, "motion": "free", "density": 2.5},
    ],
    "contact": {"distance": 0.22},  # above the gap of 0.12 between them, and that of 0.2 to a wall
    "discretisation": {"particles_across": 20},
    "time": {"end": 0.02, "tolerance": 1e-4, "samples": [0.0, 0.01, 0.02]},
    "output": {"video": None},
    "runtime": {"threads": 1},
}


@pytest.fixture(scope="module")
def touching(tmp_path_factory, kept_program):
    """The results of that run."""
    return run(CASE, tmp_path_factory.mktemp("free") / "run")


def test_trajectories_are_those_of_samples_and_history(touching):
    found = touching.bodies
    assert found["t"].tolist() == touching.history.t.tolist()
    index = found["t"].tolist().index(0.01)
    for name in set(found) - {"t"}:
        assert np.array_equal(found[name][index], touching.samples[1][f"bodies/{name}"][:2]), name
    for name, values in (("x_1", found["centre"][:, 1, 0]), ("angular_velocity_0", found["angular_velocity"][:, 0])):
        assert np.array_equal(touching.history[name], values)
    assert np.array_equal(touching.history["drag_0"][1:], found["force"][1:, 0, 0])
    measures = touching.summary.samples[1]
    assert measures["y_0"] == found["centre"][index, 0, 1]


def test_forces_of_contact_cancel_and_nothing_is_known_at_first(touching):
    assert np.isnan(touching.bodies["contact_force"][0]).all()
    assert np.isnan(touching.samples[0]["bodies/contact_force"]).all()
    for sample in touching.samples[1:]:
        forces = sample["bodies/contact_force"]
        size = np.abs(forces).max()
        assert forces[0, 0] < 0.0 < forces[1, 0]  # away from each other
        assert min(forces[0, 1], forces[1, 1]) > 0.0 > forces[2, 1]  # and away from the wall at the bottom
        assert np.abs(forces.sum(axis=0)).max() < 1e-14 * size * len(forces)  # of rounding


def test_the_summary_counts_contacts(touching):
    numbers = touching.summary.numbers
    assert numbers["contacts"] >= 3  # of the two, and of each with the wall
    assert numbers["contact_time"] == pytest.approx(0.02, rel=1e-12)
    # the largest between two, at the end of some step: those on one body add up to no more than three times that
    assert 0.0 < np.nanmax(touching.bodies["contact_force"]) < 3.0 * numbers["contact_force"]


def test_all_that_is_written_of_bodies_is_on_the_page(touching):
    keys = {*touching.summary.samples[-1].measures, *touching.summary.numbers}
    columns = {re.split(r"[=(]", name)[0] for name in touching.history.dtype.names}
    with h5py.File(touching.folder / "bodies.h5") as file:
        names = {*file, *(set(file.attrs) & {"names", "shapes", "free"}), *touching.samples[0].units}
        assert all(data.attrs["units"] for data in file.values())
    assert missing({name.removeprefix("bodies/") for name in keys | columns | names}) == set()
    assert (touching.folder / "bodies.h5").name in tisph.folder.RESULTS
