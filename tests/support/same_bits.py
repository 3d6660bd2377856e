"""The same bits of a run on any number of threads, and after it was stopped and resumed."""

import json

import numpy as np

import tisph
from tisph.simulation import checkpoint


def state(scheme):
    """Places, velocities, pressures and stresses, and the numbers beside them."""
    snapshot = scheme.snapshot()
    names = ("x", "y", "u", "v", "pressure", "stress_xx", "stress_xy", "stress_yy")
    arrays = (getattr(snapshot, name) for name in names)
    return [array.copy() for array in arrays if array is not None], scheme.host_state()


def check_threads(one, two):
    """Assert that two of what ``state`` returns are the same to the last bit."""
    assert all(np.array_equal(*pair) for pair in zip(one[0], two[0], strict=True))
    assert json.dumps(one[1]) == json.dumps(two[1])


def check_resuming(make, folder, stops, steps):
    """Assert that a run of so many ``steps`` goes on from any of the ``stops`` (numbers of steps) as if it had not.

    ``make`` builds the Scheme, with ``started=False`` one to resume with. Return the run and, resumed from each stop,
    what a run says of its momentum.
    """
    scheme, balances = make(), []
    for number in stops:
        while scheme.steps < number:
            scheme.advance()
        checkpoint.save(folder / f"{number}.h5", scheme, "fingerprint")
    while scheme.steps < steps:
        scheme.advance()
    expected, host = state(scheme)
    resumed = make(started=False)
    for number in stops:
        checkpoint.restore(folder / f"{number}.h5", resumed, "fingerprint")
        while resumed.steps < steps:
            resumed.advance()
        found, found_host = state(resumed)
        assert all(np.array_equal(*pair) for pair in zip(expected, found, strict=True))
        assert found_host == host
        balances.append(resumed.momentum_balance())
    return scheme, balances


def check_substances(config, path, stop, steps):
    """Assert that a run with temperature and dye resumes from a ``stop`` (number of steps) with the same bits.

    ``steps``: of the whole run. ``path``: of the checkpoint.
    """
    with tisph.Simulation(config) as simulation:
        for _ in range(steps):
            simulation.step()
            if simulation.steps == stop:
                simulation.save(path)
        whole = simulation.state.snapshot
    with tisph.Simulation.restore(path) as simulation:
        for _ in range(steps - stop):
            simulation.step()
        again = simulation.state.snapshot
    for name in ("temperature", "dye"):
        assert np.array_equal(whole.substances[name], again.substances[name])
    assert np.array_equal(whole.u, again.u)
    assert np.array_equal(whole.flows, again.flows)
