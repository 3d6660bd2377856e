from types import SimpleNamespace

import pytest

from tisph.report.labels import (
    axis_exponent,
    axis_label,
    fixed_point,
    number,
    scientific,
    tick_text,
    time_label,
    unit_label,
)

MINUS, TIMES, NU = "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}", "\N{GREEK SMALL LETTER NU}"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (50.0, "50"),
        (0.005, "0.005"),
        (-0.25, f"{MINUS}0.25"),
        (9999.0, "9999"),
        (9999.9, f"1{TIMES}10⁴"),
        (3e-7, f"3{TIMES}10⁻⁷"),
        (-2.5e-4, f"{MINUS}2.5{TIMES}10⁻⁴"),
        (float("nan"), "nan"),
        (123456.0, f"1.235{TIMES}10⁵"),
    ],
)
def test_numbers_are_plain_in_the_usual_range_and_scientific_beyond(value, text):
    assert number(value) == text


def test_errors_always_show_their_order_of_magnitude():
    assert scientific(0.00152) == f"1.5{TIMES}10⁻³"
    assert scientific(0.0) == "0"


@pytest.mark.parametrize(
    ("largest", "exponent"), [(0.005, -3), (0.01, 0), (1.0, 0), (9000.0, 0), (2e5, 3), (3e-7, -9), (0.0, 0)]
)
def test_axes_take_out_powers_of_a_thousand(largest, exponent):
    assert axis_exponent(largest) == exponent


def test_ticks_carry_no_rounding_noise_and_no_offset():
    assert tick_text(3 * 0.001, -3) == "3"
    assert tick_text(-0.0, 0) == "0"
    assert tick_text(0.1 + 0.2, 0) == "0.3"
    assert tick_text(-2500.0, 3) == f"{MINUS}2.5"


def test_axis_labels_name_power_and_unit():
    assert axis_label("u", "m/s", -3) == "u [10⁻³ m/s]"
    assert axis_label("u", "m/s") == "u [m/s]"
    assert axis_label("error", "", -6) == "error [10⁻⁶]"
    assert axis_label("error", "") == "error"


@pytest.mark.parametrize(
    ("viscous_time", "t", "text"),
    [
        (100.0, 2.7, "t = 2.7 s"),
        (100.0, 0.0, "t = 0.0 s"),
        (0.4, 0.1234, "t = 0.1234 s"),
        (4e-6, 1e-6, f"t = 1.000{TIMES}10⁻⁶ s"),
        (40000.0, 1000.0, f"t = 1.00{TIMES}10³ s"),
    ],
)
def test_time_label_resolves_a_thousandth_of_the_viscous_time(viscous_time, t, text):
    label = time_label(viscous_time, "s", "νt/H²")(t)
    assert label == f"{text}     t* = {NU}t/H² = {t / viscous_time:.4f}"


def test_stress_is_in_pascal_where_the_units_say_so():
    assert unit_label("stress", SimpleNamespace(length="m", mass="kg", time="s")) == "Pa"
    assert unit_label("stress", SimpleNamespace(length="cm", mass="kg", time="s")) == "kg/(cm s²)"
    assert unit_label("acceleration", SimpleNamespace(length="cm", mass="kg", time="s")) == "cm/s²"


@pytest.mark.parametrize(
    ("largest", "value", "text"),
    [
        (0.5, 0.25, "0.250"),
        (0.005, -0.00354, f"{MINUS}0.00354"),
        (0.5, -1e-9, "0.000"),
        (1234.0, 7.3, "7"),
        (2e5, -1.5e5, f"{MINUS}150{TIMES}10³"),
        (3e-7, 1.5e-7, f"150{TIMES}10⁻⁹"),
    ],
)
def test_values_that_change_keep_their_decimals(largest, value, text):
    assert fixed_point(largest, 3)(value) == text
