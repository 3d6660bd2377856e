"""Bodies, streamlines, paths and arrows over the fluid of a movie frame.

A body is filled, has an outline, and lines that show how it rotates and slides. A body in the fluid that rotates, or
that the flow may rotate, has a spoke from its centre to its rim; an arrow shows which way a motor turns it. A wall
around the fluid that moves has short marks that move with it: a closed curve one, a straight wall some a period.

Streamlines are lines of equal stream function psi, u = dpsi/dy and v = -dpsi/dx: between any two next to each other as
much fluid flows. psi solves psi[b] - psi[a] = flow rate between a and b over all pairs of neighbouring nodes of a grid,
in the least-squares sense. Grid and sums end at the sides of the box and within bodies, where no flow is known:
so psi may grow from one side of a periodic box to the other, as it does where fluid flows through it. Along walls at
rest psi is constant: the equations say so, too, and weigh more than errors of the flow elsewhere, or a slow eddy in a
corner would be lost in them. In axisymmetric flow psi is Stokes' stream function, r u = dpsi/dr and r v = -dpsi/dx.

Paths show where some particles, and bodies that the flow carries, were in the frames before. Arrows show velocities on
an even grid. Lines are dark with a light rim, which is seen on any colour.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.geometry.body import Body, Placement
from tisph.geometry.line import Line
from tisph.measures.fits import periodic_tree, with_walls
from tisph.report import style
from tisph.report.labels import number
from tisph.report.layout import RIM, Layout, Rect, open_ends
from tisph.report.raster import LEVELS, Discs, Points, blend, dense_lines, filled
from tisph.report.text import paint_text, text_width
from tisph.scenes._scene import Scene, largest_speed
from tisph.scenes._views import SHOWN
from tisph.snapshot import Bodies, Snapshot

INK, LIGHT = style.TEXT, "#ffffff"
_HALF_WIDTHS = (1.8, LIGHT), (1.0, INK)  # pixels in a frame of 1280 x 640


class Strokes:
    """Draws lines into panels of ``shape``, in a frame of that ``scale``."""

    def __init__(self, scale: float, shape: tuple[int, int]):
        self._pens = [(Discs(max(0.5, wide * scale), shape), style.rgb(ink)) for wide, ink in _HALF_WIDTHS]

    def paint(self, panel: np.ndarray, points: Points) -> None:
        """Lay the line of ``points`` that are close to each other over ``panel``, RGB of uint8 (rows, columns, 3)."""
        for pen, ink in self._pens:
            blend(panel, pen.cover(points), ink)


_PIECE = 0.5  # pixels: length of the straight pieces of an outline
_MARKS = 4  # a period of a straight wall
_MARK_LENGTH = 0.5 * RIM  # length of a mark over the longer side of the box


class Solids:
    """Paints the bodies of ``scene`` where each snapshot says that they are, through periodic seams."""

    def __init__(self, scene: Scene, layout: Layout):
        self._layout = layout
        self._shape = layout.box.shape
        self._pen = Discs(max(0.5, 0.9 * layout.scale), self._shape)
        length, solids = _MARK_LENGTH * max(scene.extent), [body.solid for body in scene.bodies]
        self._chosen = np.flatnonzero(solids)
        self._solids = [_kind(scene.bodies[k])(scene.bodies[k], layout, length) for k in self._chosen]
        self._position: tuple[bytes, ...] | None = None
        self._covers: Any = None
        above = np.arange(self._shape[0])[:, None] < layout.pixel_positions(0.0, 0.0)[1]
        halves = {0.0: above >= 0, 1.0: above, -1.0: ~above}
        self._parts = [halves[side] for side in getattr(scene, "sides", [0.0] * len(scene.bodies))]

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the bodies of ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        bodies: Any = snapshot.bodies
        position = bodies.centre.tobytes(), bodies.angle.tobytes(), np.sign(bodies.angular_velocity).tobytes()
        if position != self._position:  # resting bodies are drawn once
            self._position, self._covers = position, self._cover(bodies)
        within, rims, lines = self._covers
        solid, edge = style.rgb(self._layout.theme.solid), style.rgb(self._layout.theme.solid_edge)
        np.copyto(panel, solid.astype(np.uint8), where=within[:, :, None])  # most, ten times faster
        blend(panel, rims, solid)
        blend(panel, lines, edge)

    def _cover(self, bodies: Bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which pixels are all within areas, the coverage of the others by areas, and of all by lines."""
        areas, lines = np.zeros(self._shape, dtype=np.uint8), []
        turns = np.sign(bodies.angular_velocity)
        for solid, k in zip(self._solids, self._chosen, strict=True):
            if np.isnan(bodies.angle[k]):  # not in the fluid
                continue
            for edge, strokes in solid.drawn(bodies.centre[k], bodies.angle[k], turns[k]):
                area = filled(self._layout.pixel_positions(*edge.T), self._shape)
                areas = np.maximum(areas, self._parts[k] * (area if solid.encloses else LEVELS - area))
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
        motion: Any = body.motion
        self._arrow = self._turning_arrow(mark) if motion.rotation.largest_speed and not body.free else None
        if motion.rotation.largest_speed or (body.free and not motion.inertia.held[2]):
            self._strokes.append(self._mark(boundary, mark))

    def _mark(self, boundary: Any, mark: float) -> np.ndarray:
        """Return the line (2, 2) that shows how the body rotates."""
        return np.stack([np.zeros(2), boundary.point[0]])

    def _turning_arrow(self, mark: float) -> np.ndarray:
        """Return the line (n, 2) of an arrow within the body that turns counterclockwise around (0, 0)."""
        return _arc_arrow(_ARROW_RADIUS * np.linalg.norm(self._edge, axis=1).min(), -0.75 * np.pi, 0.7)

    def drawn(self, centre: np.ndarray, angle: float, turn: float) -> Iterator[tuple[np.ndarray, list[np.ndarray]]]:
        """Yield edge (n, 2) and lines of each copy that may be in sight, of a body at ``centre``.

        ``turn``: 1, 0 or -1, counterclockwise, none or clockwise.
        """
        arrow = [] if self._arrow is None or not turn else [self._arrow if turn > 0 else self._arrow[:, ::-1]]
        for axis, period in enumerate(self.body.periods):
            if math.isfinite(period):  # it may have left the box
                centre = centre - period * np.floor((centre - self._low) / period) * (np.arange(2) == axis)
        for offset in ((0.0, 0.0), *self.body.periodic_offsets()):
            place = Placement(centre + offset, angle)
            turned = [place.to_lab_frame(stroke) for stroke in self._strokes]
            yield place.to_lab_frame(self._edge), turned + [place.centre + line for line in arrow]


