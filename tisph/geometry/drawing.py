"""Curves of a drawing, read from a CSV, SVG or DXF file.

A path consists of pieces that follow each other: polylines, and curved pieces as points that lie on the curve, so close
that the polyline through them leaves it by less than 1e-7 of its size. y points upwards: of an SVG file, from the lower
edge of its page. Open paths whose ends meet are joined. An SVG file may declare no entities, which could fill the
memory; references to other files are not followed.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

LARGEST_FILE = {".csv": 8 * 2**20, ".svg": 2**20, ".dxf": 16 * 2**20}
"""Largest file [bytes] that is read, by its ending: a few seconds."""

FINE = 16_384
"""Points on the curved pieces of a path."""

MOST_CURVES = 5000
"""Most arcs and splines that are read of an element of an SVG file."""

MOST_PATHS = 5000
"""Most paths of a file among which a shape is looked for."""

SAGITTA = 1e-7
"""Distance of points on arcs and splines of a DXF file from the chords between them, over the size of the curve."""

GAP = 1e-3
"""Largest gap between ends that meet, over the size of the path."""

OPEN_STEPS = 3.0
"""Distance from the last to the first row of a CSV file, over the largest step between rows, above which it is open."""

ROUNDING = 1e-12
"""Distance of places that are one, over the size of the path."""

SHOWN = 6
"""Most names in a message."""

METRES = {"km": 1e3, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9, "in": 0.0254, "ft": 0.3048}
"""Units of length."""

DXF_UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 7: "km", 12: "nm", 13: "um"}
"""Units by the number $INSUNITS of a DXF file."""

EXTRA = "needs the package {}: pip install 'tisph[geometry]'"


@dataclass(frozen=True)
class Piece:
    """A part of a path: ``places`` (n, 2) from end to end, the corners of a polyline where it is ``straight``."""

    places: np.ndarray
    straight: bool = True


@dataclass(frozen=True)
class DrawnPath:
    """Pieces from end to end, with the ``names`` that a config may call the path by, its own name first.

    ``gap``: largest distance between ends that were joined. ``rows``: whether it comes from rows of a table, which may
    mean an open path or a closed one.
    """

    names: tuple[str, ...]
    pieces: tuple[Piece, ...]
    gap: float = 0.0
    rows: bool = False

    @cached_property
    def places(self) -> np.ndarray:
        """Places (n, 2) from end to end, without the first place of a piece where the one before it ends."""
        first, *others = (piece.places for piece in self.pieces)
        places = np.concatenate([first, *(each[1:] for each in others)])
        return places[np.append(True, (np.diff(places, axis=0) != 0.0).any(axis=1))]

    @property
    def dense(self) -> np.ndarray:
        """Places (n, 2) from end to end, the straight pieces in short steps."""
        places = self.places
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        return _at(places, along, np.union1d(along, np.linspace(0.0, along[-1], FINE)))

    @property
    def straight(self) -> bool:
        """Whether all pieces are straight."""
        return all(piece.straight for piece in self.pieces)

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the path."""
        return float(np.linalg.norm(np.ptp(np.concatenate([piece.places for piece in self.pieces]), axis=0)))

    @property
    def opening(self) -> float:
        """Distance from the last place to the first."""
        return float(np.linalg.norm(self.pieces[-1].places[-1] - self.pieces[0].places[0]))

    @cached_property
    def closed(self) -> bool:
        """Whether its ends meet."""
        return self.opening <= GAP * self.size and len(self.places) > 2

    def moved(self, factor: float, angle: float, rising: bool) -> "DrawnPath":
        """Return the path times a ``factor``, rotated by an ``angle`` [radians]; if ``rising``, from left to right."""
        cosine, sine = math.cos(angle), math.sin(angle)
        matrix = factor * np.array([[cosine, sine], [-sine, cosine]])
        pieces = tuple(Piece(each.places @ matrix, each.straight) for each in self.pieces)
        moved = replace(self, pieces=pieces, gap=factor * self.gap)
        return moved.reversed() if rising and moved.places[-1, 0] < moved.places[0, 0] else moved

    def check_steps(self) -> None:
        """Raise ValueError if this path through rows of a table is open, seen as a smooth closed curve."""
        largest = np.linalg.norm(np.diff(self.places, axis=0), axis=1).max()
        if self.rows and self.opening > OPEN_STEPS * largest:
            text = f"the path is open: {self.opening:.4g} from the last row to the first"
            raise ValueError(f"{text}, more than {OPEN_STEPS:g} of the largest step, {largest:.4g}")

    def reversed(self) -> "DrawnPath":
        """Return the path from its end to its start."""
        return replace(self, pieces=tuple(Piece(each.places[::-1], each.straight) for each in self.pieces[::-1]))

    def corners(self) -> np.ndarray:
        """Return the turns [radians] (n,) where pieces meet and at corners of polylines, that of a closed path last."""
        turns = [_turns(piece.places) for piece in self.pieces if piece.straight]
        pairs = list(zip(self.pieces, self.pieces[1:], strict=False))
        pairs += [(self.pieces[-1], self.pieces[0])] if self.closed else []
        return np.abs(np.concatenate([np.empty(0), *turns, *(_turns(_joint(*pair)) for pair in pairs)]))


