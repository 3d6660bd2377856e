"""Walls whose velocity is given at some times: velocity, displacement, and age of the motion."""

import numpy as np
import pytest

from tisph.geometry.motion import Schedule

WALL = Schedule((0.1, 0.3, 0.3, 0.6, 0.9), (0.0, 1.0, 0.5, 2.0, 0.0))


def test_a_jump_is_seen_from_before_and_entered_after():
    assert WALL.velocity(np.array([0.0, 0.2, 0.3, 0.45, 0.9, 2.0])) == pytest.approx([0.0, 0.5, 1.0, 1.25, 0.0, 0.0])
    assert WALL.acceleration(np.array([0.05, 0.3, 0.45])) == pytest.approx([0.0, 5.0, 5.0])
    assert WALL.after(0.3).velocity(0.3) == 0.5
    assert WALL.after(0.3).acceleration(7.0) == pytest.approx(5.0)
    assert WALL.jump_times == (0.1, 0.3, 0.6, 0.9)
    assert Schedule((0.0, 1.0), (3.0, 3.0)).velocity(0.0) == 3.0
    assert Schedule((0.0, 1.0), (3.0, 3.0)).jump_times == ()


def test_the_displacement_is_the_integral_of_the_velocity():
    # triangle, trapezium, triangle
    assert WALL.displacement(np.array([0.0, 0.3, 0.6, 0.9, 1.5])) == pytest.approx([0.0, 0.1, 0.475, 0.775, 0.775])


def test_the_age_counts_from_jumps_and_from_steep_changes_not_from_kinks():
    assert WALL.age(0.05) == np.inf  # at rest until 0.1
    assert WALL.age(0.35) == pytest.approx(0.05)  # the jump at 0.3
    assert WALL.age(2.0) == pytest.approx(2.0 - 0.75)  # 1, half the largest speed, off 0 last at 0.75
    assert Schedule((0.0, 1.0), (3.0, 3.0)).age(0.4) == pytest.approx(0.4)  # started from rest
    assert Schedule((0.0, 1.0), (3.0, 3.0)).age(0.0) == 0.0
    assert Schedule((1.0, 1.0, 2.0), (0.0, 3.0, 3.0)).age(1.0) == np.inf  # it jumps after that
    assert Schedule((0.0, 1.0), (0.0, 0.0)).age(1.0) == np.inf
    assert Schedule((0.0, 1e-9), (0.0, 1.0)).age(0.5) == pytest.approx(0.5)  # as good as a jump


def test_a_sine_s_table_ages_as_the_layer_of_the_sine():
    w, t = 2.0 * np.pi, np.linspace(0.0, 2.0, 201)
    table = Schedule(tuple(t), tuple(np.sin(w * t)))
    # at its steepest it takes 2 arcsin(1/4) / w to change by half the amplitude; chords err by 1e-3
    youngest = min(table.age(time) for time in np.linspace(0.3, 2.0, 500))
    assert youngest == pytest.approx(2 * np.arcsin(0.25) / w, rel=2e-3)