class _ContainerWall(_ImmersedBody):
    """A closed curve that the fluid is in."""

    encloses = False

    def _mark(self, boundary: Any, mark: float) -> np.ndarray:
        return np.stack([boundary.point[0], boundary.point[0] - mark * boundary.normal[0]])

    def _turning_arrow(self, mark: float) -> np.ndarray:
        radius = np.linalg.norm(self._edge, axis=1).max() + 1.5 * mark
        return _arc_arrow(radius, 0.25 * np.pi, 0.15, 0.04)


_ARROW_RADIUS = 0.6  # of the largest circle around the centre of a body and in it


def _arc_arrow(radius: float, middle: float, half: float, head: float = 0.3) -> np.ndarray:
    """Return the line (n, 2) of an arrow along an arc, the angle ``half`` to both sides of the angle ``middle``.

    ``head``: length of its head over the radius. Exchanged x and y turn it the other way, as ``middle`` is diagonal.
    """
    angle = middle + np.linspace(-half, half, 40)
    tip, back = angle[-1], angle[-1] - head
    angles = np.concatenate([angle, [back, tip, back]])
    radii = radius * np.concatenate([np.ones(40), [1.0 + 0.6 * head, 1.0, 1.0 - 0.6 * head]])
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


class _StraightWall:
    """A straight wall; its edge encloses all that is behind it, farther than anybody looks."""

    encloses = True

    def __init__(self, body: Body, layout: Layout, mark: float):
        self.body: Any = body
        shape: Any = body.shape
        self._mark = -mark * shape.normal

    def drawn(self, centre: np.ndarray, angle: float, turn: float) -> Iterator[tuple[np.ndarray, list[np.ndarray]]]:
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


