"""Text and arrows that change from frame to frame, laid over an RGB picture (rows, columns, 3) of uint8.

With them the velocities of the walls and the body acceleration are drawn.
"""

import math
from functools import lru_cache
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from tisph.geometry.motion import WallMotion
from tisph.report import style
from tisph.report.labels import fixed_point, number, unit_label
from tisph.report.layout import Layout, Rect
from tisph.report.raster import blend, filled
from tisph.scenes._scene import Scene

_SMALLEST = 6  # pixels: the smallest font that a text may shrink to


def text_width(text: str, size: int) -> float:
    """Return the width of ``text`` in pixels at font ``size`` in pixels."""
    return style.text_font(size).getlength(text)


def fitting_size(text: str, size: int, width: float) -> int:
    """Return the largest font size up to ``size`` at which ``text`` is at most ``width`` pixels wide."""
    while size > _SMALLEST and text_width(text, size) > width:
        size -= 1
    return size


def paint_text(
    frame: np.ndarray, box: Rect, text: str, size: int, side: str, colour: str, rim: str | None = None
) -> None:
    """Write one line over the picture in ``box``, at its ``left`` or ``right`` side or its ``middle``.

    ``rim``: colour of a rim around the letters, which is seen on any ground.
    """
    image = Image.fromarray(frame[box.slices])
    place, anchor = {"left": (0, "lm"), "right": (box.width, "rm"), "middle": (box.width / 2, "mm")}[side]
    draw = ImageDraw.Draw(image)
    font, wide = style.text_font(size), 2 if rim else 0
    draw.text((place, box.height / 2), text, colour, font, anchor, stroke_width=wide, stroke_fill=rim)
    frame[box.slices] = np.asarray(image)


def paint_arrow(frame: np.ndarray, box: Rect, share: float, colour: str) -> None:
    """Draw a horizontal arrow in the middle of ``box``, over |share| <= 1 of its width, to the left if negative.

    Its head is as high as ``box``, its shaft a quarter of that. Below a tenth of the width there is none: a
    few pixels of a head show no direction.
    """
    if abs(share) < 0.1:
        return
    coverage = _arrow_coverage(box.width, box.height, abs(share) * box.width)
    blend(frame[box.slices], coverage if share > 0 else coverage[:, ::-1], style.rgb(colour))


@lru_cache(maxsize=4)  # all arrows of a wall are alike
def _arrow_coverage(width: int, height: int, length: float) -> np.ndarray:
    """Return how much (0 to 255) of every pixel of a box an arrow of ``length`` pixels to the right covers."""
    head = min(height, length)  # as long as it is high
    neck, tip = (width + length) / 2 - head, (width + length) / 2
    column = np.array([tip - length, neck, neck, tip, neck, neck, tip - length])
    aside = np.array([1 / 8, 1 / 8, head / height / 2, 0.0, -head / height / 2, -1 / 8, -1 / 8])
    return filled((column, (0.5 + aside) * height), (height, width))


_ARROW, _HEAD, _PITCH = 34, 11, 120  # pixels in a frame of 1280 x 640: length and height of arrows, their distance


