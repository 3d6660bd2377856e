"""A scene pays for nothing that it does not use: no field, no byte, no compiled instruction, no output."""

import importlib
import math
from collections import deque

import kept_program
import pytest
from couette import couette_text

from tisph import registry, runtime
from tisph.report import movie
from tisph.runtime import ti
from tisph.scenes.channel import Channel
from tisph.simulation import checkpoint, run
from tisph.size_class import size_class

pytestmark = pytest.mark.taichi

EXPLICIT, IMPLICIT = "scheme={type: wcsph}", "scheme={type: implicit}"
ROOM = size_class(12 * 12)  # of all fields of particles and of points on the walls

NUMBER, INDEX = 8, 4  # bytes, in double precision
TENSOR = 3 * NUMBER  # xx, xy, yy
BOTH = 2  # buffers, or walls


@pytest.fixture
def load(loader):
    return loader(couette_text(time={"end": 0.01}))


@pytest.fixture
def build(load):
    """Return a function that builds a Scheme which has not started: its fields are there, but nothing is compiled."""

    def build(*overrides):
        settings = load(*overrides)
        runtime.start(settings.discretisation.precision, 1)
        scheme = registry.load("schemes", settings.scheme.type).build
        return scheme(settings, Channel.from_config(settings), settings.time.samples, serial=True)

    return build


def fields(scheme):
    """Every Taichi field that ``scheme`` holds, by the shortest path of attributes to it."""
    found, visited, waiting = {}, {id(scheme)}, deque([("", scheme)])
    while waiting:
        path, owner = waiting.popleft()
        inside = dict(enumerate(owner)) if isinstance(owner, list | tuple) else getattr(owner, "__dict__", {})
        ours = isinstance(owner, list | tuple) or type(owner).__module__.startswith("tisph.")
        for name, value in owner.items() if isinstance(owner, dict) else inside.items() if ours else ():
            if id(value) in visited:
                continue
            visited.add(id(value))
            if isinstance(value, ti.Field):
                found[f"{path}{name}"] = value
            else:
                waiting.append((f"{path}{name}.", value))
    return found


def sizes(scheme):
    """Bytes of the numbers in each field."""
    each = {ti.f64: 8, ti.f32: 4, ti.i64: 8, ti.i32: 4, ti.u8: 1}
    return {
        name: math.prod(field.shape)
        * each[field.dtype]
        * (field.n * field.m if isinstance(field, ti.MatrixField) else 1)
        for name, field in fields(scheme).items()
    }


def polymer(scheme):
    """Stress of particles and of what stands for them beyond the walls, its law, and a track on each wall."""
    track = {"compression": NUMBER, "stress": TENSOR, "mid_stress": TENSOR, "slope": TENSOR, "mid_slope": TENSOR}
    everywhere = scheme.particles.mid_pressure.shape[1]
    return {
        "particles.stress": BOTH * ROOM * TENSOR,
        "particles.mid_stress": BOTH * everywhere * TENSOR,
        "stepper.stress_trace": NUMBER,
        "fluid.stress.relaxation_rate": NUMBER,
        "fluid.stress.modulus": NUMBER,
        **{f"walls.track.{name}": BOTH * ROOM * each for name, each in track.items()},
        "walls.track.column": BOTH * ROOM * INDEX,
        "walls.track.count": INDEX,
        "walls.track.origin": BOTH * NUMBER,
        "walls.track.spacing": NUMBER,
        "walls.track.radius_squared": NUMBER,
    }


OLDROYD_B = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"
DRIVE = "drive.acceleration=0.02"
OSCILLATION = "walls.top={amplitude: 0.5, angular_frequency: 1.0}"
DRIVEN = {"domain.acceleration": NUMBER}
OSCILLATING = {"domain.bottom_acceleration": NUMBER, "domain.top_acceleration": NUMBER}


@pytest.mark.parametrize(
    ("scheme", "part", "adds"),
    [
        (EXPLICIT, OLDROYD_B, polymer),
        (EXPLICIT, "scheme.equation_of_state.pressure_cutoff=-1.0", {"fluid.pressure_cutoff": NUMBER}),
        (EXPLICIT, "scheme.artificial_viscosity=0.1", {"operators.artificial_viscosity": NUMBER}),
        (EXPLICIT, DRIVE, DRIVEN),
        (EXPLICIT, OSCILLATION, OSCILLATING),
        (IMPLICIT, DRIVE, DRIVEN),
        (IMPLICIT, OSCILLATION, OSCILLATING),
    ],
)
def test_a_part_has_fields_of_its_own_and_changes_no_other(build, scheme, part, adds):
    plain = sizes(build(scheme))
    used = build(scheme, part)
    added = adds(used) if callable(adds) else adds
    assert not plain.keys() & added.keys()  # without its fields no kernel can hold its code either
    assert sizes(used) == plain | added


@pytest.mark.parametrize("scheme", [EXPLICIT, IMPLICIT])
def test_no_field_is_out_of_sight(build, scheme):
    kept_program.forget()  # it has the fields of other tests
    built = build(scheme)
    program = ti.lang.impl.get_runtime()
    program.materialize()
    trees = [program.prog.get_snode_root(number) for number in range(program.prog.get_snode_tree_size())]
    seen = sum(sizes(built).values())
    # Taichi begins each field at a multiple of 8 bytes
    assert seen <= sum(tree.cell_size_bytes for tree in trees) <= seen + 8 * len(sizes(built))


@pytest.mark.parametrize("scheme", [EXPLICIT, IMPLICIT])
def test_steps_need_no_further_fields(make, scheme):
    started = make(scheme)
    before = sizes(started)
    for _ in range(10):
        started.advance()
    assert sizes(started) == before


@pytest.mark.parametrize(
    "unused",
    [
        "fluid.rheology={type: newtonian}",
        "scheme.equation_of_state.pressure_cutoff=null",
        "scheme.artificial_viscosity=0.0",
        "drive.acceleration=0.0",
        "walls={bottom: {velocity: 0.0}, top: {velocity: 0.5}}",
    ],
)
def test_saying_that_a_part_is_not_used_is_saying_nothing(load, unused):
    assert load(EXPLICIT, unused) == load(EXPLICIT)


def test_a_run_without_movie_and_checkpoints_opens_none(load, tmp_path, monkeypatch):
    def refuse(*arguments):
        pytest.fail("there was to be no movie and no checkpoint")

    recording = importlib.import_module("tisph.simulation.recording")
    monkeypatch.setattr(movie, "Movie", refuse)
    monkeypatch.setattr(recording, "Frames", refuse)
    monkeypatch.setattr(checkpoint, "save", refuse)
    run(load(EXPLICIT, "output={video: null, checkpoint_every: null}"), tmp_path / "out")
    assert not list((tmp_path / "out").glob("*.mp4"))
