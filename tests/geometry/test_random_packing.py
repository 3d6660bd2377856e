"""Circles at random places: none too close to another, to a copy or a wall; the same ones for a seed."""

import math

import numpy as np
import pytest

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.line import Line
from tisph.geometry.packing import random_centres
from tisph.geometry.region import Region

PLANES = (Body(Line((0, 0), (1, 0), 2.0)), Body(Line((0, 1), (-1, 0), 2.0)))
REGIONS = {
    "cell": Region((), (0.0, 0.0), (2.0, 1.0), (True, True)),
    "channel": Region(PLANES, (0.0, 0.0), (2.0, 1.0), (True, False)),
    "round": Region((Body(Circle(0.8, "inside"), (3.0, 1.0)),), (2.2, 0.2), (3.8, 1.8)),
}
GAP = 0.03
FRACTIONS = {"sequential": 0.25, "pushed apart": 0.45}
"""With half the gap counted 0.33, which random sequential addition reaches, and 0.6, which it does not (0.547)."""


def number(region, radius, fraction):
    return round(fraction * region.area / (math.pi * radius**2))


def gaps(region, radii, centres):
    """All gaps, by brute force: those of circles and all copies around them, then those of walls."""
    steps = [(-1, 0, 1) if periodic else (0,) for periodic in region.periodic]
    for step in np.array(np.meshgrid(*steps)).reshape(2, -1).T:
        apart = np.linalg.norm(centres[:, None] - centres - step * region.size, axis=-1) - radii - radii[:, None]
        yield apart[~np.eye(len(radii), dtype=bool)] if not step.any() else apart.ravel()
    yield region.distance(centres) - radii


@pytest.mark.parametrize("region", REGIONS.values(), ids=REGIONS)
@pytest.mark.parametrize("fraction", FRACTIONS.values(), ids=FRACTIONS)
def test_circles_copies_and_walls_keep_the_gap(region, fraction):
    radii = np.full(number(region, 0.1, fraction), 0.1)
    centres = random_centres(radii, region, GAP, seed=3)
    assert centres.shape == (len(radii), 2)
    assert ((centres >= region.low) & (centres <= region.high)).all()
    assert min(found.min() for found in gaps(region, radii, centres)) >= GAP - 1e-14  # rounding of lengths of 1


def test_a_seed_gives_the_same_places_and_another_others():
    for fraction in FRACTIONS.values():
        radii = np.full(number(REGIONS["cell"], 0.1, fraction), 0.1)
        first, again, other = (random_centres(radii, REGIONS["cell"], GAP, seed) for seed in (1, 1, 2))
        assert first.tobytes() == again.tobytes()
        assert np.abs(first - other).max() > 0.1


def test_radii_keep_their_order_in_a_mixture():
    region, radii = REGIONS["channel"], np.array([0.05] * 20 + [0.15] * 8 + [0.08] * 5)
    centres = random_centres(radii, region, GAP)
    assert min(found.min() for found in gaps(region, radii, centres)) >= GAP - 1e-14


def test_places_of_one_circle_are_uniform():
    """Mean and variance over seeds, within four standard errors, of the interval that walls leave, and of a period."""
    seeds, region = range(400), REGIONS["channel"]
    places = np.concatenate([random_centres([0.2], region, 0.0, seed) for seed in seeds])
    for low, high, column in ((0.0, 2.0, places[:, 0]), (0.2, 0.8, places[:, 1])):
        length = high - low
        assert abs(column.mean() - (low + high) / 2) < 4 * length / math.sqrt(12 * len(seeds))
        # the fourth central moment is length^4/80: the sample variance deviates by length^2 sqrt((1/80 - 1/144)/n)
        assert abs(column.var() - length**2 / 12) < 4 * length**2 * math.sqrt((1 / 80 - 1 / 144) / len(seeds))


def test_what_does_not_fit_has_no_places():
    cell, channel = REGIONS["cell"], REGIONS["channel"]
    assert random_centres([0.49], cell, GAP) is None  # its own copies are 0.02 away
    assert random_centres([0.48], channel, GAP) is None
    dense = number(cell, 0.1, math.pi / math.sqrt(12)) + 1  # more than the densest packing of circles
    assert random_centres([0.1] * dense, cell) is None
    assert random_centres([0.1] * number(cell, 0.1, 0.9), cell) is None  # less, but more than sweeps find


def test_no_circles_have_no_places():
    assert random_centres([], REGIONS["cell"]).shape == (0, 2)
