"""The one place where Taichi is initialised."""

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import tisph
from tisph import runtime
from tisph.runtime import ti, unrolled
from tisph.simulation.state import useful_threads

pytestmark = pytest.mark.taichi

of_taichi_1_7_4 = pytest.mark.skipif(not runtime._taichi.KNOWN, reason="about parts that are replaced there alone")


def test_serial_and_parallel_kernels_are_cached_apart():
    # a shared cache would hand the serial loops of one thread to a run on several
    folders = []
    for threads in (1, 2):
        runtime.start("f64", threads)
        folders.append(ti.lang.impl.current_cfg().offline_cache_file_path)
    assert folders[0] != folders[1]


@pytest.mark.parametrize(("precision", "digits"), [("f64", 1e-16), ("f32", 1e-7)])
def test_numbers_keep_the_digits_of_the_precision(precision, digits):
    runtime.start(precision, 1)
    stored = runtime.scalar(0.3)[None]
    assert abs(stored - 0.3) <= 0.3 * digits
    if precision == "f32":
        assert stored != 0.3


@ti.kernel
def misspelt() -> float:
    return undefined_name  # noqa: F821 (what the test is about)


def test_an_error_in_a_kernel_names_its_place():
    runtime.start("f64", 1)
    line = misspelt._primal.func.__code__.co_firstlineno + 2
    with pytest.raises(Exception, match=rf'test_runtime.py", line {line}, in misspelt:\s(.*\s)*.*undefined_name'):
        misspelt()


@ti.kernel
def doubled(x: float) -> float:
    return 2.0 * x


def test_reading_a_kernel_counts_once():
    runtime.start("f64", 1)
    before = runtime.compile_seconds()
    assert doubled(1.0) == 2.0
    after = runtime.compile_seconds()
    assert (after > before).all()
    assert doubled(3.0) == 6.0
    assert (runtime.compile_seconds() == after).all()


@pytest.mark.parametrize("age", [0.0, 2.0 * runtime.WRITTEN_SECONDS])
def test_a_stale_lock_does_not_block_the_kernel_cache(tmp_path, monkeypatch, age):
    monkeypatch.setattr(runtime, "CACHE", tmp_path)
    folder = tmp_path / runtime.GENERATION / "serial"
    folder.mkdir(parents=True)
    lock = folder / {"TI": "ticache.lock", "QD": "qdcache.lock"}[runtime._taichi.PREFIX]
    lock.touch()
    os.utime(lock, (time.time() - age,) * 2)
    runtime.start("f64", 1)
    assert lock.exists() == (age == 0.0)  # somebody may be writing now
    assert doubled(1.0) == 2.0
    ti.reset()
    kernels = [path for path in tmp_path.rglob("*") if path.suffix in (".tic", ".qdc")]  # Taichi's, Quadrants'
    assert bool(kernels) == (age > 0.0 or runtime.PACKAGE == "quadrants")  # which adds them all the same


@ti.data_oriented
class Counter:
    """Adds to a number by kernels: with numbers as arguments, and with a result."""

    def __init__(self):
        self.total = runtime.scalar(0.0)

    @ti.kernel
    def add(self, times: ti.i32, what: float):
        self.total[None] += times * what

    @ti.kernel
    def doubled(self) -> float:
        return 2.0 * self.total[None]


def test_a_kernel_that_is_launched_again_sees_its_arguments_and_its_object():
    for _ in range(2):  # objects of a program that is gone are no concern of the next one
        runtime.start("f64", 1)
        one, other = Counter(), Counter()
        for number in range(4):
            one.add(number, 0.5)
            other.add(1, -float(number))
            assert one.doubled() == 2.0 * one.total[None]
        assert (one.total[None], other.total[None]) == (3.0, -6.0)
    with pytest.raises(Exception, match=r"(?i)argument|parameter"):
        one.add(1)


def test_no_kernel_of_the_package_calls_that_of_a_class_above():
    # Taichi cannot, and Quadrants keeps what super() finds in the object, in the place of its own
    package, kernels, methods, called = Path(tisph.__file__).parent, set(), set(), set()
    for path in package.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        kernels |= set(re.findall(r"@ti\.kernel\s+def (\w+)", text))
        methods |= set(re.findall(r"(?<!@ti\.kernel)\n    def (\w+)", text))
        called |= set(re.findall(r"super\(\)\.(\w+)", text))
    assert kernels
    assert not (kernels - methods) & called


@ti.data_oriented
class Neighbours:
    """Numbers that a serial loop within another writes, and reads again."""

    def __init__(self):
        self.written, self.read = ti.field(ti.i32, 3), ti.field(ti.i32, 3)

    @ti.kernel
    def fill(self, outer: ti.i32):
        if outer > 0:
            for _ in range(outer):
                for j in range(3):
                    self.written[j] = 1
                    self.read[j] = self.written[0]


def test_a_serial_loop_reads_what_it_has_written(tmp_path, monkeypatch):
    # Taichi 1.7.4 reads written[0] once, before the inner loop, unless that is switched off; the key of a kernel leaves
    # that option out, so that kernels of Taichi's own options must not be found again
    monkeypatch.setattr(runtime, "CACHE", tmp_path)
    runtime.start("f64", 1)
    assert str(tmp_path / runtime.GENERATION) in ti.lang.impl.current_cfg().offline_cache_file_path
    numbers = Neighbours()
    numbers.fill(1)
    assert numbers.read.to_numpy().tolist() == [1, 1, 1]


