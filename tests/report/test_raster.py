import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tisph.report.raster import LEVELS, PLACES, SHARES, STRIPS, VALUE_BITS, Discs, dense_line, filled

SHAPE = (40, 60)


def points(column, row):
    return np.atleast_1d(np.asarray(column, float)), np.atleast_1d(np.asarray(row, float))


PLACE = 0.5 / PLACES  # pixels: a disc stands at most this far from where it should, along each direction
LEVEL = 0.5 / LEVELS  # of coverage, to the nearest


def paint(place, value, radius, shape=SHAPE, *, periodic=(False, False)):
    """Coverage (0 to 1) and mean value in every pixel."""
    total, full = Discs(radius, shape).sums(place, value, np.zeros(len(value), dtype=int), periodic=periodic)
    coverage, values = np.divmod(total, 1 << VALUE_BITS)
    return np.minimum(coverage / full, 1.0), values / (SHARES * np.maximum(coverage, 1))


def cover(place, radius, shape):
    return Discs(radius, shape).cover(place) / LEVELS


def disc(column, row, radius=3.5, value=1.0, *, periodic=(False, False)):
    place = points(column, row)
    values = np.broadcast_to(np.asarray(value, float), place[0].shape)
    return paint(place, values, radius, periodic=periodic)


@given(column=st.floats(20.0, 40.0), row=st.floats(15.0, 25.0), radius=st.floats(1.5, 10.0))
def test_disc_has_the_right_centroid_and_area(column, row, radius):
    coverage, _ = disc(column, row, radius)
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]] + 0.5
    total = coverage.sum(dtype=float)
    # Sampling the one-pixel rim at pixel centres: over all sub-pixel offsets and these radii a scan finds at
    # most 0.051 pixel and 4.3 % of the area pi (r^2 + 1/12), both at the smallest radii.
    assert (coverage * columns).sum(dtype=float) / total == pytest.approx(column, abs=0.06 + PLACE)
    assert (coverage * rows).sum(dtype=float) / total == pytest.approx(row, abs=0.06 + PLACE)
    assert total == pytest.approx(np.pi * (radius**2 + 1 / 12), rel=0.05)


def test_disc_across_the_periodic_edge_is_the_same_disc_rolled():
    middle, _ = disc([30.25, 33.0], [20.5, 12.0], periodic=(True, False))
    edge, _ = disc([0.25, 3.0], [20.5, 12.0], periodic=(True, False))
    assert np.array_equal(edge, np.roll(middle, 30, axis=1))  # 30 columns are half the panel
    assert edge[20, -1] > 0.9


def test_discs_of_several_sizes_are_those_of_one_size_each():
    place, value, radii = points([20.3, 40.8], [20.6, 19.1]), np.array([0.2, 0.7]), np.array([8.0, 3.3])
    both = Discs(radii, SHAPE).sums(place, value, np.arange(2), periodic=(False, False))[0]
    each = [
        Discs(radii[k], SHAPE).sums(points(place[0][k], place[1][k]), value[[k]], np.array([0]), periodic=(False,) * 2)
        for k in range(2)
    ]
    assert np.array_equal(both, each[0][0] + each[1][0])


def test_particles_at_nan_or_infinity_or_outside_leave_no_trace():
    coverage, _ = disc([np.nan, np.inf, -np.inf, 30.0, -50.0], [20.0, 20.0, 20.0, np.nan, 20.0], periodic=(True, False))
    assert coverage.max() == 0.0


@pytest.mark.parametrize("count", [50, 100_000])
def test_any_number_of_discs_that_tile_the_panel_cover_it(count):
    shape = (280, 560)
    spacing = np.sqrt(shape[0] * shape[1] / count)
    across = max(1, round(shape[0] / spacing))
    rows, columns = np.mgrid[:across, : 2 * across] + 0.5
    place = points(columns.ravel() * shape[1] / (2 * across), rows.ravel() * shape[0] / across)
    coverage, _ = paint(place, np.ones(place[0].size), max(1.5, spacing) / 2, shape, periodic=(True, False))
    # Touching discs cover pi / 4 of the plane; the soft rim adds, and the smallest discs overlap.
    assert 0.75 < coverage.mean() <= 1.0


def test_line_through_dense_points_has_the_same_thickness_everywhere():
    line = dense_line(points([5.0, 55.0], [5.0, 35.0]))
    mask = cover(line, 1.0, SHAPE)
    length = np.hypot(50.0, 30.0)
    # Width 2 x radius, plus a cap at each end; points every half pixel leave a ripple below 2 %.
    assert mask.sum() == pytest.approx(2.0 * length + np.pi, rel=0.03)


def test_more_discs_in_one_pixel_than_anyone_draws_stay_within_the_scale():
    # the sums of 20 000 coverages and of their values do not fit beside each other in one number
    place = points([30.5] * 20_000, [20.5] * 20_000)
    coverage, value = paint(place, np.full(20_000, 0.5), 3.0)
    assert coverage.max() == 1.0
    assert 0.0 <= value.min() <= value.max() <= 1.1  # of no use, and harmless


STRIP = 0.5 / STRIPS  # of a pixel row: an upper or lower edge is at most this far from where it should be


@pytest.mark.parametrize("turned", [1, -1])
def test_rectangle_covers_the_part_of_each_pixel_that_is_in_it(turned):
    left, right, top, bottom = 10.3, 30.75, 4.0, 20.5
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])[::turned]
    inside = [np.clip(np.minimum(k + 1, b) - np.maximum(k, a), 0, 1) for k, a, b in
              ((np.arange(SHAPE[0]), top, bottom), (np.arange(SHAPE[1]), left, right))]  # fmt: skip
    assert np.abs(filled(corners.T, SHAPE) / LEVELS - np.outer(*inside)).max() <= STRIP + LEVEL


@given(column=st.floats(-10.0, 70.0), row=st.floats(-10.0, 50.0), radius=st.floats(0.2, 80.0))
def test_polygon_covers_its_area_and_is_cut_off_at_the_edges(column, row, radius):
    angle = np.linspace(0.0, 2 * np.pi, 80, endpoint=False)
    corners = column + radius * np.cos(angle), row + radius * np.sin(angle)
    coverage = filled(corners, SHAPE) / LEVELS
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]] + 0.5
    away = np.hypot(columns - column, rows - row)
    assert np.all(coverage[away < radius * np.cos(np.pi / 80) - 0.75] == 1.0)  # half a pixel's diagonal, and less
    assert np.all(coverage[away > radius + 0.75] == 0.0)
    wide = tuple(3 * side for side in SHAPE)
    shifted = filled((corners[0] + SHAPE[1], corners[1] + SHAPE[0]), wide) / LEVELS
    assert np.allclose(shifted[SHAPE[0] : 2 * SHAPE[0], SHAPE[1] : 2 * SHAPE[1]], coverage, atol=LEVEL)
    if radius < 30:
        # the first and last strip may be wrong by what they are long, 2 sqrt(2 r strip), and pixels of the edge rounded
        exact = 0.5 * 80 * np.sin(2 * np.pi / 80) * radius**2
        error = 4 * np.sqrt(2 * radius / STRIPS) / STRIPS + 8 * (radius + 1) * LEVEL
        assert shifted.sum() == pytest.approx(exact, abs=error)
