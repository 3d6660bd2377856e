"""Where everything stands in a movie frame: pixel rectangles for any frame size and any shape of the box."""

from dataclasses import dataclass

import numpy as np

LONGEST_SHOWN = 4.0  # heights: of a longer box this much is shown, or its discs would be too small to see
RIM = 0.04  # of the longer side of a box that bodies bound: so much of them is shown


@dataclass(frozen=True)
class Rect:
    """A rectangle of whole pixels, from the top-left corner of the frame."""

    left: int
    top: int
    width: int
    height: int

    @property
    def right(self) -> int:
        """First column beyond the rectangle."""
        return self.left + self.width

    @property
    def bottom(self) -> int:
        """First row beyond the rectangle."""
        return self.top + self.height

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of the rectangle in a frame (rows, columns, 3)."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


@dataclass(frozen=True)
class Layout:
    """The parts of a frame of ``width`` x ``height`` pixels.

    ``scale`` is the size of text and lines relative to a frame of 1280 x 640; ``low`` is the lowest corner of the box
    and ``high`` the highest of what is drawn of it, ``shown_length`` (length) along x; ``pixels_per_length`` is the
    same along x and y.
    ``box``, ``profile``, ``time_label``, ``error_label`` and the velocities on walls that oscillate are all that
    changes from frame to frame. The columns left of ``split`` belong to the box, those right of it to the profile.
    """

    width: int
    height: int
    scale: float
    split: int
    low: tuple[float, float]
    high: tuple[float, float]
    shown_length: float
    pixels_per_length: float
    box: Rect
    profile: Rect
    colour_bar: Rect
    time_label: Rect
    error_label: Rect
    wall_thickness: int

    def pixel_positions(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return columns and rows in the box [pixels] of positions ``x`` and ``y``."""
        return (x - self.low[0]) * self.pixels_per_length, (self.high[1] - y) * self.pixels_per_length

    def wall(self, side: str) -> Rect:
        """The bar of the ``top`` or ``bottom`` wall."""
        top = self.box.top - self.wall_thickness if side == "top" else self.box.bottom
        return Rect(self.box.left, top, self.box.width, self.wall_thickness)

    def pixels(self, size: float) -> int:
        """Return ``size``, given in pixels of a frame of 1280 x 640, in pixels of this frame."""
        return max(1, round(size * self.scale))


def arrange(scene, width: int, height: int) -> Layout:
    """Return the layout of a frame for the box of ``scene``, both axes to the same scale.

    There is space for plane walls where it has some, and a rim around the box where bodies bound it.
    """
    rim = 0.0 if scene.walls or not scene.bodies else RIM * max(scene.extent)
    rims = np.where(scene.periodic, 0.0, rim)
    low, (size_x, size_y) = np.subtract(scene.origin, rims), np.add(scene.extent, 2 * rims)
    scale = min(width / 1280.0, height / 640.0)

    def px(size: float) -> int:
        return max(1, round(size * scale))

    split = round(0.62 * width)  # box to the left, profile to the right
    wall = px(22) if scene.walls else 0
    left, right, top, bottom = px(84), split - px(8), px(92) + wall, height - px(142) - wall
    shown = min(size_x, LONGEST_SHOWN * size_y)
    pixels_per_length = min((right - left) / shown, (bottom - top) / size_y)
    box = _centred(left, right, (top + bottom) // 2, shown * pixels_per_length, size_y * pixels_per_length)
    profile_height = max(box.height, round(0.8 * (bottom - top)))
    profile = _centred(split + px(88), width - px(26), (top + bottom) // 2, width, profile_height)
    half = profile.width // 2
    return Layout(
        width, height, scale, split, tuple(low), (low[0] + shown, low[1] + size_y), shown, pixels_per_length,
        box=box, profile=profile,
        colour_bar=_centred(left, right, height - px(57), max(box.width, px(360)), px(12)),
        time_label=Rect(px(24), px(47), split - px(24), px(26)),
        error_label=Rect(profile.right - half, profile.top - px(31), half, px(24)),
        wall_thickness=wall,
    )  # fmt: skip


def _centred(left: int, right: int, middle: int, width: float, height: float) -> Rect:
    """Return a rectangle centred on row ``middle`` and from ``left`` to ``right``, no wider than that."""
    columns, rows = max(2, min(right - left, round(width))), max(2, round(height))
    return Rect(left + (right - left - columns) // 2, middle - rows // 2, columns, rows)
