"""Parallel flow with a flow rate that changes in time, against closed forms and the equations of motion."""

import numpy as np
import pytest
from scipy.special import jv

from tisph.exact.flow_rate import ChangingProfile
from tisph.geometry.ends import Course
from tisph.geometry.motion import Schedule, WallMotion

VISCOSITY, HEIGHT, RADIUS, FREQUENCY, TIME = 0.04, 2.0, 1.5, 3.0, 14.1
COURSE = Course(1.0, WallMotion(0.0, 0.8, FREQUENCY))
MODES = ((0.5, 0.02), (0.1, 0.01))
"""Relaxation times and viscosities of a polymer in a solvent of the viscosity 0.01."""


def parabola(y):
    return 6.0 * y * (HEIGHT - y) / HEIGHT**2


@pytest.mark.parametrize("modes", [(), MODES], ids=["Newtonian", "two modes"])
def test_oscillating_flow_between_planes_is_womersleys(modes):
    """With the complex viscosity of linear viscoelasticity in the place of the viscosity."""
    solvent = VISCOSITY - sum(viscosity for _, viscosity in modes)
    flow = ChangingProfile(0.0, HEIGHT, parabola, solvent, modes, COURSE)
    y, half = np.linspace(0.0, HEIGHT, 21), 0.5 * HEIGHT
    viscosity = solvent + sum(part / (1.0 + 1j * FREQUENCY * time) for time, part in modes)
    k = np.sqrt(1j * FREQUENCY / viscosity)
    shape = (1.0 - np.cosh(k * (y - half)) / np.cosh(k * half)) / (1.0 - np.tanh(k * half) / (k * half))
    turning = -0.8j * np.exp(1j * FREQUENCY * TIME)
    assert flow.value(y, TIME) == pytest.approx((turning * (shape - parabola(y))).real, abs=1e-11)
    assert flow.value(y, TIME, 1) == pytest.approx((1j * FREQUENCY * turning * (shape - parabola(y))).real, abs=1e-10)


def test_oscillating_flow_in_a_pipe_is_womersleys():
    steady = lambda r: 2.0 * (1.0 - (r / RADIUS) ** 2)  # noqa: E731
    flow = ChangingProfile(0.0, RADIUS, steady, VISCOSITY, (), COURSE, axisymmetric=True)
    r, k = np.linspace(0.0, RADIUS, 21), np.sqrt(-1j * FREQUENCY / VISCOSITY)
    shape = 1.0 - jv(0, k * r) / jv(0, k * RADIUS)
    shape = shape / (1.0 - 2.0 * jv(1, k * RADIUS) / (k * RADIUS * jv(0, k * RADIUS)))
    assert flow.value(r, TIME) == pytest.approx(
        (-0.8j * np.exp(1j * FREQUENCY * TIME) * (shape - steady(r))).real, abs=1e-11
    )


def test_long_after_a_bend_the_flow_of_a_ramp_is_a_polynomial():
    """nu w'' + G = dU/dt P with a mean of 0: the quartic of q = y/H, dU/dt H^2/nu (q^3 - q^4/2 - 3 q^2/5 + q/10).

    Its second derivative is P but for a constant, and it is 0 at the walls and in the mean.
    """
    flow = ChangingProfile(0.0, HEIGHT, parabola, 0.01, MODES, Schedule((1.0, 501.0), (0.5, 100.5)))
    y = np.linspace(0.0, HEIGHT, 21)
    q, scale = y / HEIGHT, 0.2 * HEIGHT**2 / VISCOSITY
    assert np.abs(flow.value(y, 0.9)).max() == 0.0
    assert flow.value(y, 500.0) == pytest.approx(scale * (q**3 - 0.5 * q**4 - 0.6 * q**2 + 0.1 * q), abs=1e-9 * scale)
    assert np.abs(flow.value(y, 1500.0)).max() < 1e-12


@pytest.mark.parametrize("axisymmetric", [False, True], ids=["planes", "between pipes"])
def test_flow_of_a_table_satisfies_its_equation(axisymmetric):
    """The stresses of the modes are integrated from the slopes in time, by Simpson's rule."""
    low = 0.5
    steady = lambda y: 6.0 * (y - low) * (HEIGHT - y)  # noqa: E731  (any course of mean 0 or not: it is projected)
    course = Schedule((0.0, 0.3, 0.5), (0.0, 1.0, 0.4))
    flow = ChangingProfile(low, HEIGHT, steady, 0.01, MODES, course, axisymmetric)
    y, step, time = np.linspace(low, HEIGHT, 41)[1:-1], 1e-4, 0.7
    times = np.linspace(0.0, time, 2001)

    def flux(places):
        slopes = np.array([flow.slope(places, t) for t in times])
        total = 0.01 * slopes[-1]
        for relaxation, viscosity in MODES:
            weights = np.exp((times - time) / relaxation) * viscosity / relaxation
            simpson = np.tile([2.0, 4.0], 1001)[:2001] / 3.0 * (times[1] - times[0])
            simpson[[0, -1]] /= 2.0
            total = total + (simpson * weights) @ slopes
        return total * (places if axisymmetric else 1.0)

    divergence = (flux(y + step) - flux(y - step)) / (2.0 * step) / (y if axisymmetric else 1.0)
    drive = flow.value(y, time, 1) - divergence + course.acceleration(time) * steady(y)
    assert np.ptp(drive) < 1e-4 * np.abs(divergence).max()
    ends = np.array([low, HEIGHT])
    assert flow.value(ends, time) == pytest.approx(0.0, abs=1e-12)
