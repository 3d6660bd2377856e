"""How many threads ``runtime.threads: auto`` stands for."""

from types import SimpleNamespace

import pytest

from tisph import runtime
from tisph.simulation.state import useful_threads


def threads(scheme, parallel, particles, asked="auto"):
    config = SimpleNamespace(
        runtime=SimpleNamespace(threads=asked), scheme=SimpleNamespace(type=scheme), parallel=parallel
    )
    return useful_threads(config, SimpleNamespace(particles=particles))


@pytest.mark.parametrize(
    ("scheme", "parallel", "particles", "expected"),
    [
        ("auto", False, 625, 1),  # a cavity, 25 across: two threads took 1.3 to 2 times as long
        ("implicit", False, 2500, 2),
        ("wcsph", False, 625, 2),
        ("auto", True, 625, 2),
        ("auto", True, 500, 1),
    ],
)
def test_a_second_thread_has_enough_particles(monkeypatch, scheme, parallel, particles, expected):
    monkeypatch.setattr(runtime, "available_threads", lambda: 8)
    assert min(2, threads(scheme, parallel, particles)) == expected
    assert threads(scheme, parallel, particles, asked=3) == 3
