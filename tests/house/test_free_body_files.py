"""A run with bodies that the flow carries, in contact: its files agree with each other, and the page names all."""

import re

import h5py
import numpy as np
import pytest
from files_page import missing, run

import tisph

pytestmark = pytest.mark.taichi

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
def results(tmp_path_factory, kept_program):
    """The results of that run."""
    return run(CASE, tmp_path_factory.mktemp("free") / "run")


def test_trajectories_are_those_of_samples_and_history(results):
    found = results.bodies
    assert found["t"].tolist() == results.history.t.tolist()
    index = found["t"].tolist().index(0.01)
    for name in set(found) - {"t"}:
        assert np.array_equal(found[name][index], results.samples[1][f"bodies/{name}"][:2]), name
    for name, values in (("x_1", found["centre"][:, 1, 0]), ("angular_velocity_0", found["angular_velocity"][:, 0])):
        assert np.array_equal(results.history[name], values)
    assert np.array_equal(results.history["drag_0"][1:], found["force"][1:, 0, 0])
    measures = results.summary.samples[1]
    assert measures["y_0"] == found["centre"][index, 0, 1]


def test_forces_of_contact_cancel_and_nothing_is_known_at_first(results):
    assert np.isnan(results.bodies["contact_force"][0]).all()
    assert np.isnan(results.samples[0]["bodies/contact_force"]).all()
    for sample in results.samples[1:]:
        forces = sample["bodies/contact_force"]
        size = np.abs(forces).max()
        assert forces[0, 0] < 0.0 < forces[1, 0]  # away from each other
        assert min(forces[0, 1], forces[1, 1]) > 0.0 > forces[2, 1]  # and away from the wall at the bottom
        assert np.abs(forces.sum(axis=0)).max() < 1e-14 * size * len(forces)  # of rounding


def test_the_summary_counts_contacts(results):
    numbers = results.summary.numbers
    assert numbers["contacts"] >= 3  # of the two, and of each with the wall
    assert numbers["contact_time"] == pytest.approx(0.02, rel=1e-12)
    # the largest between two, at the end of some step: those on one body add up to no more than three times that
    assert 0.0 < np.nanmax(results.bodies["contact_force"]) < 3.0 * numbers["contact_force"]


def test_all_that_is_written_is_on_the_page(results):
    keys = {*results.summary.samples[-1].measures, *results.summary.numbers}
    columns = {re.split(r"[=(]", name)[0] for name in results.history.dtype.names}
    with h5py.File(results.folder / "bodies.h5") as file:
        names = {*file, *(set(file.attrs) & {"names", "shapes", "free"}), *results.samples[0].units}
        assert all(data.attrs["units"] for data in file.values())
    assert missing({name.removeprefix("bodies/") for name in keys | columns | names}) == set()
    assert (results.folder / "bodies.h5").name in tisph.folder.RESULTS
