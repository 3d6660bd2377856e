"""Runs against exact solutions: the bounds of the verification suite, one test each.

The bounds and where they come from stand in ``tisph/suites``. A run is simulated once, when the first
test asks for it, and all processes of the tests read what it left.
"""

import pytest
from filelock import FileLock

from tisph import config, simulation
from tisph.errors import DivergedError
from tisph.studies import suites, verify
from tisph.studies.processes import read_result
from tisph.studies.suites import Suite

HERE = {"runtime": {"threads": 1}, "output": {"video": None}}
"""Of a run in the tests' own process. One thread gives the bits of several, and costs less beside other tests."""


LONG = (
    "across_25/50",
    "taylor_green",
    "taylor_green 25/50",
    "cavity_25",
    "regular_lid_slow 16/25",
    "shear_held",
    "eccentric_25",
    "eccentric 16/25",
    "oldroyd_b_annulus_12",
    "annulus, ratio 0.2, 12/25",
    "exponential_ptt_poiseuille",
    "fene_p_couette",
    "two_modes_poiseuille",
    "free_shear",
    "sphere 16/24",
    "sphere_24",
    "annulus_25",
    "taylor_green_25",
    "giesekus_couette",
    "carreau",
    "carreau_annulus",
    "pipe_20",
    "spin_up_20",
    "vortex_20",
    "free_at_rest",
    "free_falling",
    "free_uniform",
    "released_0.1",
)
"""Quick rows that take longest. The order of the explicit scheme is that of poiseuille, with the same operators and
walls, and lattice bounds the error at 50 across of the wall that moves. In tests/schemes the vortex of 50 across has
the same bounds in test_two_dimensional.py, its order too; curved walls and eccentric cylinders are in
test_curved_walls.py, the steady flow under a regular lid and the sharp lid in test_corner_singularities.py, a coarser
cylinder, held in shear, in test_bodies_in_flow.py, to the same stress of the walls; between the same cylinders a
Giesekus fluid starts in test_viscoelastic_stress.py. The forces on free bodies at rest, when they are released,
falling and in shear are in test_free_bodies.py, the drag of a sphere, the pipe and Taylor vortices with fewer
particles in test_axisymmetric.py, spin-up in test_regions_of_revolution.py, a fluid of varying viscosity between
cylinders in test_generalised_newtonian_stress.py, a law in steps and two modes in test_channel_polymer.py, to the same
bound. Bingham's law is stepped as Carreau's, and varies more. tests/rheology/test_laws_in_kernels.py compares both
laws in kernels with NumPy, and test_laws.py there compares them with the literature."""


def checks(quick):
    """The suite's criteria, with a readable test name each."""
    return [
        pytest.param(
            criterion,
            id=f"{criterion.case}: {criterion.quantity} {criterion.bound}",
            marks=[pytest.mark.slow] if criterion.case in LONG else [],
        )
        for criterion in suites.whole(quick).criteria
    ]


def run_here(config_path, folder):
    """Run one config in this process; return ``Result`` and message: no pictures, and little history."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("tisph.simulation.recording.begin_pictures", lambda *_: [])
        monkeypatch.setattr("tisph.observers.history.RECORDS", 81)  # a quarter shows scatter (resolution.LEAST_TURNS)
        try:
            simulation.run(config.load(config_path), folder)
        except DivergedError as error:
            return read_result(folder), str(error)
    return read_result(folder), ""


class SharedRunner(verify.Runner):
    """A Runner that shares its runs with other processes; repeated runs have a process of their own."""

    def outcome(self, name, config):
        folder = self.store.folder / name
        with FileLock(self.store.folder / f"{name}.lock"):
            if folder.exists():
                return read_result(folder), ""
            if name.endswith("repeat"):
                return super().outcome(name, config)
            return run_here(self.store.write(name, {**config, **HERE}), folder)


@pytest.fixture(scope="module")
def quick_runner(tmp_path_factory, worker_id, kept_program):
    folder = tmp_path_factory.getbasetemp()
    shared = (folder if worker_id == "master" else folder.parent) / "quick suite"
    return SharedRunner(Suite("", suites.whole(quick=True).runs), shared)


@pytest.fixture(scope="module")
def full_runner(tmp_path_factory):
    return verify.Runner(suites.whole(quick=False), tmp_path_factory.mktemp("full"))


@pytest.mark.verification
@pytest.mark.parametrize("criterion", checks(quick=True))
def test_quick_suite(quick_runner, criterion):
    check = quick_runner.judge(criterion)
    assert check.passed, f"{check.value:.3g} is not {check.bound} {quick_runner.failures}"


@pytest.mark.verification
@pytest.mark.slow
@pytest.mark.timeout(1800)  # the longest run has 110 000 steps of 5000 particles
@pytest.mark.parametrize("criterion", checks(quick=False))
def test_full_suite(full_runner, criterion):
    check = full_runner.judge(criterion)
    assert check.passed, f"{check.value:.3g} is not {check.bound} {full_runner.failures}"
