"""The spacing that is wanted near bodies, in boxes and at points."""

import numpy as np
import pytest

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.wanted_spacing import InBox, NearBody, WantedSpacing


def test_spacing_grows_with_the_distance_from_a_circle():
    """Near a circle of radius 0.2 it is 0.01 up to 0.1 from the wall, then grows by a fifth of the distance."""
    circle = NearBody(Body(Circle(0.2), (0.5, 0.5)), 0.01, within=0.1)
    wanted = WantedSpacing(0.05, [circle], growth=0.2)
    places = np.stack([0.5 + np.array([0.2, 0.3, 0.35, 0.45, 1.0]), np.full(5, 0.5)], axis=1)
    # exact but for the rounding of places, 1e-16 times the growth
    np.testing.assert_allclose(wanted.at(places), [0.01, 0.01, 0.02, 0.04, 0.05], atol=1e-15)
    assert wanted.varies
    assert wanted.smallest == 0.01


def test_spacing_follows_a_body_that_moves():
    """A time t after the start it is that at rest, moved by the velocity times t."""
    moving = Body(Circle(0.1), (0.2, 0.5), motion=RigidMotion(WallMotion(0.5), WallMotion(0.0), WallMotion(0.0)))
    places = np.random.default_rng(0).uniform(size=(50, 2))
    now, later = (
        WantedSpacing(0.05, [NearBody(moving, 0.01)]).at(at, t)
        for at, t in ((places, 0.0), (places + np.array([0.1, 0.0]), 0.2))
    )
    np.testing.assert_allclose(now, later, atol=1e-15)


@pytest.mark.parametrize(("place", "expected"), [((0.98, 0.5), 0.01), ((0.9, 0.5), 0.018), ((0.5, 0.5), 0.03)])
def test_a_box_across_the_end_of_a_period_is_one(place, expected):
    """A box from -0.1 to 0.1 in a period of 1, and its copies, have the same distances."""
    wanted = WantedSpacing(0.03, [InBox((-0.02, 0.0), (0.02, 1.0), 0.01, periods=(1.0, 0.0))])
    assert wanted.at(np.array([place]))[0] == pytest.approx(expected, abs=1e-15)


def test_without_sources_there_is_one_spacing():
    """Everywhere it is the spacing of the flow, to the bit."""
    wanted = WantedSpacing(0.1)
    assert not wanted.varies
    assert (wanted.at(np.zeros((3, 2))) == 0.1).all()
