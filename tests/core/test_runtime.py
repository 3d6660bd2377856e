"""The one place where Taichi is initialised."""

import os
import time

import pytest

from tisph import runtime
from tisph.runtime import ti, unrolled


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


def test_nothing_is_printed(capfd):
    runtime.start("f64", 1)
    assert capfd.readouterr().out == ""


@ti.kernel
def misspelt() -> float:
    return undefined_name  # noqa: F821 (what the test is about)


def test_an_error_in_a_kernel_names_its_place():
    runtime.start("f64", 1)
    line = misspelt._primal.func.__code__.co_firstlineno + 2
    with pytest.raises(
        ti.TaichiCompilationError, match=rf'test_runtime.py", line {line}, in misspelt:\s.*undefined_name'
    ):
        misspelt()


@ti.kernel
def doubled(x: float) -> float:
    return 2.0 * x


def test_reading_a_kernel_counts_once():
    runtime.start("f64", 1)
    before = runtime.compile_seconds()
    assert doubled(1.0) == 2.0
    after = runtime.compile_seconds()
    assert after > before
    assert doubled(3.0) == 6.0
    assert runtime.compile_seconds() == after


@pytest.mark.parametrize("age", [0.0, 2.0 * runtime.WRITTEN_SECONDS])
def test_a_lock_that_a_killed_process_left_does_not_keep_kernels_from_the_cache(tmp_path, monkeypatch, age):
    monkeypatch.setattr(runtime, "CACHE", tmp_path)
    (tmp_path / "serial").mkdir()
    lock = tmp_path / "serial" / "ticache.lock"
    lock.touch()
    os.utime(lock, (time.time() - age,) * 2)
    runtime.start("f64", 1)
    assert lock.exists() == (age == 0.0)  # somebody may be writing now
    assert doubled(1.0) == 2.0
    ti.reset()
    assert any(tmp_path.glob("serial/*.tic")) == (age > 0.0)


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


def test_a_launch_with_the_wrong_number_of_arguments_is_refused():
    runtime.start("f64", 1)
    counter = Counter()
    counter.add(1, 1.0)
    with pytest.raises(ValueError, match="argument"):
        counter.add(1)


class Subclass(Counter):
    """Overrides what its class has, and calls it."""

    @property
    def half(self):
        return 0.5 * self.doubled()

    @ti.kernel
    def add(self, times: ti.i32, what: float):
        self.total[None] -= times * what

    def both(self):
        super().add(1, 3.0)
        self.add(1, 2.0)


def test_an_object_has_the_kernels_of_its_class_and_of_those_above():
    runtime.start("f64", 1)
    one = Subclass()
    for _ in range(2):
        one.both()
    assert one.total[None] == 2 * (3.0 - 2.0)
    assert one.half == 2.0
    assert "__getattribute__" not in vars(Counter)  # all else is looked up as Python does


@ti.data_oriented
class Turns:
    """Counts the turns of loops: outermost, inside, and inside ``unrolled``."""

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
            for _second in unrolled(number):
                self.longer[None] += 1

    @ti.kernel
    def count_in_static_loop(self, number: ti.i32):
        for _ in ti.static(range(2)):
            ti.loop_config(serialize=self.serial)
            for _turn in range(number):
                ti.atomic_add(self.outer[None], 1)


@pytest.mark.parametrize("serial", [True, False])
@pytest.mark.parametrize("never", [0, 1])
def test_loops_turn_once_at_a_time_by_a_number_that_llvm_does_not_know(serial, never):
    # were it told that the number is 0 it would make eight turns one again; loops of several threads cannot end early
    runtime.start("f64", 1)
    turns = Turns(serial)
    runtime.view(ti.lang.impl.get_runtime().never)[()] = never
    turns.count(20)
    once = 1 if never else 20
    found = [int(runtime.view(number)) for number in (turns.outer, turns.inner, turns.longer)]
    assert found == [once if serial else 20, once, 20]


@pytest.mark.parametrize("serial", [True, False])
def test_a_loop_in_a_static_one_alone_is_an_outermost_one(serial):
    runtime.start("f64", 1)
    turns = Turns(serial)
    runtime.view(ti.lang.impl.get_runtime().never)[()] = 1
    turns.count_in_static_loop(20)
    assert int(runtime.view(turns.outer)) == 2 * (1 if serial else 20)