class _OutlineWall(_ImmersedBody):
    """A wall at rest from end to end of a channel; its edge encloses the solid behind it, as of a straight one."""

    def __init__(self, body: Body, layout: Layout, mark: float):
        super().__init__(body, layout, mark)
        shape: Any = body.shape
        first, last = shape.ends
        behind = np.array([0.0, -10.0 * (last[0] - first[0])])
        self._strokes = [np.array([first, *self._edge, last])]
        self._edge = np.array([*self._strokes[0], last + behind, first + behind])


def _kind(body: Body) -> type[Any]:
    """Return the class of a body."""
    if not body.shape.area:
        return _StraightWall if isinstance(body.shape, Line) else _OutlineWall
    return _ImmersedBody if body.shape.fluid_side == "outside" else _ContainerWall


_PARTICLES = 48
_FRAMES = 40
_DOT = 3.2  # radius in a frame of 1280 x 640 of the dot where the particle is
_BODIES = 1.6  # times as wide are the lines of bodies, and their dots


class Tracks:
    """Paints the paths of evenly chosen particles over the last frames; a path ends at a periodic side or an outlet."""

    width = 1.0  # of lines and dots
    frames = _FRAMES

    def __init__(self, scene: Scene, layout: Layout):
        self._scene, self._layout = scene, layout
        self._seen: dict[float, np.ndarray] = {}
        self._count = 0
        self._strokes = Strokes(self.width * layout.scale, layout.box.shape)
        self._head = Discs(self.width * _DOT * layout.scale, layout.box.shape)

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the paths up to ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        self._seen[snapshot.t] = self._places(snapshot)
        times = sorted(time for time in self._seen if time <= snapshot.t)[-self.frames :]
        paths = np.array([self._seen[time] for time in times])
        pieces = [piece for path in paths.transpose(1, 0, 2) for piece in self._pieces(path) if len(piece) > 1]
        self._strokes.paint(panel, dense_lines(self._layout.pixel_positions(*piece.T[:2]) for piece in pieces))
        heads = paths[-1][np.isfinite(paths[-1]).all(axis=1)]
        blend(panel, self._head.cover(self._layout.pixel_positions(*heads.T[:2])), style.rgb(INK))

    def _places(self, snapshot: Snapshot) -> np.ndarray:
        """Return where they are in the box, and how often each has left through an outlet, (n, 3)."""
        self._count = self._count or len(snapshot.x)
        chosen = style.evenly_chosen(self._count, _PARTICLES)
        passages = np.zeros(len(snapshot.x)) if snapshot.passages is None else snapshot.passages
        places, there = np.full((len(chosen), 3), np.nan), chosen < len(snapshot.x)  # others make room for a body
        places[there] = np.stack([each[chosen[there]] for each in (snapshot.x, snapshot.y, passages)], axis=1)
        return places

    def _pieces(self, path: np.ndarray) -> list[np.ndarray]:
        """Return a path (frames, 3) in pieces between the sides and outlets through which it has left the box."""
        path = path[np.isfinite(path).all(axis=1)]
        jumps = np.abs(np.diff(path, axis=0)) > 0.5 * np.array([*self._scene.extent, 1.0])
        return np.split(path, np.flatnonzero(jumps.any(axis=1)) + 1)


