"""Ellipses: nearest points, arc lengths and radii against closed forms and symmetries, and as bodies of a config."""

import math

import numpy as np
import pytest
from scipy.special import ellipeinc
from typer.testing import CliRunner

from tisph import cli
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse

RANDOM = np.random.default_rng(5)
PLACES = RANDOM.uniform(-1.5, 1.5, (500, 2))
ROUND_OFF = 1e-14  # some tens of roundings of numbers of size 1

half_axes = pytest.mark.parametrize("half_axes", [(1.2, 0.5), (0.3, 1.0), (1.0, 0.05), (1.0, 1.0 - 1e-9), (1e-4, 1.0)])

CASE = """\
scene: lattice
fluid: {density: 2.0, kinematic_viscosity: 0.5}
geometry: {length: 1.0, height: 1.0}
bodies: [{type: ellipse, centre: [0.5, 0.5], half_axes: [0.3, 0.2], angle: 0.4}]
drive: {acceleration: 1.0}
discretisation: {particles_across: 32}
time: {end: 1.0}
"""


def on_ellipse(half_axes, angle):
    """Points (n, 2) at eccentric angles, and normals outwards, of length 1."""
    cosine, sine = np.cos(angle), np.sin(angle)
    normal = np.stack([half_axes[1] * cosine, half_axes[0] * sine], axis=1)
    point = np.stack([half_axes[0] * cosine, half_axes[1] * sine], axis=1)
    return point, normal / np.linalg.norm(normal, axis=1)[:, None]


@half_axes
def test_places_along_a_normal_have_its_foot(half_axes):
    """Outside at any distance, and inside up to the smallest radius, where no other point is nearer."""
    ellipse = Ellipse(half_axes)
    point, normal = on_ellipse(half_axes, RANDOM.uniform(0, 2 * np.pi, 400))
    for distance in (RANDOM.uniform(0, 3, 400), -RANDOM.uniform(0, 0.9, 400) * ellipse.smallest_radius):
        foot = ellipse.nearest(point + distance[:, None] * normal)
        assert np.abs(foot.distance - distance).max() < ROUND_OFF
        # a place that is off by round-off has a foot that is off by up to 10 times as much at 0.9 of a radius; its
        # normal is off by that over the radius
        assert np.abs(foot.point - point).max() < 10 * ROUND_OFF
        assert np.abs(foot.normal - normal).max() < 10 * ROUND_OFF * max(1.0, 1 / ellipse.smallest_radius)


@half_axes
def test_a_place_is_on_the_normal_of_its_foot(half_axes):
    """Everywhere, also on the axes, next to them, and at and next to the centres of curvature of all ends."""
    ellipse, (a, b) = Ellipse(half_axes), half_axes
    special = np.array([[0, 0], [a, 0], [0, -b], [0.4 * a, 0], [0, 0.4 * b], [a - b**2 / a, 0], [0, a**2 / b - b]])
    near = [special[:, None] + size * PLACES[:20] for size in (0.0, 1e-3, 1e-9, 1e-16, 1e-120)]
    places = np.concatenate([PLACES, *(each.reshape(-1, 2) for each in near)])
    foot = ellipse.nearest(places)
    scale = np.maximum(1.0, np.linalg.norm(places, axis=1))
    assert np.abs(np.hypot(*(foot.point / half_axes).T) - 1).max() < ROUND_OFF
    across = np.linalg.norm(foot.point + foot.distance[:, None] * foot.normal - places, axis=1)
    assert (across / scale).max() < ROUND_OFF
    outside = np.hypot(*(places / half_axes).T) - 1
    clear = np.abs(outside) > 1e-9  # nearer, the quotients of slender ellipses lose digits
    assert np.array_equal(foot.distance[clear] > 0, outside[clear] > 0)


@half_axes
def test_no_point_of_the_ellipse_is_nearer(half_axes):
    foot = Ellipse(half_axes).nearest(PLACES)
    wall, _ = on_ellipse(half_axes, 2 * np.pi * np.arange(4000) / 4000)
    brute = np.linalg.norm(PLACES[:, None] - wall, axis=2).min(axis=1)
    assert (np.abs(foot.distance) <= brute + ROUND_OFF).all()
    # half a step of the angle, 2 pi/8000, is 1/1270 of the longer half axis or less along the wall
    assert (brute <= np.abs(foot.distance) + max(half_axes) / 1270).all()


def test_the_centre_and_the_longer_axis_in_closed_form():
    """Up to the centre of curvature of an end, x = (a^2 - b^2)/a, the foot is at a^2 x/(a^2 - b^2); then at the end."""
    a, b = 1.25, 0.75
    x = np.array([0.0, 0.4, -0.4, 0.8, 1.0, -2.0])
    foot = Ellipse((a, b)).nearest(np.stack([x, np.zeros(6)], axis=1))
    along = np.clip(a**2 * x / (a**2 - b**2), -a, a)
    across = b * np.sqrt(1 - (along / a) ** 2)
    distance = [-0.75, *2 * [-b * math.sqrt(1 - 0.16)], -0.45, -0.25, 0.75]
    assert np.abs(foot.point - np.stack([along, across], axis=1)).max() < ROUND_OFF
    assert np.abs(foot.distance - distance).max() < ROUND_OFF
    assert np.abs(foot.curvature[[0, 4]] - [b / a**2, a / b**2]).max() < ROUND_OFF


