"""Values of particles as a continuous field, dye, and paths of particles."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph.report.field import Dye, FieldGrid
from tisph.report.layout import arrange
from tisph.report.overlays import Tracks

SHAPE = 160, 240
SIZE = 1.5, 1.0
HOLE = 0.7, 0.4, 0.2


def places(rows, seed=0):
    """Disordered particles of a box of ``SIZE``, and their spacing."""
    spacing = 1.0 / rows
    x, y = np.meshgrid((np.arange(round(1.5 * rows)) + 0.5) * spacing, (np.arange(rows) + 0.5) * spacing)
    shift = np.random.default_rng(seed).uniform(-0.3, 0.3, (2, x.size)) * spacing
    return x.ravel() + shift[0], y.ravel() + shift[1], spacing


def pixels():
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]] + 0.5
    return columns / SHAPE[1] * SIZE[0], (1.0 - rows / SHAPE[0]) * SIZE[1]


def away(x, y):
    return np.hypot(x - HOLE[0], y - HOLE[1])


def test_a_linear_field_is_met_up_to_walls_and_around_a_hole():
    x, y, spacing = places(24)
    wet = away(x, y) > HOLE[2] + 0.3 * spacing
    grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (False, False))
    grid.fit(x[wet], y[wet], 2.0 + 3.0 * x[wet] - 5.0 * y[wet])
    column, row = pixels()
    error = np.abs(grid.image() - (2.0 + 3.0 * column - 5.0 * row))
    # what is added to second moments of about 1/3, less beside a wall, flattens slopes of 6 by some thousandths of a
    # spacing, and float32 is behind that
    assert np.nanmax(error[away(column, row) > HOLE[2]]) < 0.05 * 6.0 * spacing
    assert np.isfinite(error[away(column, row) > HOLE[2]]).all()
    assert np.isnan(grid.image()[away(column, row) < 0.02]).all()  # no particle is near
    x, y = np.array([0.2, 1.3]), np.array([0.01, 0.6])
    assert grid.at(x, y) == pytest.approx(2.0 + 3.0 * x - 5.0 * y, abs=0.02)


@pytest.mark.parametrize("periodic", [False, True])
def test_errors_fall_with_the_square_of_the_spacing(periodic):
    def wave(x, y):
        return np.sin(4.0 * np.pi * x / 3.0) * np.cos(2.0 * np.pi * y)

    errors = []
    for rows in (20, 40):
        x, y, spacing = places(rows)
        grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (periodic, periodic))
        grid.fit(x, y, wave(x, y))
        errors.append(np.sqrt(np.mean((grid.image() - wave(*pixels())) ** 2)))
    assert errors[0] / errors[1] > 3.2  # 4 but for disorder
    assert errors[1] < 3e-3


def test_a_field_goes_on_through_a_periodic_side():
    spacing = 1.0 / 40
    grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (True, True))
    x, y, _ = places(40)
    grid.fit(x + 0.4, y - 0.7, np.cos(4.0 * np.pi * (x + 0.4) / 3.0))  # some have left the box
    assert grid.image() == pytest.approx(np.cos(4.0 * np.pi * pixels()[0] / 3.0), abs=0.01)


def test_particles_that_are_no_numbers_leave_the_others_alone():
    x, y, spacing = places(20)
    grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (False, False))
    values = np.ones_like(x)
    values[5], x[8] = np.nan, np.inf
    grid.fit(x, y, values)
    assert grid.image() == pytest.approx(1.0, abs=1e-5)


def box():
    return SimpleNamespace(
        origin=(0.0, 0.0), extent=SIZE, periodic=(True, False), walls=(), bodies=(), spacing=0.05, acceleration=0.0
    )


@pytest.mark.parametrize("pattern", ["stripes", "checkerboard", "blob"])
def test_dye_stays_with_its_particles(pattern):
    x, y, _ = places(20)
    dye = Dye(box(), pattern)
    first = dye.of(SimpleNamespace(x=x, y=y))
    assert set(np.unique(first)) == {0.0, 1.0}
    assert np.array_equal(dye.of(SimpleNamespace(x=y, y=x)), first)
    share = {"stripes": 0.5, "checkerboard": 0.5, "blob": np.pi * 0.15**2 / 1.5}[pattern]
    assert first.mean() == pytest.approx(share, abs=0.02)


def test_a_track_follows_its_particle_and_ends_at_a_periodic_side():
    scene = box()
    layout = arrange(scene, 1280, 640)
    tracks, panel = Tracks(scene, layout), np.full((layout.box.height, layout.box.width, 3), 255, dtype=np.uint8)
    for t, x in ((0.0, 1.2), (1.0, 1.4), (2.0, 0.1), (3.0, 0.3)):
        panel[:] = 255
        tracks.paint(panel, SimpleNamespace(t=t, x=np.array([x]), y=np.array([0.5])))
    dark = np.flatnonzero(panel[:, :, 0].min(axis=0) < 100) / layout.pixels_per_length
    head = 4.0 * layout.scale / layout.pixels_per_length
    on_track = [(low - head < dark) & (dark < high + head) for low, high in ((1.2, 1.4), (0.1, 0.3))]
    assert np.logical_or(*on_track).all()
    assert all(part.any() for part in on_track)
    rows = np.flatnonzero(panel[:, :, 0].min(axis=1) < 100) / layout.pixels_per_length
    assert abs(rows.mean() - 0.5) < head
