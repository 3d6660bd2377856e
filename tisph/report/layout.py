"""Where everything stands in a movie frame: pixel rectangles for any frame size and any shape of the box."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.report import style
from tisph.scenes._scene import Scene

LONGEST_SHOWN = 4.0  # heights: of a longer box this much is shown, or its discs would be too small to see
LONGEST_OPEN = 8.0  # heights likewise of a box that fluid flows through, whose ends are part of the flow
RIM = 0.04  # of the longer side of a box that bodies bound: so much of them is shown
_LEAST_PANEL = 340, 170  # pixels in a frame of 1280 x 640: width and height of a panel beside the box
_LEAST_BOX = 400  # pixels likewise: width of the box with the labels beside it
_GAP = 90, 78  # pixels likewise: between panels, for tick labels and names


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

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.height, self.width

    @property
    def inner(self) -> "Rect":
        """The rectangle without its border, where the lines of axes are."""
        return Rect(self.left + 1, self.top + 1, self.width - 2, self.height - 2)


@dataclass(frozen=True)
class Layout:
    """The parts of a frame of ``width`` x ``height`` pixels.

    ``scale`` is the size of text and lines relative to a frame of 1280 x 640; ``low`` and ``high`` are the corners of
    the shown part of the box, ``shown_length`` is its length along x; ``pixels_per_length`` is the same along x and y.
    ``box``, ``profile``, ``series``, ``time_label``, ``error_label`` and the velocities on walls that oscillate are all
    that changes from frame to frame. Left of the column ``split``, beside walls, there is room for their labels.
    ``time_label`` and ``error_label`` share a row.
    """

    width: int
    height: int
    theme: style.Theme
    scale: float
    split: int
    low: tuple[float, float]
    high: tuple[float, float]
    shown_length: float
    pixels_per_length: float
    box: Rect
    profile: Rect
    series: Rect
    colour_bar: Rect
    time_label: Rect
    error_label: Rect
    wall_thickness: int

    def pixel_positions(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Return columns and rows in the box [pixels] of positions ``x`` and ``y``."""
        return (x - self.low[0]) * self.pixels_per_length, (self.high[1] - y) * self.pixels_per_length

    def wall(self, side: str) -> Rect:
        """The bar of the ``top`` or ``bottom`` wall."""
        top = self.box.top - self.wall_thickness if side == "top" else self.box.bottom
        return Rect(self.box.left, top, self.box.width, self.wall_thickness)

    def pixels(self, size: float) -> int:
        """Return ``size``, given in pixels of a frame of 1280 x 640, in pixels of this frame."""
        return max(1, round(size * self.scale))


def arrange(scene: Scene, width: int, height: int, theme: style.Theme = style.LIGHT) -> Layout:
    """Return the layout of a frame for the box of ``scene``, both axes to the same scale.

    There is space for plane walls where it has some, and a rim around the box where bodies bound it. The two panels are
    beside the box or below it, as lets the box be larger.
    """
    rim = 0.0 if scene.walls or not scene.bodies else RIM * max(scene.extent)
    rims = np.where(scene.periodic, 0.0, rim)
    low, (size_x, size_y) = np.subtract(scene.origin, rims), np.add(scene.extent, 2 * rims)
    scale = min(width / 1280.0, height / 640.0)

    def px(size: float) -> int:
        return max(1, round(size * scale))

    longest = LONGEST_OPEN if scene.flows_through else LONGEST_SHOWN
    shown = min(size_x, longest * size_y)
    wall = px(22) if scene.walls else 0
    left, top, bar, right = px(84), px(102) + wall, px(96), width - px(28)
    under, panel_width, panel_height = wall + px(56), px(_LEAST_PANEL[0]), px(_LEAST_PANEL[1])
    beside = right - panel_width - px(_GAP[0]) - bar - left, height - under - top
    below = right - bar - left, height - under - px(30) - panel_height - px(56) - top
    fits = [min(columns / shown, rows / size_y) for columns, rows in (beside, below)]
    pixels_per_length = max(fits)
    box_width, box_height = round(shown * pixels_per_length), round(size_y * pixels_per_length)
    if fits[0] >= fits[1]:
        box = Rect(left, top + (beside[1] - box_height) // 2, max(2, box_width), max(2, box_height))
        split = max(box.right + bar, left + px(_LEAST_BOX) if scene.walls or any(scene.drive_shown[2]) else 0)
        region = Rect(split + px(_GAP[0]), top, 0, height - px(56) - top)
    else:
        box = Rect(left + (below[0] - box_width) // 2, top, max(2, box_width), max(2, box_height))
        split = width - px(8)
        region = Rect(left, box.bottom + under + px(30), 0, height - px(56) - box.bottom - under - px(30))
    profile, series = _panels(Rect(region.left, region.top, right - region.left, region.height), px)
    return Layout(
        width, height, theme, scale, split, tuple(low), (low[0] + shown, low[1] + size_y), shown,
        pixels_per_length, box=box, profile=profile, series=series,
        colour_bar=_colour_bar(box, px, px(10) if wall else 0),
        time_label=Rect(px(24), px(47), width // 2, px(26)),
        error_label=Rect(width // 2 + px(24), px(47), width - width // 2 - px(50), px(26)),
        wall_thickness=wall,
    )  # fmt: skip


def open_ends(scene: Scene) -> np.ndarray:
    """Return x (2,) of the first and the last open end [length], infinite without any."""
    ends = [body.shape.extent[0, 0] for body in scene.bodies if not body.solid] or [-np.inf, np.inf]
    return np.sort(ends)[[0, -1]]


def _panels(region: Rect, px: Callable[[float], int]) -> tuple[Rect, Rect]:
    """Return the rectangles of profile and series in ``region``: side by side, or one above the other."""
    across, down = px(_GAP[0]), px(_GAP[1])
    if region.width > 1.6 * region.height:
        wide = (region.width - across) // 2
        first, second = (Rect(left, region.top, wide, region.height) for left in (region.left, region.right - wide))
        return first, second
    high = (region.height - down) // 2
    first, second = (Rect(region.left, top, region.width, high) for top in (region.top, region.bottom - high))
    return first, second


def _colour_bar(box: Rect, px: Callable[[float], int], shorter: int) -> Rect:
    """Return the rectangle of the colour bar at the right of ``box``, ``shorter`` at both ends, but not very low."""
    height = max(box.height - 2 * shorter, px(90))
    return Rect(box.right + px(14), box.top + (box.height - height) // 2, px(12), height)