class WallLabel:
    """The velocity of a wall, written on its bar between arrows, or beside a bar that is too short for both.

    A wall at rest has no arrow, and a label only if it moved before t = 0. ``box`` is the place of the words,
    ``font_size`` theirs, ``animated`` whether they have to be painted anew for every frame.
    """

    def __init__(self, layout: Layout, bar: Rect, motion: WallMotion, units: Any):
        self._layout, self._motion = layout, motion
        self._speed = math.hypot(motion.cosine, motion.sine)
        self._unit = unit_label("velocity", units)
        self._digits = fixed_point(self._speed, 3) if motion.oscillates else None
        self.animated = motion.oscillates
        self._place(bar)

    def paint(self, frame: np.ndarray, t: float) -> None:
        """Lay words and arrows of time ``t`` over ``frame``."""
        words = self.words(t)
        if self._speed == 0.0 and words and self._side == "middle":
            frame[self.box.slices] = style.rgb(self._layout.theme.wall_resting)  # no hatching behind the words
        paint_text(frame, self.box, words, self.font_size, self._side, self._colour)
        for arrow in self._arrows:
            paint_arrow(frame, arrow, float(self._motion.velocity(t)) / self._speed, self._layout.theme.on_wall_moving)

    @property
    def boxes(self) -> list[Rect]:
        """All places that ``paint`` touches."""
        return [self.box, *self._arrows]

    def words(self, t: float) -> str:
        """Return the words of time ``t``."""
        if self._digits:
            return f"{self._digits(float(self._motion.velocity(t)))} {self._unit}"
        now, before = self._motion.cosine, self._motion.before
        words = f"{number(now)} {self._unit}" if self._speed else ""
        if before is None:
            return words
        if words:
            return f"{words} ({number(before)} before t = 0)"
        return f"stopped ({number(before)} {self._unit} before t = 0)"

    def _place(self, bar: Rect) -> None:
        """Choose where words and arrows stand, for the widest words."""
        layout, px = self._layout, self._layout.pixels
        words = f"{self._digits(-self._speed)} {self._unit}" if self._digits else self.words(0.0)
        size, arrow = px(14), px(_ARROW)
        middle = bar.left + bar.width // 2
        on_bar = bar.width - 2 * px(22) - (2 * arrow if self._speed else 0)
        beside = layout.split - px(16) - bar.right
        if text_width(words, size) <= on_bar or on_bar >= beside:
            self.font_size = fitting_size(words, size, on_bar)
            half = math.ceil(text_width(words, self.font_size) / 2) + px(6)
            self.box = Rect(middle - half, bar.top, 2 * half, bar.height)
            theme = layout.theme
            self._side, self._colour = "middle", theme.on_wall_moving if self._speed else theme.text
            first, last = half + px(8) + arrow // 2, bar.width // 2 - px(8) - arrow // 2
            centres = [middle + side * offset for offset in range(first, last + 1, px(_PITCH)) for side in (1, -1)]
        else:
            self.font_size = fitting_size(words, size, beside)
            self.box = Rect(bar.right + px(8), bar.top, beside, bar.height)
            self._side, self._colour, centres = "left", layout.theme.text, [middle]
        top = bar.top + (bar.height - px(_HEAD)) // 2
        self._arrows = [Rect(x - arrow // 2, top, arrow, px(_HEAD)) for x in centres] if self._speed else []


def wall_labels(scene: Scene, layout: Layout) -> list[WallLabel]:
    """Return the labels of the walls of ``scene``."""
    return [WallLabel(layout, layout.wall(side), motion, scene.units) for side, motion in scene.walls]


class DriveLabel:
    """What drives the flow, in words and with an arrow, above the upper wall; nothing without any.

    ``boxes``: the place of words and arrow. ``animated``: whether the drive changes in time, and the label with it.
    """

    def __init__(self, scene: Scene, layout: Layout):
        self._scene, self._layout = scene, layout
        self._name, unit, self._most = scene.drive_shown
        self._unit = unit_label(unit, scene.units)
        self._size = math.hypot(*self._most)
        self.animated = self._size > 0.0 and scene.drive_share(scene.start_time) is not None
        self._digits = fixed_point(self._size, 3) if self.animated else number
        wall, px = layout.wall("top"), layout.pixels
        widest = max(map(self._words, (1.0, -1.0) if self.animated else (1.0,)), key=len)
        width = min(math.ceil(text_width(widest, px(14))) + px(10 + _ARROW), layout.split - px(16))
        self.box = Rect(min(wall.left, layout.split - px(8) - width), wall.top - px(18), width, px(17))
        self.boxes = [self.box]
        self._font_size = fitting_size(widest, px(14), width - px(10 + _ARROW))

    def paint(self, frame: np.ndarray, t: float) -> None:
        """Lay words and arrow of time ``t`` over ``frame``."""
        if not self._size:
            return
        box, px, colour = self.box, self._layout.pixels, self._layout.theme.text
        share = self._scene.drive_share(t) if self.animated else 1.0
        assert share is not None
        words = Rect(box.left, box.top, box.width - px(10 + _ARROW), box.height)
        paint_text(frame, words, self._words(share), self._font_size, "left", colour)
        along, up = self._most
        if abs(along) >= abs(up):
            arrow = Rect(box.right - px(_ARROW), box.top + (box.height - px(_HEAD)) // 2, px(_ARROW), px(_HEAD))
            paint_arrow(frame, arrow, share * math.copysign(1.0, along), colour)
        else:
            arrow = Rect(box.top, box.right - px((_ARROW + _HEAD) / 2), box.height, px(_HEAD))  # columns are rows
            paint_arrow(frame.transpose(1, 0, 2), arrow, -share * math.copysign(1.0, up), colour)

    def _words(self, share: float) -> str:
        along, up = self._most
        return f"{self._name} {self._digits(share * (self._size if up else along))} {self._unit}"


SCALE_TICKS = np.linspace(0.0, 1.0, 5)
"""Places along a colour bar, from its lower end, of numbers that change from frame to frame."""
SCALE_ROOM = "−0.00000"
"""The longest of these numbers."""


class ScaleLabel:
    """The numbers beside the colour bar of a scale that changes; ``boxes``: their places."""

    def __init__(self, layout: Layout):
        bar, px = layout.colour_bar, layout.pixels
        self._layout, width = layout, math.ceil(text_width(SCALE_ROOM, px(13)))
        rows = [round(bar.bottom - share * bar.height) for share in SCALE_TICKS]
        self.boxes = [Rect(bar.right + px(7), row - px(9), width, px(18)) for row in rows]

    def paint(self, frame: np.ndarray, limits: tuple[float, float]) -> None:
        """Lay the numbers of a scale between ``limits`` over ``frame``."""
        low, high = limits
        for box, share in zip(self.boxes, SCALE_TICKS, strict=True):
            value = low + (high - low) * share
            text = number(value if abs(value) > 1e-9 * (high - low) else 0.0, 2)
            paint_text(frame, box, text, self._layout.pixels(13), "left", self._layout.theme.text)