class BodyTracks(Tracks):
    """Paints the paths of the centres of all bodies that the flow carries: of few bodies since the start."""

    width = _BODIES

    def __init__(self, scene: Scene, layout: Layout):
        super().__init__(scene, layout)
        self._free = self.free(scene)
        self.frames = 0 if len(self._free) <= SHOWN else _FRAMES

    @staticmethod
    def free(scene: Scene) -> list[int]:
        """Return the indices of the bodies that the flow carries."""
        return [index for index, body in enumerate(scene.bodies) if body.free]

    def _places(self, snapshot: Snapshot) -> np.ndarray:
        """Return where their centres are in the box, and that none leaves through an outlet, (n, 3)."""
        bodies: Any = snapshot.bodies
        centre, low = bodies.centre[self._free], np.array(self._scene.origin)
        inside = np.where(self._scene.periodic, low + (centre - low) % self._scene.extent, centre)
        return np.pad(inside, ((0, 0), (0, 1)))


class Turning:
    """Writes beside each wall or body that turns around the axis how fast, after ⊙ if its upper
    side comes towards the viewer, or after ⊗ if it goes away.
    """

    def __init__(self, scene: Scene, layout: Layout):
        self._scene, self._layout, self._unit = scene, layout, f"rad/{scene.units.time}"
        sides = getattr(scene, "sides", [0.0] * len(scene.bodies))
        turning = [pair for pair in zip(scene.bodies, sides, strict=True) if pair[0].spin.largest_speed]
        self._walls = [(body, self._place(body), side or 1.0) for body, side in turning]

    def _place(self, body: Body) -> tuple[float, float]:
        """Return the column and row in the panel of the middle of the words: within the solid."""
        shape: Any = body.shape
        if shape.area:
            return self._layout.pixel_positions(*body.centre)
        points = body.boundary_points(shape.length / 8).point
        middle, normal = points[len(points) // 2], body.boundary_points(shape.length / 8).normal[len(points) // 2]
        beyond = 0.5 * RIM * max(self._scene.extent)
        return self._layout.pixel_positions(*(middle - beyond * normal))

    def words(self, index: int, t: float) -> str:
        """Return the words beside the wall or body ``index`` of those that turn, at time ``t``."""
        body, _, side = self._walls[index]
        speed = side * float(body.spin.velocity(t))
        return f"{_TOWARDS if speed > 0.0 else _AWAY} {number(abs(speed), 3)} {self._unit}" if speed else ""

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the words of ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        for index, (body, (column, row), _) in enumerate(self._walls):
            upright = not body.shape.area and np.ptp(body.shape.extent[:, 0]) < np.ptp(body.shape.extent[:, 1])
            words, size = self.words(index, snapshot.t), self._layout.pixels(15)
            if upright:
                paint_note(np.rot90(panel, -1), len(panel) - row, column, words, size, self._layout.theme.text)
            else:
                paint_note(panel, column, row, words, size, self._layout.theme.text)


_TOWARDS, _AWAY = "⊙", "⊗"
SEPARATION = "separation"
_MARK = 4.5  # pixels in a frame of 1280 x 640: radius of the dot of a mark


def paint_marks(panel: np.ndarray, layout: Layout, marks: list[tuple[str, float, float]]) -> None:
    """Lay dots and names over the ``panel`` of the box, at the places x and y of each of ``marks``.

    The name of a separation ends at its place, and others begin there: the eddy in between stays free.
    """
    if not marks:
        return
    columns, rows = layout.pixel_positions(*np.array([place for _, *place in marks]).T)
    for widen, ink in ((1.5, LIGHT), (0.0, style.EXACT)):
        blend(panel, Discs((_MARK + widen) * layout.scale, panel.shape[:2]).cover((columns, rows)), style.rgb(ink))
    for (name, *_), column, row in zip(marks, columns, rows, strict=True):
        size, way = layout.pixels(14), 1 if name == SEPARATION else -1
        off = 0.5 * text_width(name, size) + layout.pixels(_MARK)
        up = layout.pixels(12) * (-1 if row > 0.5 * panel.shape[0] else 1)
        paint_note(panel, column - way * off, row + up, name, size, LIGHT, INK)


def paint_note(
    panel: np.ndarray, column: float, row: float, words: str, size: int, colour: str, rim: str | None = None
) -> None:
    """Write ``words`` around a place in the ``panel`` [pixels], moved so that they are within it."""
    rows, columns = panel.shape[:2]
    width, height = min(columns, math.ceil(text_width(words, size)) + 4), min(rows, size + 6)
    left = int(np.clip(column - 0.5 * width, 0, columns - width))
    top = int(np.clip(row - 0.5 * height, 0, rows - height))
    paint_text(panel, Rect(left, top, width, height), words, size, "middle", colour, rim)


_PITCH = 40.0  # pixels in a frame of 1280 x 640: distance of arrows
_UNIT = 1.5  # pitches: length of an arrow of the reference velocity
_LONGEST = 1.8  # pitches
_SHORTEST = 0.25  # pitches: below it a head shows no direction
_NEAR = 6  # particles whose velocities are averaged
_BESIDE = 1.2  # widths of the nearest particle: where no particle is so near there is no fluid
_SHAFT, _HEAD = 0.04, 0.14  # half widths of an arrow, in pitches
_RIM = 1.4  # half width in a frame of 1280 x 640 of the light rim of an arrow: seen on any colour
_TIP = 0.34  # pitches: length of the head of a long arrow


class Vectors:
    """Paints arrows into the box of ``scene``; the longest is nearly twice as long as their distance."""

    def __init__(self, scene: Scene, layout: Layout):
        self._scene, self._layout = scene, layout
        self._pitch = max(1.0, _PITCH * layout.scale)
        self._rim = Discs(max(0.5, _RIM * layout.scale), layout.box.shape)
        sides = layout.box.width, layout.box.height
        counts = [max(1, int(side / self._pitch)) for side in sides]
        columns, rows = ((np.arange(count) + 0.5) / count * side for count, side in zip(counts, sides, strict=True))
        self._feet = np.stack(np.meshgrid(columns, rows), axis=2).reshape(-1, 2)
        low, high = np.array(layout.low), np.array(layout.high)
        self._places = np.array([low[0], high[1]]) + self._feet * [1.0, -1.0] / layout.pixels_per_length
        self._places = np.clip(self._places, low, high)

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the arrows of ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        velocity = np.stack([snapshot.u, snapshot.v], axis=1).astype(float)
        places = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
        if not (np.isfinite(velocity).all() and np.isfinite(places).all()):
            return  # a run that went wrong still gets its picture
        mean, distance, nearest = mean_velocity(self._scene, places, velocity, self._places)
        arrows = _UNIT * mean / self._scene.reference_velocity * [1.0, -1.0]  # rows count downwards
        size = np.linalg.norm(arrows, axis=1)
        shown = (distance < _BESIDE * snapshot.widths(self._scene.spacing)[nearest]) & (size > _SHORTEST)
        arrows, size = arrows[shown], size[shown]
        arrows *= np.minimum(1.0, _LONGEST / size)[:, None]
        corners = self._feet[shown, None] + self._pitch * _outlines(arrows)
        rim = dense_lines(tuple(np.concatenate([arrow, arrow[:1]]).T) for arrow in corners)
        blend(panel, self._rim.cover(rim), style.rgb(LIGHT))
        blend(panel, filled((corners[:, :, 0], corners[:, :, 1]), panel.shape[:2]), style.rgb(INK))


def mean_velocity(
    scene: Scene, places: np.ndarray, velocity: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mean of ``velocity`` (n, 2) at the nearest of ``places`` (n, 2) around ``points`` (m, 2).

    And the distance (m,) and the index (m,) of the very nearest. The nearer, the more one counts.
    """
    tree, _ = periodic_tree(scene, places)
    distance, nearest = tree.query(points, min(_NEAR, len(places)))
    weight = 1.0 / (distance + 1e-3 * scene.spacing) ** 2
    mean = np.einsum("ij,ijk->ik", weight, velocity[nearest]) / weight.sum(axis=1)[:, None]
    return mean, distance[:, 0], nearest[:, 0]


def _outlines(arrows: np.ndarray) -> np.ndarray:
    """Return the corners (n, 7, 2) of ``arrows`` (n, 2), all run through the same way, around their middles."""
    size = np.linalg.norm(arrows, axis=1)[:, None]
    ahead = arrows / size
    aside = ahead[:, ::-1] * [-1.0, 1.0]
    neck = size - np.minimum(_TIP, 0.6 * size)
    thin = np.minimum(1.0, size / _TIP)  # short ones are narrow, too
    along = [0.0 * size, neck, neck, size, neck, neck, 0.0 * size]
    across = [_SHAFT, _SHAFT, _HEAD, 0.0, -_HEAD, -_SHAFT, -_SHAFT]
    return np.stack(
        [(one - 0.5 * size) * ahead + other * thin * aside for one, other in zip(along, across, strict=True)], axis=1
    )


_LINES = 10  # between the least and the largest stream function
_FINEST = 0.5  # smallest spacings between nodes: pieces of lines that look smooth
_MOST = 8000  # nodes: some 50 ms of factorising, once where bodies stand still
_BEYOND = 1.5  # pitches of the grid: so far lines go on under the picture of a body
_RESTING = 1e-4  # of reference velocity and shorter side: a range of psi that only errors make
_ON_WALL = 1e4  # weight of the equations along walls at rest
_IN_EDDY = 4  # lines in the strongest eddy
_SHORTEST_LINE = 2.0  # pitches of the grid: shorter ones are errors
_LEAST_EDDY = 2e-4  # of the range of psi: less beyond the walls may be an error


@dataclass(frozen=True)
class StreamFunction:
    """``psi`` (rows, columns) at the nodes of ``Streamlines``, NaN within bodies; its ``ends`` in the fluid.

    psi is 0 on the walls, or half-way between the two walls of which psi differs most; without walls its mean is 0.
    ``beside`` is psi on the wall where it is largest: fluid flows through between -beside and beside, and turns in
    eddies beyond.
    """

    psi: np.ndarray
    ends: tuple[float, float]
    beside: float = 0.0

    @property
    def eddies(self) -> np.ndarray:
        """How far psi reaches beyond the walls (2,), below and above; 0 without flow between walls."""
        beyond = np.maximum(0.0, np.array([-self.beside - self.ends[0], self.ends[1] - self.beside]))
        return beyond if 0.0 < beyond.min() + beyond.max() < self.beside else np.zeros(2)


class Streamlines:
    """Paints lines into the box of ``scene``, of even width, with ``step`` of the stream function from line to line.

    Lines are at psi = (k + 1/2) ``step`` with whole k, as many above 0 as below it if psi has the same size there. The
    step is the same in all frames: a flow twice as strong has twice as many lines. In eddies beside a flow through a
    channel, which are slower, the step is ``eddy_step``.
    """

    def __init__(self, scene: Scene, layout: Layout):
        self._scene, self._layout, self.step, self.eddy_step = scene, layout, 0.0, 0.0
        self._least_step = _RESTING * scene.reference_velocity * min(scene.extent) / _LINES
        self._strokes = Strokes(layout.scale, layout.box.shape)
        low, high = np.array(layout.low), np.array(layout.high)
        low[0], high[0] = np.clip([low[0], high[0]], *open_ends(scene))
        pitch = max(_FINEST * scene.wanted_spacing.smallest, np.sqrt(np.prod(high - low) / _MOST))
        self._axes = [np.linspace(*ends, 2 + int(np.diff(ends)[0] / pitch)) for ends in zip(low, high, strict=True)]
        self._nodes = np.stack(np.meshgrid(*self._axes), axis=2)  # (rows, columns, 2)
        self._pitch = np.array([axis[1] - axis[0] for axis in self._axes])
        self._wet: Any = None
        self._difference: Any = None
        self._factors: Any = None

    def paint(self, panel: np.ndarray, stream: StreamFunction) -> None:
        """Lay the lines of ``stream`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        lines = [self._layout.pixel_positions(*line.T) for line in self.lines(stream)]
        self._strokes.paint(panel, dense_lines(lines))

    def lines(self, stream: StreamFunction) -> list[np.ndarray]:
        """Return the lines, places (n, 2) each; none where the fluid rests."""
        from contourpy import LineType, contour_generator

        if self.step < self._least_step:
            return []
        x, y = self._axes
        contours: Any = contour_generator(x, y, np.ma.masked_invalid(stream.psi), line_type=LineType.Separate)
        found = [line for level in self.levels(stream) for line in contours.lines(level)]
        return [line for line in found if (np.ptp(line, axis=0) > _SHORTEST_LINE * self._pitch).any()]

    def levels(self, stream: StreamFunction) -> np.ndarray:
        """Return the values of psi that have lines, in ascending order."""
        first, last = np.array(stream.ends) / self.step - 0.5
        levels = (np.arange(math.ceil(first), math.floor(last) + 1) + 0.5) * self.step
        if self.eddy_step <= _LEAST_EDDY * _LINES / _IN_EDDY * self.step or not stream.eddies.any():
            return levels
        counts = [int(beyond / self.eddy_step + 0.5) for beyond in stream.eddies]
        below, above = (stream.beside + (np.arange(count) + 0.5) * self.eddy_step for count in counts)
        return np.concatenate([-below[::-1], levels[np.abs(levels) < stream.beside], above])

    def measured(self, snapshot: Snapshot) -> StreamFunction | None:
        """Return the stream function of a snapshot, None where a run went wrong; widen ``step`` to ten lines in it."""
        places, velocity = with_walls(self._scene, snapshot)
        if not (np.isfinite(velocity).all() and np.isfinite(places).all()):
            return None
        depth = self._depth(snapshot)
        self._prepare(depth > -_BEYOND * self._pitch.max(), snapshot.t)
        flow = np.zeros(self._nodes.shape)
        flow[self._wet] = mean_velocity(self._scene, places, velocity, self._nodes[self._wet])[0]
        if self._scene.axisymmetric:
            flow *= np.abs(self._nodes[:, :, 1:])
        psi = self._stream_function(flow)
        least, largest = self._at_walls(psi, snapshot)
        psi -= 0.5 * (least + largest)
        within = psi[depth >= 0.0]
        beside = 0.5 * (largest - least) if snapshot.t > self._scene.start_time else 0.0  # velocities jump at the start
        stream = StreamFunction(np.where(self._wet, psi, np.nan), (float(within.min()), float(within.max())), beside)
        self.step = max(self.step, float(np.ptp(within)) / _LINES)
        self.eddy_step = max(self.eddy_step, float(stream.eddies.max()) / _IN_EDDY)
        return stream

    def _at_walls(self, psi: np.ndarray, snapshot: Snapshot) -> tuple[float, float]:
        """Return the least and the largest mean ``psi`` of a wall or body; 0 without any."""
        from scipy.ndimage import map_coordinates

        found, low, size = [], np.array(self._scene.origin), np.array(self._scene.extent)
        for body in self._scene.seen(snapshot).bodies:
            points = body.boundary_points(self._pitch.max(), snapshot.t).point
            points = np.where(self._scene.periodic, low + (points - low) % size, points)  # a wall that slides leaves
            places = (points - [axis[0] for axis in self._axes]) / self._pitch
            last = np.array(psi.shape[::-1]) - 1.0
            places = places[(np.abs(places - 0.5 * last) < 0.5 * last + 0.5).all(axis=1)]
            if len(places) and body.solid:
                found.append(map_coordinates(psi, places.T[::-1], order=1, mode="nearest").mean())
        return (min(found), max(found)) if found else (0.0, 0.0)

    def _depth(self, snapshot: Snapshot) -> np.ndarray:
        """Return how far each node is in the fluid, (rows, columns), below 0 within bodies."""
        depth, scene = np.full(self._nodes.shape[:2], np.inf), self._scene.seen(snapshot)
        for body, side in zip(scene.bodies, getattr(scene, "sides", [0.0] * len(scene.bodies)), strict=True):
            distance = body.nearest(self._nodes.reshape(-1, 2), snapshot.t).distance.reshape(depth.shape)
            depth = np.minimum(depth, np.where(side * self._nodes[:, :, 1] < 0.0, np.inf, distance))
        return depth

    def _prepare(self, wet: np.ndarray, t: float) -> None:
        """Factorise the sums of squares between the nodes that are ``wet``, unless they are the last ones."""
        from scipy.sparse import coo_matrix, identity
        from scipy.sparse.linalg import splu

        if self._wet is not None and np.array_equal(wet, self._wet):
            return
        self._wet, count = wet, int(wet.sum())
        number = np.cumsum(wet.ravel()).reshape(wet.shape) - 1
        neighbours: tuple[Any, ...] = ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:]))
        ends = []
        for one_side, other_side in neighbours:
            both = wet[one_side] & wet[other_side]
            ends.append((number[one_side][both], number[other_side][both]))
        first, second = (np.concatenate(part) for part in zip(*ends, strict=True))
        edge, one = np.arange(len(first)), np.ones(len(first))
        ways = np.concatenate([edge, edge]), np.concatenate([second, first])
        self._difference = coo_matrix((np.concatenate([one, -one]), ways), (len(first), count)).tocsr()
        # a constant of each part of the fluid is free: the little that is added takes the one of mean 0
        along = self._along_walls(number, wet, t)
        sums = self._difference.T @ self._difference + _ON_WALL * along.T @ along + 1e-9 * identity(count)
        self._factors = splu(sums.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def _along_walls(self, number: np.ndarray, wet: np.ndarray, t: float) -> Any:
        """Return the matrix (pairs, wet nodes) of the differences of psi between next points of walls at rest."""
        from scipy.sparse import csr_matrix, vstack

        count = int(wet.sum())
        parts = [csr_matrix((0, count))]
        for body in self._scene.bodies:
            if body.free or not body.solid or largest_speed(body):
                continue
            points = body.boundary_points(self._pitch.min(), t).point
            places = (points - [axis[0] for axis in self._axes]) / self._pitch
            first = np.clip(np.floor(places).astype(int), 0, np.array(wet.shape[::-1]) - 2)
            share = places - first
            inside = ((share > -1e-9) & (share < 1.0 + 1e-9)).all(axis=1)
            at: Any = 0.0
            for corner in ((0, 0), (1, 0), (0, 1), (1, 1)):
                column, row = (first + corner).T
                inside &= wet[row, column]
                weight = np.abs(1.0 - np.array(corner) - share).prod(axis=1)
                index = np.arange(len(points)), np.maximum(number[row, column], 0)
                at += csr_matrix((weight, index), (len(points), count))
            known = np.flatnonzero(inside)
            parts.append(at[known[1:]] - at[np.repeat(known[:1], len(known[1:]))])
        return vstack(parts)

    def _stream_function(self, flow: np.ndarray) -> np.ndarray:
        """Return psi (rows, columns) of velocities (rows, columns, 2), 0 at nodes that are dry."""
        wet, (along, across) = self._wet, self._pitch
        right = -0.5 * along * (flow[:, :-1, 1] + flow[:, 1:, 1])[wet[:, :-1] & wet[:, 1:]]
        up = 0.5 * across * (flow[:-1, :, 0] + flow[1:, :, 0])[wet[:-1] & wet[1:]]
        psi = np.zeros(wet.shape)
        psi[wet] = self._factors.solve(self._difference.T @ np.concatenate([right, up]))
        return psi