@ti.data_oriented
class Loops:
    """Counts the iterations of loops: outermost, inside, and inside ``unrolled``."""

    def __init__(self, serial):
        self.serial = serial
        self.outer, self.inner, self.longer = (runtime.integer(0) for _ in range(3))

    @ti.kernel
    def count(self, number: ti.i32):
        ti.loop_config(serialize=self.serial)
        for _ in range(number):
            ti.atomic_add(self.outer[None], 1)
        ti.loop_config(serialize=self.serial)
        for _ in range(1):
            for _first in range(number):
                self.inner[None] += 1
            for _second in range(unrolled(number)):
                self.longer[None] += 1

    @ti.kernel
    def count_in_static_loop(self, number: ti.i32):
        for _ in ti.static(range(2)):
            ti.loop_config(serialize=self.serial)
            for _each in range(number):
                ti.atomic_add(self.outer[None], 1)

    def counted(self):
        return [int(runtime.view(number)) for number in (self.outer, self.inner, self.longer)]


@of_taichi_1_7_4
@pytest.mark.parametrize("serial", [True, False])
def test_all_loops_but_unrolled_ones_may_end_early(serial):
    # were LLVM told that the number is 0 it would unroll them again; loops of several threads cannot end early
    runtime.start("f64", 1)
    loops = Loops(serial)
    runtime.view(ti.lang.impl.get_runtime().never)[()] = 1
    loops.count(20)
    assert loops.counted() == [1 if serial else 20, 1, 20]
    loops.count_in_static_loop(20)  # alone it is an outermost one
    assert loops.counted()[0] == 3 * (1 if serial else 20)


@pytest.mark.parametrize("kind", ["scalar", "vector", "matrix"])
def test_a_view_is_the_memory_that_kernels_see(kind):
    runtime.start("f64", 1)
    shape, within = (3, 2), {"scalar": (), "vector": (4,), "matrix": (2, 3)}[kind]
    make = {"scalar": ti.field, "vector": ti.Vector.field, "matrix": ti.Matrix.field}[kind]
    field = make(*within, runtime.real(), shape=shape)
    values = np.arange(np.prod(shape + within)).reshape(shape + within)
    runtime.view(field)[...] = values
    assert np.array_equal(field.to_numpy(), values)
    field.from_numpy(-values.astype(float))
    assert np.array_equal(runtime.view(field), -values)


def test_numbers_have_their_values_before_and_after_a_kernel_has_run():
    runtime.start("f64", 1)
    before = Counter(), runtime.integer(3)
    before[0].add(1, 0.5)
    after = runtime.scalar(0.25), runtime.integer(4)
    found = [float(runtime.view(number)) for number in (before[0].total, before[1], *after)]
    assert found == [0.5, 3, 0.25, 4]


AS_VERSION = """
import importlib.metadata, json, sys
version = importlib.metadata.version
importlib.metadata.version = lambda name: sys.argv[1] if name == "taichi" else version(name)
"""
"""Lets a program believe that Taichi has the version that it is given."""

WHO_DECORATES = """
from tisph.runtime import ti
print(ti.data_oriented.__module__)
"""


@of_taichi_1_7_4
@pytest.mark.parametrize(("version", "module"), [("1.7.4", "tisph.runtime._inner"), ("1.8.0", "taichi")])
def test_inner_parts_are_replaced_in_the_known_version_alone(version, module):
    command = [sys.executable, "-c", AS_VERSION + WHO_DECORATES, version]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.startswith(module)


SMALL = ("discretisation.particles_across=12", "output.video=null")
RUNS = {
    "channel": {"couette": "time={end: 1.8, samples: [1.8]}", "couette_adami": "time={end: 0.2, samples: [0.2]}"},
    "box": {"taylor_green": "time={end: 0.02, samples: [0.02]}"},
}
"""Runs of one process each: both schemes in a channel, and vortices without walls."""

ALL_RUNS = """
from tisph import cli
from tisph.observers import history
history.RECORDS = 21
for arguments in json.loads(sys.argv[2]):
    cli.app(arguments, standalone_mode=False)
"""


def arrays(path):
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]} if isinstance(item, h5py.Dataset) else {}))
    return found


@pytest.fixture
def folders_by_version(tmp_path_factory, runs):
    """Folders of ``runs`` of a process with the replaced parts, and of one with Taichi's own."""
    configs, roots = Path(__file__).parents[2] / "configs", []
    for version in ("1.7.4", "1.8.0"):
        roots.append(tmp_path_factory.mktemp("runs"))
        commands = [
            ["run", str(configs / f"{config}.yaml"), "--out", str(roots[-1] / config), "--no-pictures"]
            + [word for change in (*SMALL, time) for word in ("--set", change)]
            for config, time in runs.items()
        ]
        command = [sys.executable, "-c", AS_VERSION + ALL_RUNS, version, json.dumps(commands)]
        subprocess.run(command, capture_output=True, check=True)
    return roots


@of_taichi_1_7_4
@pytest.mark.parametrize(
    "runs", [RUNS["channel"], pytest.param(RUNS["box"], marks=pytest.mark.slow)], ids=["channel", "box"]
)
def test_results_are_bitwise_the_same_with_taichi_as_it_is(folders_by_version, runs):
    for config in runs:
        replaced, own = (arrays(root / config / "samples.h5") for root in folders_by_version)
        assert replaced.keys() == own.keys()
        assert all(np.array_equal(replaced[name], own[name]) for name in replaced)


def threads(scheme, parallel, particles, asked="auto"):
    asked, scheme = SimpleNamespace(threads=asked), SimpleNamespace(type=scheme)
    config = SimpleNamespace(runtime=asked, scheme=scheme, parallel=parallel)
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


@of_taichi_1_7_4
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
