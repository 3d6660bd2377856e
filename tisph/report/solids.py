"""The bodies of a scene in a movie frame: filled, with an outline, and with lines that show how they rotate and slide.

A body in the fluid that rotates, or that the flow may rotate, has a spoke from its centre to its rim. A wall around the
fluid that moves has short marks that move with it: a closed curve one, a straight wall some a period.
"""

import math
from collections.abc import Iterator

import numpy as np

from tisph.geometry.body import Body, Placement
from tisph.report import style
from tisph.report.layout import RIM, Layout
from tisph.report.raster import LEVELS, Discs, blend, dense_lines, filled
from tisph.snapshot import Bodies, Snapshot

_PIECE = 0.5  # pixels: length of the straight pieces of an outline
_MARKS = 4  # a period of a straight wall
_MARK = 0.5 * RIM  # length of a mark over the longer side of the box


class Solids:
    """Paints the bodies of ``scene`` where each snapshot says that they are, through periodic seams."""

    def __init__(self, scene, layout: Layout):
        self._layout = layout
        self._shape = layout.box.shape
        self._pen = Discs(max(0.5, 0.9 * layout.scale), self._shape)
        self._solids = [_kind(body)(body, layout, _MARK * max(scene.extent)) for body in scene.bodies]
        self._position = self._covers = None
        above = np.arange(self._shape[0])[:, None] < layout.pixel_positions(0.0, 0.0)[1]
        halves = {0.0: above >= 0, 1.0: above, -1.0: ~above}
        self._parts = [halves[side] for side in getattr(scene, "sides", [0.0] * len(scene.bodies))]

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the bodies of ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        bodies = snapshot.bodies
        position = bodies.centre.tobytes(), bodies.angle.tobytes()
        if position != self._position:  # what stands still is drawn once
            self._position, self._covers = position, self._cover(bodies)
        within, rims, lines = self._covers
        solid, edge = style.rgb(self._layout.theme.solid), style.rgb(self._layout.theme.solid_edge)
        np.copyto(panel, solid.astype(np.uint8), where=within[:, :, None])  # most, ten times faster
        blend(panel, rims, solid)
        blend(panel, lines, edge)

    def _cover(self, bodies: Bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which pixels are all within areas, the coverage of the others by areas, and of all by lines."""
        areas, lines = np.zeros(self._shape, dtype=np.uint8), []
        for solid, part, centre, angle in zip(self._solids, self._parts, bodies.centre, bodies.angle, strict=True):
            for edge, strokes in solid.drawn(centre, float(angle)):
                area = filled(self._layout.pixel_positions(*edge.T), self._shape)
                areas = np.maximum(areas, part * (area if solid.encloses else LEVELS - area))
                lines += [self._layout.pixel_positions(*stroke.T) for stroke in strokes]
        within = areas >= LEVELS
        strokes = self._pen.cover(dense_lines(lines))
        return within, np.where(within, 0, areas), strokes


class _ImmersedBody:
    """A body in the fluid, which its edge ``encloses``; ``mark`` is the length of a mark."""

    encloses = True

    def __init__(self, body: Body, layout: Layout, mark: float):
        self.body, self._low = body, np.array(layout.low)
        boundary = body.shape.boundary_points(_PIECE / layout.pixels_per_length)
        self._edge = boundary.point
        self._strokes = [np.concatenate([self._edge, self._edge[:1]])]
        if body.motion.rotation.largest_speed or (body.free and not body.motion.inertia.held[2]):
            self._strokes.append(self._mark(boundary, mark))

    def _mark(self, boundary, mark):
        """Return the line (2, 2) that shows how the body rotates."""
        return np.stack([np.zeros(2), boundary.point[0]])

    def drawn(self, centre: np.ndarray, angle: float) -> Iterator[tuple[np.ndarray, list[np.ndarray]]]:
        """Yield edge (n, 2) and lines of each copy that may be in sight, of a body at ``centre``."""
        for axis, period in enumerate(self.body.periods):
            if math.isfinite(period):  # it may have left the box
                centre = centre - period * np.floor((centre - self._low) / period) * (np.arange(2) == axis)
        for offset in ((0.0, 0.0), *self.body.periodic_offsets()):
            place = Placement(centre + offset, angle)
            yield place.to_lab_frame(self._edge), [place.to_lab_frame(stroke) for stroke in self._strokes]


class _ContainerWall(_ImmersedBody):
    """A closed curve that the fluid is in."""

    encloses = False

    def _mark(self, boundary, mark):
        return np.stack([boundary.point[0], boundary.point[0] - mark * boundary.normal[0]])


class _StraightWall:
    """A straight wall; its edge encloses all that is behind it, farther than anybody looks."""

    encloses = True

    def __init__(self, body: Body, layout: Layout, mark: float):
        self.body, self._mark = body, -mark * body.shape.normal

    def drawn(self, centre: np.ndarray, angle: float) -> Iterator[tuple[np.ndarray, list[np.ndarray]]]:
        """Yield edge and lines; marks that have left one end of the period are at the other."""
        line, place = self.body.shape, Placement(centre, angle)
        along, behind = line.length * np.array(line.tangent), -10 * line.length * line.normal
        slid = place.rotated_back((centre - self.body.centre)[None])[0] @ along / line.length**2
        first = line.point - slid * along
        edge = first + np.array([-10 * along, 10 * along, 10 * along + behind, behind - 10 * along])
        parts = ((np.arange(_MARKS) + 0.5) / _MARKS + slid) % 1.0
        strokes = [first + np.stack([0.0 * along, along])]
        if self.body.motion.largest_speed(0.0):
            strokes += [first + part * along + np.stack([0.0 * along, self._mark]) for part in parts]
        yield place.to_lab_frame(edge), [place.to_lab_frame(stroke) for stroke in strokes]


def _kind(body: Body):
    """Return the class of a body."""
    if not body.shape.area:
        return _StraightWall
    return _ImmersedBody if body.shape.fluid_side == "outside" else _ContainerWall
