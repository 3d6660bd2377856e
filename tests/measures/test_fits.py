"""Velocity gradients, stream function and spread of particles: exact on polynomials, and of the order they claim."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.wanted_spacing import WantedSpacing
from tisph.measures.fits import interpolated, max_void_radius, min_distance, stream_function, velocity_gradients
from tisph.snapshot import Snapshot

WAVE = 2 * np.pi


def box(rows, periodic=(True, True)):
    flow = {"origin": (0.0, 0.0), "bodies": (), "extent": (1.0, 1.0), "periodic": periodic, "spacing": 1.0 / rows}
    return SimpleNamespace(**flow, wanted_spacing=WantedSpacing(1.0 / rows))


def scattered(rows, jitter=0.2, seed=0):
    y, x = (np.indices((rows, rows)) + 0.5) / rows
    shift = jitter / rows * np.random.default_rng(seed).uniform(-1.0, 1.0, (2, rows * rows))
    return x.ravel() + shift[0], y.ravel() + shift[1]


def snapshot(x, y, u, v):
    return Snapshot(t=0.0, step=0, x=x, y=y, u=u, v=v, density=np.ones_like(x), pressure=0 * x)


@pytest.mark.parametrize("degree", [2, 4])
def test_polynomials_are_differentiated_exactly(degree):
    x, y = scattered(12, jitter=0.3)
    u, v = x**degree - 2 * x * y, 3 * y**degree + x
    found = velocity_gradients(box(12, periodic=(False, False)), snapshot(x, y, u, v), degree)
    exact = degree * x ** (degree - 1) - 2 * y, -2 * x, 1.0, 3 * degree * y ** (degree - 1)
    # velocities of order 1, fitted over a few spacings of 1/12 by matrices of condition numbers up to 1e6
    assert [np.abs(one - other).max() < 1e-9 for one, other in zip(found, exact, strict=True)] == [True] * 4


def gradient_error(rows, degree):
    x, y = scattered(rows)
    u, v = np.sin(WAVE * x) * np.cos(WAVE * y), np.cos(WAVE * (x + y))
    found = velocity_gradients(box(rows), snapshot(x, y, u, v), degree)
    exact = (
        WAVE * np.cos(WAVE * x) * np.cos(WAVE * y),
        -WAVE * np.sin(WAVE * x) * np.sin(WAVE * y),
        -WAVE * np.sin(WAVE * (x + y)),
        -WAVE * np.sin(WAVE * (x + y)),
    )
    return max(np.abs(one - other).max() for one, other in zip(found, exact, strict=True)) / WAVE


@pytest.mark.parametrize("degree", [2, 4])
def test_errors_fall_with_the_degree_across_periodic_edges(degree):
    errors = [gradient_error(rows, degree) for rows in (16, 32, 64)]
    # of random arrangements, whose worst place is another one each time: half an order of play
    assert np.log2(errors[0] / errors[2]) / 2 > degree - 0.5


def test_what_is_no_number_has_no_gradient():
    x, y = scattered(12)
    assert np.isnan(velocity_gradients(box(12), snapshot(x, y, np.full_like(x, np.nan), x))).all()


@pytest.mark.parametrize("periodic", [(True, True), (True, False), (False, False)])
def test_spread_of_a_lattice(periodic):
    x, y = scattered(12, jitter=0.0)
    scene = box(12, periodic)
    # coordinates of order 1 round to 1e-16, distances are a twelfth
    assert min_distance(scene, snapshot(x, y, x, x)) == pytest.approx(1.0, rel=1e-13)
    assert max_void_radius(scene, snapshot(x, y, x, x)) == pytest.approx(np.sqrt(0.5), rel=1e-12)


def test_a_void_across_the_edge_of_a_box_is_found():
    x, y = (np.delete(values, 0) for values in scattered(12, jitter=0.0))
    scene = SimpleNamespace(origin=(0.0, 0.0), bodies=(), extent=(3.0, 3.0), periodic=(True, True), spacing=0.25)
    assert max_void_radius(scene, snapshot(3.0 * x, 3.0 * y, x, x)) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("place", [0, 77])
def test_a_missing_particle_is_a_void_wherever_it_is(place):
    x, y = (np.delete(values, place) for values in scattered(12, jitter=0.0))
    assert max_void_radius(box(12), snapshot(x, y, x, x)) == pytest.approx(1.0, rel=1e-12)  # as above


def test_the_least_distance_is_found_across_an_edge():
    x, y = scattered(12, jitter=0.0)
    x[0], x[11] = 0.01, 0.99  # both of the lowest row
    assert min_distance(box(12), snapshot(x, y, x, x)) == pytest.approx(0.02 * 12, rel=1e-12)  # as above


def test_spread_is_in_widths_of_the_particles():
    """Logarithmic rings: a square lattice under exp, so that the widths of particles are s r at the radius r."""
    s = np.pi / 60
    ring, turn = np.meshgrid(np.arange(-25, 10), np.arange(31))
    x, y = (np.exp(s * ring) * each(s * turn) for each in (np.cos, np.sin))
    rings = replace(snapshot(*(each.ravel() for each in (x, y, x, y))), area=(s * np.exp(s * ring.ravel())) ** 2)
    scene = SimpleNamespace(**{**vars(box(12, (False, False))), "origin": (0.4, 0.4), "extent": (0.5, 0.5)})
    assert min_distance(scene, rings) == pytest.approx((1 - np.exp(-s)) / s, rel=1e-12)  # from the ring within
    centre = 0.5 * (1 + np.exp(s)) / np.cos(0.5 * s)  # of the circle through four particles, for the inner radius 1
    assert max_void_radius(scene, rings) == pytest.approx(np.sqrt(centre**2 - np.exp(s)) / (s * np.exp(s)), rel=1e-9)


def wave_error(rows):
    x, y = scattered(rows)
    points = np.random.default_rng(1).random((500, 2))
    scene = SimpleNamespace(origin=(0.0, 0.0), bodies=(), extent=(1.0, 1.0), periodic=(True, True), parallel=False)
    found = interpolated(scene, np.stack([x, y], 1), (np.sin(WAVE * x) * np.cos(WAVE * y))[:, None], points)
    return np.abs(found[:, 0] - np.sin(WAVE * points[:, 0]) * np.cos(WAVE * points[:, 1])).max()


def test_values_between_particles_are_of_seventh_order():
    errors = [wave_error(rows) for rows in (20, 40)]
    assert errors[0] < 1e-5
    # degree 6: 2^7 = 128 on end, and from one arrangement to the other half as much scatter
    assert errors[0] / errors[1] > 64


def test_values_of_parallel_flow_need_no_more_than_rows():
    y, x = (np.indices((12, 10)).reshape(2, -1) + 0.5) / 12
    box = {"origin": (0.0, 0.0), "extent": (10 / 12, 1.0), "periodic": (True, False)}
    scene = SimpleNamespace(bodies=(), parallel=True, columns=10, **box)
    points = np.array([[0.0, 0.01], [0.3, 0.5], [0.8, 0.97]])
    found = interpolated(scene, np.stack([x, y], 1), (y**4 - y)[:, None], points)
    # one-sided fits of degree 4 have condition numbers up to 1e8
    assert np.abs(found[:, 0] - (points[:, 1] ** 4 - points[:, 1])).max() < 1e-8


def stream_function_in_cylinder(rows, x, y, u, bodies=()):
    """psi in a cylinder of radius 1 around the axis, one period long."""
    scene = SimpleNamespace(
        origin=(0.0, 0.0), extent=(1.0, 1.0), periodic=(True, False), spacing=1 / rows, bodies=bodies,
        wanted_spacing=WantedSpacing(1 / rows), seen=lambda snapshot: scene,
    )  # fmt: skip
    return stream_function(scene, SimpleNamespace(t=0.0, x=x, y=y, u=u, v=0 * u))


def test_stream_function_of_vortices_in_a_pipe_is_of_third_order():
    errors = []
    for rows in (16, 32):
        x, y = scattered(rows)
        exact = np.cos(WAVE * x) * y**2 * (1 - y)
        found = stream_function_in_cylinder(rows, x, y, np.cos(WAVE * x) * (2 - 3 * y))
        errors.append(np.abs(found - exact).max() / np.ptp(exact))
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] > 2**2.5  # fits of degree 2 have errors of the third power of the spacing


def test_stream_function_goes_on_behind_a_body_that_moves():
    x, y = scattered(20)
    outside = np.hypot(x - 0.5, y) > 0.27
    x, y = x[outside], y[outside]
    body = Body(Circle(0.25), (0.5, 0.0), motion=RigidMotion(x=WallMotion(2.0)))
    # all moves along, and so would a body of fluid: psi = u r^2/2, to rounding in the fits
    assert np.abs(stream_function_in_cylinder(20, x, y, np.full(len(x), 2.0), (body,)) - y**2).max() < 1e-9


def test_stream_function_of_a_run_that_went_wrong_is_no_number():
    x, y = scattered(10)
    u = np.ones(len(x))
    u[3] = np.nan
    assert np.isnan(stream_function_in_cylinder(10, x, y, u)).all()