@dataclass(frozen=True)
class Drawing:
    """The paths of a file, and the ``unit`` of length that it names, if any."""

    paths: tuple[DrawnPath, ...]
    unit: str = ""

    def path(self, part: str | None, closed: bool) -> DrawnPath:
        """Return the path called ``part``, or the only one that is ``closed``, or open; ValueError without one."""
        named = [path for path in self.paths if part is None or part in path.names]
        if not named:
            raise ValueError(f"has no part {part}: it has {_listed(self.paths)}")
        if len(named) > MOST_PATHS:
            raise ValueError(f"has {len(named)} paths, and at most {MOST_PATHS} are read: choose some with file.part")
        paths = _joined(named)
        fitting = [path for path in paths if path.rows or path.closed == closed]
        kind = "closed" if closed else "open"
        if len(fitting) > 1:
            text = f"has {len(fitting)} {kind} paths, and a shape is one path without holes"
            raise ValueError(f"{text}: choose one with file.part: {_listed(fitting)}")
        if not fitting and closed:
            text = f"the path {paths[0].names[0]} is open: {paths[0].opening:.4g} from end to end"
            raise ValueError(f"{text}, more than {GAP:g} of its size, {paths[0].size:.4g}")
        if not fitting:
            raise ValueError(f"the path {paths[0].names[0]} is closed: the outline of a wall is open")
        return fitting[0]


def read(path: Path) -> Drawing:
    """Return the curves in a file, by its ending; ValueError where it has none, or cannot be read."""
    ending = path.suffix.lower()
    readers = {".csv": _csv, ".svg": _svg, ".dxf": _dxf}
    if ending not in readers:
        raise ValueError(f"must end in {', '.join(readers)}")
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE[ending] + 1)
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}; it must be in the folder of the config") from None
    if len(content) > LARGEST_FILE[ending]:
        raise ValueError(f"is larger than {LARGEST_FILE[ending] / 2**20:g} MB, the most for {ending[1:].upper()}")
    found = readers[ending](content, path)
    if not found.paths:
        raise ValueError("has no curves: lines, polylines, arcs or splines")
    if not all(np.isfinite(piece.places).all() for each in found.paths for piece in each.pieces):
        raise ValueError("has a coordinate that is no finite number")
    return found


