import numpy as np
import pytest

from tisph.report.layout import Rect
from tisph.report.text import fitting_size, paint_arrow, paint_text, text_width

BOX = Rect(10, 5, 34, 11)


def ink(share):
    """Coverage of the pixels of a frame with a black arrow, 0 to 1."""
    frame = np.full((30, 60, 3), 255, dtype=np.uint8)
    paint_arrow(frame, BOX, share, "#000000")
    return 1.0 - frame[:, :, 0] / 255.0


@pytest.mark.parametrize("share", [1.0, 0.6, 0.3, 0.15])
def test_arrow_has_the_area_of_its_head_and_shaft(share):
    length = share * BOX.width
    head = min(BOX.height, length)
    area = head**2 / 2 + BOX.height / 4 * max(0.0, length - head)
    # Sixteen samples a pixel: the rim, at most 2 (length + height) pixels, is off by a sixteenth on average.
    assert ink(share).sum() == pytest.approx(area, rel=0.06)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_arrow_is_centred_and_points_to_its_side(share):
    right, left = ink(share), ink(-share)
    columns = np.flatnonzero(right.sum(axis=0))
    assert abs((columns[0] + columns[-1] + 1) / 2 - (BOX.left + BOX.width / 2)) <= 0.5  # a pixel cut by the tip
    height = right.sum(axis=0)[columns[0] : columns[-1] + 1]
    assert np.all(np.diff(height[np.argmax(height) :]) < 0)  # a head that narrows to the right, ...
    assert height[1] == pytest.approx(BOX.height / 4, abs=0.25)  # ... and a shaft left of it; a sample is 1/4 pixel
    assert np.array_equal(left[BOX.slices], right[BOX.slices][:, ::-1])
    right[BOX.slices] = 0.0
    assert not right.any()


@pytest.mark.parametrize("share", [0.0, 0.05, -0.09])
def test_hardly_any_velocity_is_no_arrow(share):
    assert not ink(share).any()


def test_text_stands_at_its_side_of_the_box():
    centres = {}
    for side in ("left", "middle", "right"):
        frame = np.full((40, 200, 3), 255, dtype=np.uint8)
        paint_text(frame, Rect(20, 5, 150, 30), "word", 14, side, "#000000")
        columns = np.flatnonzero(frame[:, :, 0].min(axis=0) < 128)
        assert 20 <= columns[0] <= columns[-1] < 170
        centres[side] = columns.mean()
    # The box is 150 wide, the word about 37: two pixels for the space that a glyph keeps at its sides.
    half = text_width("word", 14) / 2
    expected = {"left": 20 + half, "middle": 95, "right": 170 - half}
    assert centres == pytest.approx(expected, abs=2.0)


def test_long_text_is_written_smaller_until_it_fits():
    assert fitting_size("word", 14, 100) == 14
    size = fitting_size("a long line of words", 14, 100)
    assert text_width("a long line of words", size) <= 100 < text_width("a long line of words", size + 1)
    assert fitting_size("word" * 100, 14, 1) == 6  # and no smaller: nobody could read it
