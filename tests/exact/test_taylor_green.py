"""Taylor-Green vortices: the equations, by spectral derivatives, and the balance of kinetic energy."""

import numpy as np
import pytest

from tisph.exact import taylor_green

FLOW = {"length": 0.7, "speed": 1.3, "kinematic_viscosity": 0.02}
DENSITY = 800.0
T = 0.4
POINTS = 16  # a period: the fields and their products have wave numbers up to 2, which are differentiated exactly
ROUNDING = 1e-12  # of the largest term: a few hundred operations with 2e-16 each


@pytest.fixture
def lattice():
    along = np.arange(POINTS) * FLOW["length"] / POINTS
    return np.meshgrid(along, along, indexing="ij")


def spectral(values, axis):
    """Derivative along x (axis 0) or y (1) of values on the lattice."""
    waves = 2j * np.pi * np.fft.fftfreq(POINTS, FLOW["length"] / POINTS)
    waves = waves[:, None] if axis == 0 else waves[None, :]
    return np.fft.ifft(waves * np.fft.fft(values, axis=axis), axis=axis).real


def laplacian(values):
    return sum(spectral(spectral(values, axis), axis) for axis in (0, 1))


def in_time(function):
    """Time derivative by central differences of sixth order, whose error is far below ``ROUNDING`` here."""
    step = 1e-3
    weights = {1: 45.0, 2: -9.0, 3: 1.0}
    return sum(w * (function(T + n * step) - function(T - n * step)) for n, w in weights.items()) / (60.0 * step)


def test_the_equations_are_satisfied(lattice):
    u, v = taylor_green.velocity(*lattice, T, **FLOW)
    p = taylor_green.pressure(*lattice, T, density=DENSITY, **FLOW)
    omega = taylor_green.vorticity(*lattice, T, **FLOW)
    gradient = spectral(u, 0)
    assert np.abs(gradient + spectral(v, 1)).max() < ROUNDING * np.abs(gradient).max()
    assert np.abs(spectral(v, 0) - spectral(u, 1) - omega).max() < ROUNDING * np.abs(omega).max()
    assert omega[0, 0] > 0.0  # it rotates counterclockwise about the origin
    assert abs(p.mean()) < ROUNDING * np.abs(p).max()
    for axis, component in enumerate((u, v)):
        rate = in_time(lambda t, axis=axis: taylor_green.velocity(*lattice, t, **FLOW)[axis])
        convection = u * spectral(component, 0) + v * spectral(component, 1)
        forces = FLOW["kinematic_viscosity"] * laplacian(component) - spectral(p, axis) / DENSITY
        # differences in time of values rounded to 1e-16 over a step of 1e-3 of the time scale
        assert np.abs(rate + convection - forces).max() < 1e-11 * np.abs(convection).max()


def test_energy_and_dissipation_are_means_of_the_field(lattice):
    u, v = taylor_green.velocity(*lattice, T, **FLOW)
    omega = taylor_green.vorticity(*lattice, T, **FLOW)
    assert taylor_green.kinetic_energy(T, **FLOW) == pytest.approx(0.5 * np.mean(u**2 + v**2), rel=ROUNDING)
    # in a periodic flow the mean of 2 nu D:D is that of nu omega^2
    lost = FLOW["kinematic_viscosity"] * np.mean(omega**2)
    assert taylor_green.dissipation(T, **FLOW) == pytest.approx(lost, rel=ROUNDING)


def test_arguments_broadcast():
    x, t = np.linspace(0.0, 1.0, 5)[:, None], np.array([0.0, 1.0, 2.0])
    assert [values.shape for values in taylor_green.velocity(x, 0.25, t, **FLOW)] == [(5, 3), (5, 3)]
    assert taylor_green.pressure(x, 0.25, t, density=1.0, **FLOW).shape == (5, 3)
