"""Runs against exact solutions: the bounds of the verification suite, one test each.

The bounds and where they come from stand in ``tisph/suites``. A run is simulated once, when the first
test asks for it, and all processes of the tests read what it left.
"""

import pytest
from filelock import FileLock

from tisph import config, simulation
from tisph.errors import DivergedError
from tisph.studies import suites, verify
from tisph.studies.processes import read_result, run_config
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
walls, and lattice bounds the error at 50 across of the wall that moves. The vortex of 50 across has the same bounds in
tests/core/test_splitting.py, its order too. What walls of any shape cost is in tests/core/test_curved_walls.py,
eccentric cylinders in
tests/core/test_eccentric_cylinders.py; the steady flow under a regular lid and the sharp lid are
in tests/core/test_cavity.py; a coarser cylinder is held in shear in tests/core/test_bodies_in_flow.py, to the same
stress of the walls; between the same cylinders a Giesekus fluid starts in
tests/core/test_polymer_in_two_dimensions.py.
What moves free bodies at rest, when they are released, falling and in shear is in tests/core/test_free_bodies.py, the
drag of a sphere in tests/core/test_axisymmetric_loads.py. The pipe and Taylor vortices with fewer particles are in
tests/core/test_axisymmetric.py, spin-up in tests/core/test_regions_of_revolution.py, a fluid of varying viscosity
between cylinders in tests/core/test_varying_viscosity.py. Bingham's law is stepped as Carreau's, and varies more.
What the two laws say in kernels is compared with NumPy in tests/core/test_laws_in_kernels.py, that with the literature
in tests/unit/test_laws.py; how a law is stepped is in other rows here, and two modes in
tests/core/test_polymer_steps.py, to the same bound."""


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
    """Run one config in this process; return what ``run_config`` does: no pictures, and little history."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("tisph.simulation.drawing.begin_pictures", lambda *_: [])
        monkeypatch.setattr("tisph.observers.history.RECORDS", 21)  # steady or not is read off a quarter of them
        try:
            simulation.run(config.load(config_path), folder)
        except DivergedError as error:
            return read_result(folder), str(error)
    return read_result(folder), ""


@pytest.fixture(scope="module")
def quick_runner(tmp_path_factory, worker_id, kept_program):
    """A Runner that shares its runs with those of other processes; repeated runs have a process of their own."""
    folder = tmp_path_factory.getbasetemp()
    shared = (folder if worker_id == "master" else folder.parent) / "quick suite"
    shared.mkdir(exist_ok=True)

    def run_once(config_path, folder):
        name = config_path.stem
        with FileLock(shared / f"{name}.lock"):
            if (shared / name).exists():
                return read_result(shared / name), ""
            return (run_config if name.endswith("repeat") else run_here)(config_path, shared / name)

    runs = {
        name: settings if name.endswith("repeat") else {**settings, **HERE}
        for name, settings in suites.whole(quick=True).runs.items()
    }
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(verify, "run_config", run_once)
        yield verify.Runner(Suite("", runs), tmp_path_factory.mktemp("configs"))


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
