"""Compiled kernels serve runs of another size: what differs from run to run is no part of them."""

import pytest

from tisph import runtime
from tisph.runtime import ti

pytestmark = pytest.mark.taichi

POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"
IMPLICIT = "scheme={type: implicit, operators: {order: 2}}"
OTHER = ("discretisation.particles_across=18", "geometry={gap: 3.0, length: 5.0}", "time.end=0.7")


def compiled(folder):
    """Return the names of the kernels in a cache: hashes of all that they are compiled from."""
    return {path.name for path in folder.rglob("*.tic")}


def use(scheme):
    """Do what a run does: steps and what they need now and then, output."""
    scheme.advance()
    if hasattr(scheme, "rebuild"):
        scheme.rebuild()
        scheme.boundaries.wall_forces(scheme.now)
    else:
        scheme.advance()  # the first step does not shift
        scheme.particles.advance_volumes(1.0)
        scheme.advance()
    scheme.snapshot()
    scheme.numbers()
    ti.reset()


@pytest.mark.other_program
@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(("walls.treatment.type=consistent_image", POLYMER), marks=pytest.mark.slow),
        pytest.param(("walls.treatment.type=adami", "scheme.operators=standard"), marks=pytest.mark.slow),
        (IMPLICIT, "initial.jitter=0.2"),
        pytest.param((IMPLICIT, POLYMER), marks=pytest.mark.slow),
        pytest.param((IMPLICIT, "walls.treatment.type=virtual_image"), marks=pytest.mark.slow),
    ],
)
def test_another_resolution_length_gap_and_end_compile_nothing(make, tmp_path, monkeypatch, scene):
    monkeypatch.setattr(runtime, "CACHE", tmp_path / "cache")
    use(make(*scene))
    first = compiled(tmp_path)
    assert first
    use(make(*scene, *OTHER))
    assert compiled(tmp_path) == first
