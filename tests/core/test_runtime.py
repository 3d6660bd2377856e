"""The one place where Taichi is initialised."""

import pytest

from tisph import runtime
from tisph.runtime import ti


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
