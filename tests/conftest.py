"""Fixtures for all rooms, the order of the tests, and the same examples in every run of them.

A test that runs kernels has the marker ``taichi``: the tests of its file share one Taichi program.
"""

import gc
import os
import signal

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)  # a busy machine is no failure
settings.load_profile("repeatable")

# matrices here are small, and threads of NumPy's that wait for one another only keep other tests from the processors
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

gc.set_threshold(200_000, 20, 20)  # as the command line does, and for the same reason

COUETTE = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
time: {end: 2.0}
"""


def pytest_collection_modifyitems(items):
    """Sort long tests first, so that the last ones end together; tests that end a shared program come after all."""

    def rank(item):
        long = 2 * ("verification" in item.path.parts) + (item.get_closest_marker("taichi") is not None)
        return item.get_closest_marker("other_program") is not None, -long

    items.sort(key=rank)


@pytest.fixture(scope="module")
def kept_program():
    """Taichi starts once for many tests of a file.

    Numbers of fields are compiled in, and they follow from what was asked for before: in a file always the same, so
    that the next run of the tests finds its kernels in the cache. Tests of one file run in one process for that.
    """
    import kept_program  # it imports Taichi, which most tests do without

    kept_program.install()
    yield
    kept_program.uninstall()


@pytest.fixture(scope="module", autouse=True)
def started_once(request):
    """Let the tests of each file with the marker ``taichi`` share one program."""
    if request.node.get_closest_marker("taichi"):
        request.getfixturevalue("kept_program")


@pytest.fixture(scope="session")
def make_any(tmp_path_factory):
    """Return what ``scheme_case.builder`` returns for a config of a small Couette flow."""
    import scheme_case

    path = tmp_path_factory.mktemp("case") / "case.yaml"
    path.write_text(scheme_case.CASE)
    return scheme_case.builder(path)


@pytest.fixture(scope="session")
def make(make_any):
    """``make_any``: a name that a test file can give a narrower meaning."""
    return make_any


@pytest.fixture(scope="module")
def shared(make_any):
    """Return ``make_any(..., started=False)``, on one thread, which builds a Scheme once for all tests that ask for it.

    For tests that place particles and list neighbours anew: to read the kernels again takes longer than all they do.
    """
    from kept_program import kept

    built, starts = {}, 0

    def find(*overrides):
        nonlocal starts
        # Taichi has started again, perhaps in what it had before: all fields are gone
        if starts != kept.starts:
            built.clear()
        if overrides not in built:
            built[overrides] = make_any(*overrides, started=False, fresh=not built)
            starts = kept.starts
        return built[overrides]

    return find


@pytest.fixture
def loader(tmp_path):
    """Return a function that turns the text of a config into one that loads it with ``key.path=value`` overrides."""
    from tisph.config import load

    def of(text):
        (tmp_path / "case.yaml").write_text(text)
        return lambda *overrides: load(tmp_path / "case.yaml", overrides)

    return of


@pytest.fixture
def couette(tmp_path):
    """Path of a config of start-up Couette flow that leaves open whatever it can."""
    path = tmp_path / "case.yaml"
    path.write_text(COUETTE)
    return path


@pytest.fixture
def case(loader):
    """Return a function that loads this config with overrides."""
    return loader(COUETTE)


@pytest.fixture
def load_flow(loader):
    """Return a function that loads the config of flows.yaml with a name, with ``key.path=value`` overrides."""
    from flows import flow_text

    return lambda name, *overrides: loader(flow_text(name))(*overrides)


@pytest.fixture
def start_flow(tmp_path):
    """Return a function that gives scene and scheme at the start of such a config, as ``case_from_text.started``."""
    from case_from_text import started
    from flows import flow_text

    return lambda name, *overrides, **how: started(tmp_path, flow_text(name), overrides, **how)


@pytest.fixture
def fake_process(monkeypatch):
    """Stands in for `tisph run`: leaves a summary with an l2 of the test's choice, or stops with an error."""
    from fake_runs import FakeRuns, make_result

    from tisph.studies import processes

    l2_by_name = {}

    def summary(config):
        l2 = l2_by_name.get(config["name"], 1e-3)
        return l2 if isinstance(l2, str) else make_result(t18=l2).summary

    runs = FakeRuns(summary)
    monkeypatch.setattr(processes, "start", runs)
    return runs.configs, l2_by_name


@pytest.fixture
def hang_up_heard():
    """Let a hang-up be heard during a test, as in a terminal, where the tests were started to ignore it (nohup)."""
    number = getattr(signal, "SIGHUP", None)  # Windows has none
    ignored = number is not None and signal.getsignal(number) is signal.SIG_IGN
    if ignored:
        signal.signal(number, signal.SIG_DFL)
    yield
    if ignored:
        signal.signal(number, signal.SIG_IGN)
