"""Compiled kernels of the implicit scheme serve runs of another size: no number of particles is in them."""

import pytest

from tisph import runtime

OTHER = ("discretisation.particles_across=15", "geometry={gap: 0.75, length: 1.5}", "time.end=0.7")


def compiled(folder):
    """Return the names of the kernels in a cache: hashes of all that they are compiled from."""
    return {path.name for path in folder.rglob("*.tic")}


def use(scheme):
    """Do what a run does: the impulse of a wall that jumps, steps, shifts, a pressure, output."""
    scheme.advance()
    scheme.advance()
    scheme.shift.spread()
    scheme.motion.take_along(0.0)
    scheme.project(scheme.time, 1.0)
    scheme.field.stretch(1.0)
    scheme.advance()
    scheme.snapshot()
    scheme.numbers()
    runtime.stop()


@pytest.mark.parametrize("treatment", ["consistent_image", pytest.param("virtual_image", marks=pytest.mark.slow)])
def test_another_resolution_length_gap_and_end_compile_nothing(make, tmp_path, monkeypatch, treatment):
    monkeypatch.setattr(runtime, "CACHE", tmp_path / "cache")
    scene = ("scheme={type: implicit, operators: {order: 2}}", f"walls.treatment.type={treatment}")
    use(make(*scene, jitter=0.2))
    first = compiled(tmp_path)
    assert first
    use(make(*scene, *OTHER, jitter=0.2))
    assert compiled(tmp_path) == first
