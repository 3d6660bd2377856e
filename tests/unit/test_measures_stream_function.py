"""Stokes' stream function: of the order it claims, and right behind a body that moves."""

from types import SimpleNamespace

import numpy as np
from test_measures_gradients import scattered

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.measures.fits import stream_function

WAVE = 2 * np.pi


def found(rows, x, y, u, bodies=()):
    """psi in a cylinder of radius 1 around the axis, one period long."""
    scene = SimpleNamespace(
        origin=(0.0, 0.0), extent=(1.0, 1.0), periodic=(True, False), spacing=1 / rows, bodies=bodies,
        seen=lambda snapshot: scene,
    )  # fmt: skip
    return stream_function(scene, SimpleNamespace(t=0.0, x=x, y=y, u=u, v=0 * u))


def test_stream_function_of_vortices_in_a_pipe_is_of_third_order():
    errors = []
    for rows in (16, 32):
        x, y = scattered(rows)
        exact = np.cos(WAVE * x) * y**2 * (1 - y)
        errors.append(np.abs(found(rows, x, y, np.cos(WAVE * x) * (2 - 3 * y)) - exact).max() / np.ptp(exact))
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] > 2**2.5  # fits of degree 2 have errors of the third power of the spacing


def test_stream_function_goes_on_behind_a_body_that_moves():
    x, y = scattered(20)
    outside = np.hypot(x - 0.5, y) > 0.27
    x, y = x[outside], y[outside]
    body = Body(Circle(0.25), (0.5, 0.0), motion=RigidMotion(x=WallMotion(2.0)))
    # all moves along, and so would a body of fluid: psi = u r^2/2, to rounding in the fits
    assert np.abs(found(20, x, y, np.full(len(x), 2.0), (body,)) - y**2).max() < 1e-9


def test_stream_function_of_a_run_that_went_wrong_is_no_number():
    x, y = scattered(10)
    u = np.ones(len(x))
    u[3] = np.nan
    assert np.isnan(found(10, x, y, u)).all()
