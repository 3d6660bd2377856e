"""docs/reference/files.md names every key of ``summary.json``, column of ``history.csv``, dataset of ``samples.h5``."""

import re
from pathlib import Path

import h5py
import pytest
from files_page import missing, run

pytestmark = pytest.mark.taichi

ROOT = Path(__file__).parents[2]
SHORT = {"time": {"end": 1e-3}, "output": {"video": None}, "runtime.threads": 1}
RUNS = {
    "creep_and_recovery": {"walls.top": {"shear_stress": 1.0}},
    "circular_couette_oldroyd_b": {"discretisation.particles_across": 12},
    "cylinder_in_channel": {},
    "taylor_green": {},
    "shear_layer": {},
    "cavity": {},
    "eccentric_annulus": {"initial.state": "rest"},
    "spin_up": {"fluid.rheology": {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.5}},
    "taylor_vortices": {},
    "falling_ball": {},
}


FEW = "creep_and_recovery", "cylinder_in_channel", "cavity", "spin_up"
"""A stress-controlled wall, bodies, a scene without a reference, axisymmetric flow with a polymer."""


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=[] if name in FEW else [pytest.mark.slow]) for name in RUNS]
)
def results(request, tmp_path_factory, kept_program):
    """Return the results of a short, coarse run of a scene."""
    folder = tmp_path_factory.mktemp(request.param) / "run"
    changes = {"discretisation.particles_across": 18, **SHORT, **RUNS[request.param]}
    return run(ROOT / "configs" / f"{request.param}.yaml", folder, **changes)


def test_keys_of_the_summary_are_on_the_page(results):
    summary = results.summary
    keys = {*summary.samples[-1].measures, *summary.numbers, *summary.momentum, *vars(summary.cost)}
    assert missing({*keys, *vars(summary.provenance)}) == set()


def test_columns_of_the_history_are_on_the_page(results):
    lines = (results.folder / "history.csv").read_text(encoding="utf-8").splitlines()
    header = next(line for line in lines if not line.startswith("#"))
    assert missing(re.split(r"[=(]", column)[0] for column in header.split(",")) == set()


def test_datasets_and_attributes_are_on_the_page(results):
    with h5py.File(results.folder / "samples.h5") as file:
        sample = file["sample_000"]
        names = {*sample, *sample.get("bodies", ()), *sample.attrs}
    assert missing(names - {"bodies"}) == set()