def _at(places: np.ndarray, along: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return places (m, 2) at lengths ``wanted`` (m,) of a polyline whose corners (n, 2) are at lengths ``along``."""
    return np.stack([np.interp(wanted, along, axis) for axis in places.T], axis=1)


def _turns(places: np.ndarray) -> np.ndarray:
    """Return the signed angles (n - 2,) between the steps from place to place (n, 2)."""
    steps = np.diff(places, axis=0) @ np.array([1.0, 1j])
    return np.angle(steps[1:] / np.where(steps[:-1] == 0.0, 1.0, steps[:-1]))


def _joint(one: Piece, other: Piece) -> np.ndarray:
    """Return three places around the end of a piece, from where the ``other`` goes on."""
    return np.stack([one.places[-2], one.places[-1], one.places[-1] + other.places[1] - other.places[0]])


def _listed(paths: Sequence[DrawnPath]) -> str:
    names = list(dict.fromkeys(path.names[0] for path in paths))
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def _joined(paths: Sequence[DrawnPath]) -> list[DrawnPath]:
    """Return closed paths as they are, and open ones with those joined whose ends meet."""
    found = [path for path in paths if path.closed or path.rows]
    ways = [way for path in paths if not (path.closed or path.rows) for way in (path, path.reversed())]
    if not ways:
        return found
    starts, ends = (np.array([way.pieces[end].places[end] for way in ways]) for end in (0, -1))
    near = GAP * float(np.linalg.norm(np.ptp(np.concatenate([way.places for way in ways]), axis=0)))
    free = np.ones(len(ways), dtype=bool)  # ways 2 k and 2 k + 1 are the path k forwards and backwards
    while free.any():
        chain = [int(np.argmax(free))]
        free[[chain[0], chain[0] ^ 1]] = False
        gap = 0.0
        for _ in range(2):  # onwards from the end, and then from the start
            while free.any():
                gaps = np.where(free, np.linalg.norm(starts - ends[chain[-1]], axis=1), math.inf)
                nearest = int(np.argmin(gaps))
                back = np.linalg.norm(starts[chain[0]] - ends[chain[-1]]) if len(chain) > 1 else math.inf
                if gaps[nearest] > near or back < gaps[nearest]:
                    break
                free[[nearest, nearest ^ 1]] = False
                gap = max(gap, float(gaps[nearest]))
                chain.append(nearest)
            chain = [way ^ 1 for way in chain[::-1]]
        names = tuple(dict.fromkeys(name for way in chain for name in ways[way].names))
        found.append(DrawnPath(names, tuple(piece for way in chain for piece in ways[way].pieces), gap))
    return found


NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def _csv(content: bytes, path: Path) -> Drawing:
    """Return the path through the rows of a table: two columns, or those headed x and y."""
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"is not UTF-8 text (byte {error.start})") from None
    columns, count, unit = [0, 1], 2, ""
    places: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        cells = [cell.strip(" \"'") for cell in re.split(r"\s*[,;\t]\s*|\s+(?![\[(])", line.strip())]
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if not places and not NUMBER.match(cells[0]):
            names = [re.sub(r"[\[(].*", "", cell).strip().lower() for cell in cells]
            if not {"x", "y"} <= set(names):
                raise ValueError(f"line {number}: a heading names the columns x and y")
            columns, count = [names.index("x"), names.index("y")], len(cells)
            unit = next(iter(re.findall(r"[\[(](\S+?)[\])]", cells[columns[0]])), "")
            continue
        if len(cells) != count:
            raise ValueError(f"line {number} has {len(cells)} values: a row has {count}, with a decimal point")
        try:
            places.append([float(cells[column]) for column in columns])
        except ValueError:
            raise ValueError(f"line {number} has a value that is no number") from None
        if not all(map(math.isfinite, places[-1])):
            raise ValueError(f"line {number} has a value that is no finite number")
    if len(places) < 3:
        raise ValueError(f"has {len(places)} points: a shape needs three or more")
    return Drawing((DrawnPath((path.stem,), (Piece(np.array(places)),), rows=True),), unit)


HIDDEN = {"defs", "clipPath", "mask", "symbol", "marker", "pattern"}
"""SVG elements that are not drawn where they stand."""


class _Elements:
    """The curves of an SVG text, with the transformations and the names of the groups around each."""

    def __init__(self, content: bytes):
        from xml.parsers import expat

        self.paths: list[DrawnPath] = []
        self.page: dict[str, str] = {}
        self._around: list[tuple[Any, tuple[str, ...], bool]] = [(np.eye(3), (), True)]
        self._count: dict[str, int] = {}
        parser = expat.ParserCreate()
        parser.StartElementHandler, parser.EndElementHandler = self._start, self._end
        parser.EntityDeclHandler = self._refuse
        try:
            parser.Parse(content, True)
        except expat.ExpatError as error:
            raise ValueError(f"is no SVG file: {error}") from None

    def _refuse(self, *_: Any) -> None:
        raise ValueError("declares entities, which are not allowed: save it as plain SVG")

    def _end(self, _: str) -> None:
        self._around.pop()

    def _start(self, tag: str, given: dict[str, str]) -> None:
        from svgpathtools.parser import parse_transform

        kind = tag.rpartition(":")[2]
        matrix, names, shown = self._around[-1]
        if kind == "svg" and not self.page:
            self.page = given
        elif kind == "svg" and {"x", "y", "viewBox"} & given.keys():
            raise ValueError("has a page in a page: save it as plain SVG")
        shown = shown and kind not in HIDDEN and given.get("display") != "none"
        shown = shown and not re.search(r"display\s*:\s*none", given.get("style", ""))
        own = [given[key] for key in ("id", "inkscape:label") if given.get(key)]
        try:
            matrix = matrix @ parse_transform(given.get("transform"))
            pieces = list(self._pieces(kind, given)) if shown else []
            if not all(np.isfinite(each.places).all() for each in pieces):
                raise ValueError("a coordinate is no finite number")
        except (ValueError, IndexError, TypeError, ZeroDivisionError, AssertionError) as error:
            raise ValueError(f"the {' '.join([kind, *own[:1]])} cannot be read: {error}") from None
        self._around.append((matrix, (*own, *names), shown))
        for index, run in enumerate(_runs(pieces)):
            self._count[kind] = self._count.get(kind, 0) + (index == 0)
            name = own[0] if own else f"{kind}{self._count[kind]}"
            first = f"{name}.{index + 1}" if index else name
            moved = tuple(Piece(each.places @ matrix[:2, :2].T + matrix[:2, 2], each.straight) for each in run)
            self.paths.append(DrawnPath(tuple(dict.fromkeys((first, name, *own, *names))), moved))

    @staticmethod
    def _pieces(kind: str, given: dict[str, str]) -> Iterator[Piece]:
        """Yield the pieces of an element, in its own coordinates."""
        from svgpathtools import CubicBezier, Line, parse_path, svg_to_paths

        if kind in ("polygon", "polyline"):
            places = np.array(list(map(float, NUMBER.findall(given.get("points", ""))))).reshape(-1, 2)
            places = np.concatenate([places, places[:1]]) if kind == "polygon" else places
            yield from [Piece(places)] if len(places) > 1 else []
            return
        if kind == "line":
            yield Piece(np.array([[float(given.get(f"{axis}{end}", 0)) for axis in "xy"] for end in "12"]))
            return
        texts = {
            "path": svg_to_paths.path2pathd,
            "circle": svg_to_paths.ellipse2pathd,
            "ellipse": svg_to_paths.ellipse2pathd,
            "rect": svg_to_paths.rect2pathd,
        }
        segments = list(parse_path(texts[kind](given))) if kind in texts else []
        segments = [each for each in segments if each.start != each.end or isinstance(each, CubicBezier)]
        lines, curves = (
            [isinstance(each, Line) for each in segments],
            sum(not isinstance(each, Line) for each in segments),
        )
        if curves > MOST_CURVES:
            raise ValueError(f"it has {curves} curves, and at most {MOST_CURVES} are read")
        sizes = [0.0 if line else _rough_length(each) for line, each in zip(lines, segments, strict=True)]
        whole = sum(sizes) if 0.0 < sum(sizes) < math.inf else math.inf
        for straight, group in groupby(range(len(segments)), key=lambda index: lines[index]):
            chosen = [segments[index] for index in group]
            if straight:
                ends = np.array([[each.start, each.end] for each in chosen])
                breaks = np.flatnonzero(ends[1:, 0] != ends[:-1, 1]) + 1
                for run in np.split(ends, breaks):
                    yield Piece(_pairs(np.append(run[:, 0], run[-1, 1])))
                continue
            for each in chosen:
                count = max(16, math.ceil(FINE * _rough_length(each) / whole))
                yield Piece(_pairs(_on_segment(each, np.linspace(0.0, 1.0, count + 1))), straight=False)


def _pairs(places: np.ndarray) -> np.ndarray:
    """Return complex places (n,) as (n, 2)."""
    return np.stack([places.real, places.imag], axis=1)


def _rough_length(segment: Any) -> float:
    """Return about the length of a segment of an SVG path."""
    return float(np.abs(np.diff(_on_segment(segment, np.linspace(0.0, 1.0, 16)))).sum())


def _on_segment(segment: Any, part: np.ndarray) -> np.ndarray:
    """Return complex places (n,) on a segment of an SVG path at parts (n,) of its parameter."""
    if not hasattr(segment, "rot_matrix"):
        return segment.poly()(part)
    angle = np.radians(segment.theta + part * segment.delta)
    along, across = segment.radius.real * np.cos(angle), segment.radius.imag * np.sin(angle)
    return segment.center + segment.rot_matrix * (along + 1j * across)


def _runs(pieces: Sequence[Piece]) -> Iterator[list[Piece]]:
    """Yield the pieces that follow each other without a gap: the parts of an SVG path after each M."""
    run: list[Piece] = []
    near = ROUNDING * max((float(np.abs(piece.places).max()) for piece in pieces), default=0.0)
    for piece in pieces:
        if run and (np.abs(run[-1].places[-1] - piece.places[0]) > near).any():
            yield run
            run = []
        run.append(piece)
    if run:
        yield run


def _svg(content: bytes, path: Path) -> Drawing:
    """Return the curves of an SVG file, with y upwards from the lower edge of its page."""
    try:
        import svgpathtools  # noqa: F401
    except ImportError:
        raise ValueError(EXTRA.format("svgpathtools")) from None
    found = _Elements(content)
    page = found.page
    box = [float(each) for each in NUMBER.findall(page.get("viewBox", ""))]
    size = re.fullmatch(rf"\s*({NUMBER.pattern})\s*(\w*)\s*", page.get("height", ""))
    left, top, height = 0.0, 0.0, float(size[1]) if size and size[2] in ("", "px") else 0.0
    if len(box) == 4:
        left, top, _, height = box
    unit = size[2] if size and len(box) == 4 and abs(float(size[1]) - height) <= 1e-3 * height else ""
    flipped = [
        tuple(Piece((each.places - [left, top + height]) * [1.0, -1.0], each.straight) for each in one.pieces)
        for one in found.paths
    ]
    paths = [replace(one, pieces=pieces) for one, pieces in zip(found.paths, flipped, strict=True)]
    return Drawing(tuple(paths), unit)


def _dxf(content: bytes, path: Path) -> Drawing:
    """Return the curves in the model space of a DXF file."""
    try:
        import ezdxf
    except ImportError:
        raise ValueError(EXTRA.format("ezdxf")) from None
    try:
        document = ezdxf.readfile(path)
        found = []
        for entity in document.modelspace():
            if pieces := tuple(_entity(entity)):
                found.append(DrawnPath((str(entity.dxf.handle), str(entity.dxf.layer)), pieces))
    except (ezdxf.DXFError, OSError, ValueError, TypeError, ArithmeticError, LookupError, AttributeError) as error:
        raise ValueError(f"is no DXF file that can be read: {error}") from None
    return Drawing(tuple(found), DXF_UNITS.get(document.units, ""))


def _entity(entity: Any) -> Iterator[Piece]:
    """Yield the pieces of a DXF entity; none for text, blocks and others."""
    kind = entity.dxftype()
    if kind == "LINE":
        yield Piece(np.array([entity.dxf.start, entity.dxf.end])[:, :2])
    elif kind in ("LWPOLYLINE", "POLYLINE"):
        if kind == "LWPOLYLINE" or entity.is_2d_polyline or entity.is_3d_polyline:
            yield from _in_order([piece for each in entity.virtual_entities() for piece in _entity(each)])
    elif kind in ("ARC", "CIRCLE"):
        yield _curved(entity.flattening(SAGITTA * entity.dxf.radius))
    elif kind == "ELLIPSE":
        yield _curved(entity.flattening(SAGITTA * entity.dxf.major_axis.magnitude))
    elif kind == "SPLINE":
        tool = entity.construction_tool()
        size = float(np.linalg.norm(np.ptp(np.array([tuple(each) for each in tool.control_points]), axis=0)))
        yield _curved(tool.flattening(SAGITTA * size, segments=16))


def _in_order(pieces: Sequence[Piece]) -> Iterator[Piece]:
    """Yield the pieces of a polyline, those reversed that are arcs clockwise: each begins where the last one ends."""

    def apart(one: np.ndarray, other: np.ndarray) -> float:
        return float(np.abs(one - other).sum())

    end: Any = None
    for piece, after in zip(pieces, [*pieces[1:], None], strict=True):
        first, last = piece.places[0], piece.places[-1]
        if end is not None:
            backwards = apart(last, end) < apart(first, end)
        else:  # the first one ends where the next one has an end
            ends = after.places[[0, -1]] if after else [last]
            backwards = min(apart(first, each) for each in ends) < min(apart(last, each) for each in ends)
        piece = Piece(piece.places[::-1], piece.straight) if backwards else piece
        end = piece.places[-1]
        yield piece


def _curved(vertices: Any) -> Piece:
    return Piece(np.array([(each[0], each[1]) for each in vertices]), straight=False)
