"""Shapes from files: the keys below ``file`` of a body or wall, and the points that the file gives the config.

A file is read when its config is loaded; the resolved config has the points, and needs no file.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from tisph.config.base import Model, Positive, Signed, refusal, refusals, refuse
from tisph.config.fields import either
from tisph.geometry.drawing import METRES, ROUNDING, read
from tisph.geometry.shape import Shape, centroid
from tisph.geometry.tracing import Ends, deviation, smooth_points

NEARLY = 1e-6
"""Distance of the ends of an outline from x = 0 and x = length, over the length, that counts as rounding."""

Text = Annotated[str, Field(min_length=1, max_length=200)]


class ShapeFile(Model):
    """A drawing: CSV (columns x, y), SVG or DXF file, at a ``path`` in the folder of the config, or below it.

    ``unit``: unit of its numbers, which are in that of the config without it; ``scale``: factor of all lengths;
    ``angle`` [radians]: the drawing is rotated around its origin; ``part``: name of the path, or of the group or layer
    around it, where there are several; ``smoothing`` [length]: largest distance of a smoother curve from the path.
    """

    unset_keys: ClassVar[tuple[str, ...]] = ("unit", "scale", "angle", "part", "smoothing")

    path: Text
    unit: Text | None = None
    scale: Positive | None = None
    angle: Signed | None = None
    part: Text | None = None
    smoothing: Positive | None = None

    @field_validator("path")
    @classmethod
    def _check_path(cls, path: str) -> str:
        given = PureWindowsPath(path)  # which knows both slashes
        if given.anchor or ".." in given.parts:
            raise refusal("must be in the folder of the config, or in a folder below it")
        return path

    def factor(self, unit: Any) -> float:
        """Return the factor of all lengths for a config with this ``unit`` of length; ValueError if it is unknown."""
        scale = self.scale or 1.0
        if self.unit is None:
            return scale
        for name, key in ((self.unit, "file.unit"), (unit, "units.length")):
            if name not in METRES:
                raise ValueError(f"{key} must be one of {', '.join(METRES)} where file.unit is given, not {name}")
        return scale * METRES[self.unit] / METRES[unit]


class OutlineFile(ShapeFile):
    """A drawing of the outline of a wall, whose left end is at ``start`` [x, y] [length]; else where it is drawn."""

    unset_keys = (*ShapeFile.unset_keys, "start")

    start: Annotated[tuple[Signed, Signed], Field(strict=False)] | None = None


def _file(model: type[ShapeFile]) -> Any:
    """Return the type of the key ``file``: a map, or the path of the file alone."""
    return either(model, Text, lambda value: isinstance(value, str), "the path of a file")


if TYPE_CHECKING:
    File = OfOutline = ShapeFile | str
else:
    File, OfOutline = _file(ShapeFile), _file(OutlineFile)


class _Given(Model):
    """The key ``file`` alone, so that errors name it."""

    file: File


class _GivenOutline(Model):
    """The key ``file`` of a wall alone."""

    file: OfOutline


@dataclass(frozen=True, eq=False)
class Traced:
    """What a file gave a shape.

    ``places`` (n, 2) of its path, in the frame of the shape; number of ``points`` of the shape, its ``smallest_radius``
    and its ``deviation`` from the path [length]; ``gap`` between ends that were joined; ``unit`` named in the file;
    ``taken``: unit that its numbers were taken in.
    """

    path: str
    places: np.ndarray
    points: int
    smallest_radius: float
    deviation: float
    gap: float
    unit: str
    taken: str

    def __eq__(self, other: object) -> bool:
        """Return True: configs are equal by their points, wherever these are from."""
        return True

    def described(self, length: str) -> str:
        """Return what ``tisph check`` says of it; ``length``: unit of the config."""
        radius = f"smallest radius {self.smallest_radius:.4g} {length}" if self.smallest_radius else "sharp corners"
        parts = [f"{self.points} points", radius if self.smallest_radius < math.inf else "straight"]
        parts.append(f"at most {self.deviation:.2g} {length} from the path of the file")
        parts += [f"a gap of {self.gap:.2g} {length} closed"] if self.gap else []
        parts += [f"the file names {self.unit}, its numbers count as {self.taken}"] if self.unit != self.taken else []
        return f"{self.path}: {'; '.join(parts)}"


class FromFile(Model):
    """Base of shapes whose points, under the key ``points_key``, may come from a ``file``."""

    points_key: ClassVar[str]
    encloses: ClassVar[bool] = True
    """Whether the shape is a closed curve; else it leads from end to end of a channel."""
    smooth_words: ClassVar[str] = "type: curve"
    """What makes the shape a smooth curve."""

    file: File | None = None
    _traced: Traced | None = PrivateAttr(None)

    @property
    def traced(self) -> Traced | None:
        """What the file of the shape gave, None without one."""
        return self._traced

    @classmethod
    def smooth_of(cls, data: Mapping[str, Any]) -> bool:
        """Return whether raw ``data`` are a smooth curve."""
        raise NotImplementedError

    @classmethod
    def shape_through(cls, points: np.ndarray, data: Mapping[str, Any], periodic: bool) -> Shape:
        """Return the shape through ``points`` (n, 2); ValueError where it is impossible."""
        raise NotImplementedError

    @model_validator(mode="wrap")
    @classmethod
    def _read_file(cls, data: Any, handler: ModelWrapValidatorHandler[Any], info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or data.get("file") is None:
            return handler(data)
        if data.get(cls.points_key) is not None:
            raise refusals([(("file",), f"give file or {cls.points_key}, not both", data["file"])])
        given = data["file"]
        holder = _Given if cls.encloses else _GivenOutline
        file: Any = holder.model_validate({"file": {"path": given} if isinstance(given, str) else given}).file
        if file.smoothing is not None and not cls.smooth_of(data):
            text = f"is for smooth curves: give {cls.smooth_words}"
            refuse([(("file", "smoothing"), text, file.smoothing)])
        try:
            found, traced = cls._points(file, data, info.context or {})
        except ValueError as error:
            if isinstance(error, ValidationError):
                raise
            raise refusals([(("file",), str(error), data["file"])]) from None
        model = handler({key: value for key, value in data.items() if key != "file"} | found)
        model._traced = traced
        return model

    @classmethod
    def _points(cls, file: ShapeFile, data: Mapping[str, Any], context: Mapping[str, Any]) -> tuple[Any, Traced]:
        """Return the keys that the file gives, and the rest; ``context``: folder and raw data of the config."""
        whole = context.get("data", {})
        unit = whole["units"].get("length", "m") if isinstance(whole.get("units"), dict) else "m"
        drawing, smooth, closed = read(Path(context.get("folder", ".")) / file.path), cls.smooth_of(data), cls.encloses
        path, periodic = drawing.path(file.part, closed), not closed and whole.get("ends") is None
        path = path.moved(file.factor(unit), file.angle or 0.0, rising=not closed)
        if smooth:
            if closed:
                path.check_steps()
            ends: Ends = "closed" if closed else "periodic" if periodic else "level"
            points = smooth_points(path, ends, file.smoothing, lambda each: cls.shape_through(each, data, periodic))
        elif path.straight:
            points = path.places[: -1 if closed and path.opening <= ROUNDING * path.size else None]
        else:
            raise ValueError(f"the path {path.names[0]} has curved parts: give {cls.smooth_words}")
        found, shift = {}, np.zeros(2)
        if closed:
            shift = -centroid(cls.shape_through(points, data, periodic))
            found = {} if data.get("centre") is not None else {"centre": (-shift).tolist()}
        elif isinstance(file, OutlineFile) and file.start is not None:
            shift = np.array(file.start) - points[0]
        points = points + shift if closed else _snapped(points + shift, whole)
        shape = cls.shape_through(points, data, periodic)
        places = (path.places if path.rows and file.smoothing is None else path.dense) + shift
        gap = max(path.gap, path.opening if closed and not path.rows else 0.0)
        taken = file.unit or str(unit)
        traced = Traced(
            path=file.path,
            places=places,
            points=len(points),
            smallest_radius=shape.smallest_radius,
            deviation=deviation(shape, places),
            gap=gap if gap > ROUNDING * path.size else 0.0,
            unit=drawing.unit or taken,
            taken=taken,
        )
        return {**found, cls.points_key: points.tolist()}, traced


def _snapped(points: np.ndarray, whole: Mapping[str, Any]) -> np.ndarray:
    """Return ``points`` (n, 2) that lead exactly from x = 0 to the length of the raw config, where they nearly do."""
    geometry = whole.get("geometry")
    length = geometry.get("length") if isinstance(geometry, dict) else None
    for index, x in ((0, 0.0), (-1, length)):
        if isinstance(x, int | float) and abs(points[index, 0] - x) <= NEARLY * np.ptp(points[:, 0]):
            points[index, 0] = x
    return points