@half_axes
def test_mirrored_places_have_mirrored_nearest_points(half_axes):
    ellipse, turned = Ellipse(half_axes), Ellipse(half_axes[::-1])
    foot = ellipse.nearest(PLACES)
    for signs in ((-1, 1), (1, -1), (-1, -1)):
        other = ellipse.nearest(PLACES * signs)
        assert np.array_equal(other.point, foot.point * signs)
        assert np.array_equal(other.normal, foot.normal * signs)
        assert np.array_equal(other.distance, foot.distance)
        assert np.array_equal(other.curvature, foot.curvature)
    swapped = turned.nearest(PLACES[:, ::-1])
    assert np.abs(swapped.point[:, ::-1] - foot.point).max() < ROUND_OFF
    assert np.abs(swapped.distance - foot.distance).max() < ROUND_OFF


def test_an_ellipse_of_equal_axes_is_the_circle():
    ellipse, circle = Ellipse((0.7, 0.7)), Circle(0.7)
    places = np.concatenate([PLACES, [[0.0, 0.0], [0.7, 0.0], [0.0, -0.1]]])
    pairs = (
        (ellipse.nearest(places), circle.nearest(places)),
        (ellipse.boundary_points(0.1), circle.boundary_points(0.1)),
    )
    for one, other in pairs:
        assert vars(one).keys() == vars(other).keys()
        for name, values in vars(one).items():
            assert np.abs(values - vars(other)[name]).max() < ROUND_OFF
    for name in ("length", "area", "smallest_radius", "convex_radius", "extent"):
        assert getattr(ellipse, name) == pytest.approx(getattr(circle, name), rel=1e-15)


@half_axes
@pytest.mark.parametrize("count", [7, 200])
def test_points_are_evenly_spaced_in_arc_length(half_axes, count):
    """By the incomplete elliptic integral of their eccentric angles."""
    ellipse, (a, b) = Ellipse(half_axes), half_axes
    wall = ellipse.boundary_points(ellipse.length / count)
    angle = np.unwrap(np.arctan2(wall.point[:, 1] / b, wall.point[:, 0] / a))
    arc = b * ellipeinc(angle, 1 - (a / b) ** 2)  # from (a, 0)
    assert np.abs(arc - (np.arange(count) + 0.5) * ellipse.length / count).max() < ROUND_OFF * ellipse.length
    assert wall.length == pytest.approx(ellipse.length / count, rel=1e-15)
    assert np.abs(wall.point[::-1] * [1, -1] - wall.point).max() < ROUND_OFF
    assert np.abs(ellipse.nearest(wall.point).distance).max() < ROUND_OFF


def test_length_area_and_radii_in_closed_form():
    ellipse = Ellipse((0.5, 2.0))
    # Gauss and Kummer: 2 pi A (1 + h/4 + h^2/64 + ...) with A = (a + b)/2, h = ((a - b)/(a + b))^2 = 0.36
    series = sum(math.prod((0.5 - j) / (j + 1) for j in range(k)) ** 2 * 0.36**k for k in range(40))
    assert ellipse.length == pytest.approx(math.pi * 2.5 * series, rel=1e-14)
    assert ellipse.area == pytest.approx(math.pi, rel=1e-15)
    assert (ellipse.smallest_radius, ellipse.convex_radius) == (0.125, 0.125)
    assert Ellipse((2.0, 0.5), "inside").smallest_radius == 0.125
    assert Ellipse((2.0, 0.5), "inside").convex_radius == math.inf
    assert ellipse.extent.tolist() == [[-0.5, -2.0], [0.5, 2.0]]


@pytest.mark.parametrize("half_axes", [(0.0, 1.0), (1.0, -1.0), (math.inf, 1.0), (1.0, math.nan)])
def test_half_axes_that_are_not_positive_are_refused(half_axes):
    with pytest.raises(ValueError, match="an ellipse needs two half axes above 0"):
        Ellipse(half_axes)


def check(path, *overrides):
    options = [part for override in overrides for part in ("--set", override)]
    return CliRunner().invoke(cli.app, ["check", str(path), *options])


def test_a_config_with_an_ellipse_is_checked(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    lines = [" ".join(line.split()) for line in check(path).stdout.splitlines()]
    fluid = 1.0 - math.pi * 0.3 * 0.2
    assert f"cell 1 x 1 m, {fluid:.4g} of it fluid" in lines
    assert f"fluid particles {round(fluid * 32**2)}" in lines
    assert any(line.startswith("smallest radius 0.1333 m, 4.27 spacings") for line in lines)


@pytest.mark.parametrize(("size", "said"), [
    ("[0.3, 0.1]", "bodies.0.half_axes = [0.3, 0.1]: an end of radius 0.03333 has 1.07 spacings; it needs at least 2"),
    ("[0.07, 0.075]", "bodies.0.half_axes = [0.07, 0.075]: a body 0.14 wide has 4.48 spacings; it needs at least 5"),
    ("[0.2, 0.48]", "its own periodic copy"),
])  # fmt: skip
def test_what_is_too_small_of_an_ellipse_is_said(tmp_path, size, said):
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    result = check(path, f"bodies=[{{type: ellipse, centre: [0.5, 0.5], half_axes: {size}}}]")
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())
