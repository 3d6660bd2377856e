"""A picture of a config before it runs: walls and their motion, bodies, open ends, particles, drive and sampled places.

Grey is solid. Arrows on walls and bodies are their velocities when they are fastest, in both directions where these
change sign; arrows at an inlet are its profile. Paths that were read from files are drawn over the shapes. Flow around
an axis is drawn in the half-plane above the axis.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon as Patch
from matplotlib.patches import Rectangle

from tisph.config.schema import Config
from tisph.errors import TisphError
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion
from tisph.report import style
from tisph.report.labels import axis_exponent, axis_label, coordinate_name, cut_name, number, unit_label
from tisph.scenes._scene import Scene
from tisph.scenes._spacing import parts_of

WIDTH, LEAST_HEIGHT, MOST_HEIGHT = 9.0, 1.4, 6.0
"""Width and heights of the box [inches]."""

RIM = 0.1
"""Room for walls around the box, over its shorter side."""

POINTS, ARROWS, TIMES = 400, 9, 400
"""Points on a wall, arrows along it, and times at which its velocity is compared."""

MOST_PARTICLES, DOT = 6000, 0.5
"""Most particles that are drawn one by one, and their diameter in spacings. Of more a spacing that varies is shaded."""

CELLS = 200
"""Places along each side at which the spacing is shaded."""

BOX: dict[str, Any] = {"facecolor": style.LIGHT.background, "edgecolor": "none", "pad": 1.5}
"""Ground of words on hatched walls."""

ONE_WAY = 1e-3
"""Velocity against the largest one, over it, up to which a wall counts as moving one way."""


def preview(config: Config, scene: Scene) -> style.PlotFigure:
    """Return the picture of a ``config`` and its ``scene``."""
    with style.plot_style():
        return _Picture(config, scene).figure


def save_preview(path: Path, config: Config, scene: Scene) -> None:
    """Write the picture to a PNG file; TisphError where that is impossible."""
    try:
        preview(config, scene).save(path)
    except OSError as error:
        raise TisphError(f"{path}: cannot be written: {error.strerror or error}") from None


class _Picture:
    """The figure being drawn; ``rim`` [length]: thickness of walls around the box from ``low`` to ``high``."""

    def __init__(self, config: Config, scene: Scene):
        self.config, self.scene, self.units = config, scene, scene.units
        self.low, size = np.array(scene.origin), np.array(scene.extent)
        self.high, self.rim = self.low + size, RIM * float(size.min())
        across, up = size + 2.0 * self.rim
        scale = min(WIDTH / across, MOST_HEIGHT / up)
        width, height = scale * across, max(scale * up, LEAST_HEIGHT)
        self.figure = style.plot_figure()
        self.figure.set_size_inches(max(width, 7.0) + 2.0, height + 2.2)
        whole = self.figure.get_size_inches()
        place = (0.95 / whole[0], 1.15 / whole[1], width / whole[0], height / whole[1])
        self.axes: Axes = self.figure.add_axes(place)
        self.length = 0.12 * min(size.max(), 4.0 * size.min())  # of the longest arrow
        self._frame()
        self._particles()
        for key, part in self._parts().items():
            self._part(key, part)
        for end in (body for body in scene.bodies if not body.solid):
            self._end(end)
        self._drive()
        self._sampled()
        self._files()
        self._words()

    def _frame(self) -> None:
        axes, unit = self.axes, self.units.length
        (left, bottom), (right, top) = self.low, self.high
        axes.set(xlim=(left - self.rim, right + self.rim), ylim=(bottom - self.rim, top + self.rim), aspect="equal")
        exponent = axis_exponent(float(np.abs((self.low, self.high)).max()))
        axes.locator_params(axis="x", nbins=8)
        axes.locator_params(axis="y", nbins=6)
        for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y")):
            style.format_ticks(axis, exponent)
            axis.set_label_text(axis_label(coordinate_name(self.scene, name), unit, exponent))
        for spine in axes.spines.values():
            spine.set_visible(False)
        x_periodic, y_periodic = self.scene.periodic
        dashes: Any = {"linestyle": (0, (6, 4)), "linewidth": 1.0, "color": style.MUTED}
        for x in (left, right) if x_periodic else ():
            axes.plot([x, x], [bottom, top], **dashes)
        for y in (bottom, top) if y_periodic else ():
            axes.plot([left, right], [y, y], **dashes)
        if x_periodic or y_periodic:
            axes.plot([], [], label="periodic side", **dashes)
        if self.scene.axisymmetric and bottom == 0.0:
            line: Any = {"linestyle": (0, (9, 3, 2, 3)), "linewidth": 1.0, "color": style.TEXT}
            axes.plot([left, right], [0.0, 0.0], label="axis", **line)

    def _particles(self) -> None:
        scene, wanted = self.scene, self.scene.wanted_spacing
        label = axis_label("particle spacing", self.units.length)
        if scene.particles <= MOST_PARTICLES:
            x, y = scene.jittered(self.config.initial.seed, self.config.initial.jitter)
            width = wanted.at(np.stack([x, y], axis=1), scene.start_time)
            dots = self.axes.scatter(
                x, y, s=np.clip((DOT * self._points(width)) ** 2, 0.3, 40.0), linewidths=0.0, zorder=1,
                c=width if wanted.varies else style.PARTICLES,
            )  # fmt: skip
            if wanted.varies:
                self._bar(dots, label)
        elif wanted.varies:
            sides = [np.linspace(low, high, CELLS) for low, high in zip(self.low, self.high, strict=True)]
            places = np.stack(np.meshgrid(*sides), axis=2).reshape(-1, 2)
            spacing = np.where(scene.region.distance(places) > 0.0, wanted.at(places, scene.start_time), np.nan)
            self._bar(self.axes.pcolormesh(*sides, spacing.reshape(CELLS, CELLS), shading="nearest", zorder=0), label)

    def _bar(self, drawn: Any, label: str) -> None:
        bar = self.figure.colorbar(drawn, ax=self.axes, fraction=0.04, pad=0.02)
        bar.set_label(label)

    def _points(self, length: np.ndarray) -> np.ndarray:
        """Return lengths (n,) in points of the picture."""
        width = self.axes.get_position().width * self.figure.get_size_inches()[0]
        return 72.0 * length * width / float(np.ptp(self.axes.get_xlim()))

    def _parts(self) -> dict[str, Body]:
        """Return bodies and walls by their keys; of parallel flow its two planes."""
        scene = self.scene
        if found := parts_of(scene):
            return found
        (left, bottom), (right, top) = self.low, self.high
        lines = {
            "bottom": Line((left, bottom), (1.0, 0.0), right - left),
            "top": Line((right, top), (-1.0, 0.0), right - left),
        }
        moving = {side: motion for side, motion in scene.walls if not motion.stress_controlled}
        return {
            f"walls.{side}": Body(lines[side], motion=RigidMotion(moving[side]))
            if side in moving
            else Body(lines[side])
            for side, _ in scene.walls
        }

    def _part(self, key: str, part: Body) -> None:
        """Fill the solid, and draw the arrows and words of its motion."""
        t, shape = self.scene.start_time, part.shape
        points = part.boundary_points(shape.length / POINTS, t)
        place = points.point
        edge: dict[str, Any] = {"facecolor": style.LIGHT.solid, "edgecolor": style.LIGHT.solid_edge, "zorder": 2}
        if shape.area and shape.fluid_side == "inside":
            box = np.array([self.low - self.rim, self.high + self.rim])
            around = np.array([[box[i, 0], box[j, 1]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))])
            self.axes.fill(
                *np.concatenate([around, place, place[:1], around[:1]]).T, color=style.LIGHT.solid, zorder=0.5
            )
            self.axes.plot(*np.concatenate([place, place[:1]]).T, color=style.LIGHT.solid_edge, linewidth=1.0, zorder=2)
        elif shape.area:
            cell = Rectangle((self.low[0], self.low[1]), *(self.high - self.low), transform=self.axes.transData)
            for offset in ((0.0, 0.0), *part.periodic_offsets()):
                patch = self.axes.add_patch(Patch(place + offset, **edge))
                patch.set_clip_path(cell)
        else:
            first, last = part.at(t).to_lab_frame(_ends(shape))
            line = np.concatenate([first[None], place, last[None]])
            behind = self._behind(line, points.normal)
            self.axes.add_patch(Patch(np.concatenate([line, behind[::-1]]), hatch="///", **{**edge, "linewidth": 0.0}))
            self.axes.plot(*line.T, color=style.LIGHT.solid_edge, linewidth=1.2, zorder=2)
        self._motion(key, part, points)

    def _behind(self, line: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """Return the back (n, 2) of a wall along ``line``: to the edge of the picture, or a rim behind it."""
        mean = normal.mean(axis=0)
        if abs(mean[1]) < 0.5:
            return line - self.rim * mean / np.linalg.norm(mean)
        edge = self.low[1] - self.rim if mean[1] > 0.0 else self.high[1] + self.rim
        return np.stack([line[:, 0], np.full(len(line), edge)], axis=1)

    def _motion(self, key: str, part: Body, points: Any) -> None:
        """Draw arrows where the solid moves in the plane, and say how it moves."""
        times = np.linspace(self.scene.start_time, self.config.time.end, TIMES)
        count = min(ARROWS, max(1, int(part.shape.length / (1.8 * self.length))))
        index = ((np.arange(count) + 0.5) * len(points.point) / count).astype(int)
        seen = (points.point >= self.low - self.rim) & (points.point <= self.high + self.rim)
        index = index[seen.all(axis=1)[index]]
        chosen, normal = points.point[index], points.normal[index]
        middle, words = points.point.mean(axis=0), ["free"] if part.free else []
        if not part.free and len(chosen):
            found = np.array([part.velocity(chosen, t) for t in times[1:]])
            speed = np.linalg.norm(found, axis=2).max(axis=1)
            fastest, largest = found[np.argmax(speed)], float(speed.max())
            if largest > 0.0:
                back = (found * fastest).sum(axis=2).min() < -ONE_WAY * largest**2
                for way in (1.0, -1.0)[: 1 + back]:
                    self._arrows(chosen - 0.5 * self.rim * normal, way * fastest / largest, style.TEXT)
                turning = part.motion.rotation.largest_speed
                along = max(part.motion.x.largest_speed, part.motion.y.largest_speed)
                size = [(turning, f"rad/{self.units.time}")] if turning and not along else []
                size = size or [(largest, unit_label("velocity", self.units))]
                words += [f"{'±' * bool(back)}{number(each)} {unit}" for each, unit in size]
            rates = unit_label("velocity", self.units), f"rad/{self.units.time}"
            for component, unit in zip((part.motion.x, part.motion.rotation), rates, strict=True):
                if (before := getattr(component, "before", None)) is not None:
                    words.append(f"{number(before)} {unit} before t = 0")
        if part.spin.largest_speed:
            words.append(f"turns, {number(part.spin.largest_speed)} rad/{self.units.time}")
        wall = self._given(key)
        words += ["stress-controlled"] * bool(getattr(wall, "stress_controlled", False))
        if getattr(wall, "slip_length", None):
            words.append(f"slip length {wall.slip_length}")
        words += [f"{name}: {text}" for name, text in self._conditions(key)]
        if not words:
            return
        if not part.shape.area:
            middle = middle - 0.5 * self.rim * points.normal.mean(axis=0)
        elif part.shape.fluid_side == "inside":
            middle = np.array([0.5 * (self.low[0] + self.high[0]), self.high[1] + 0.5 * self.rim])
        self.axes.text(
            middle[0], middle[1], ", ".join(words), ha="center", va="center", fontsize=9, zorder=5, parse_math=False,
            rotation=90 if not part.shape.area and abs(points.normal.mean(axis=0)[0]) > 0.7 else 0,
            bbox=BOX,
        )  # fmt: skip

    def _conditions(self, key: str) -> Iterator[tuple[str, str]]:
        """Yield name and condition of temperature and dissolved substances at a wall."""
        config = self.config
        carried = [("temperature", config.temperature)] if config.temperature else []
        for name, section in [*carried, *((each.name, each) for each in config.scalars)]:
            condition = section.walls.get(key.rpartition(".")[2]) if key.startswith("walls.") else None
            if condition is not None:
                flux = getattr(condition, "flux", None)
                yield name, f"{condition}" if flux is None else f"flux {flux}"

    def _given(self, key: str) -> Any:
        """Return the model of a wall or body by its key, None where the config has none."""
        section, _, name = key.partition(".")
        owner = getattr(self.config, section, None)
        if isinstance(owner, tuple) and name.isdecimal():
            return owner[int(name)]
        return getattr(owner, name, None)

    def _arrows(
        self, places: np.ndarray, vectors: np.ndarray, colour: str, pivot: Any = "mid", width: float = 0.0025
    ) -> None:
        vectors = self.length * vectors
        self.axes.quiver(
            *places.T, *vectors.T, angles="xy", scale_units="xy", scale=1.0, width=width, color=colour, zorder=4,
            headwidth=5.0, pivot=pivot,
        )  # fmt: skip

    def _end(self, end: Any) -> None:
        """Draw an open end: the profile of an inlet, or a dotted line."""
        times = np.linspace(self.scene.start_time, self.config.time.end, TIMES)
        line = _ends(end.shape)
        self.axes.plot(*line.T, ":", color=style.EXACT, linewidth=1.6, zorder=3)
        words = "outlet"
        if end.moves_fluid:
            points = end.boundary_points(end.shape.length / (2 * ARROWS)).point
            found = np.array([end.velocity(points, t) for t in times])
            fastest = found[np.argmax(np.abs(found).max(axis=(1, 2)))]
            self._arrows(points, fastest / np.abs(fastest).max(), style.EXACT, "tail")
            words = f"inlet, {number(float(np.abs(fastest).max()))} {unit_label('velocity', self.units)}"
        elif self.scene.drive_shown[1] == "stress":
            words = f"pressure {number(end.pressure)} {unit_label('stress', self.units)}"
        place = line.mean(axis=0) - 0.5 * self.rim * np.array(end.shape.normal)
        style_of: Any = {
            "ha": "center",
            "va": "center",
            "rotation": 90,
            "fontsize": 9,
            "color": style.EXACT,
            "zorder": 5,
        }
        self.axes.text(place[0], place[1], words, parse_math=False, **style_of)

    def _sampled(self) -> None:
        """Draw the lines of profiles and the places of probes."""
        lines: dict[tuple[float, ...], list[str]] = {}
        for profile in self.scene.all_profiles():
            if profile.line.half_width < np.inf or np.ndim(profile.line.place):
                ends = np.stack(np.broadcast_arrays(*profile.line.points(np.array(profile.line.ends))), axis=1)
                lines.setdefault(tuple(np.ravel(ends).tolist()), []).append(cut_name(profile, self.scene))
        for (x, y, end_x, end_y), names in lines.items():
            self.axes.plot([x, end_x], [y, end_y], "--", color=style.LIGHT.series[1], linewidth=1.2, zorder=3,
                           label=f"profile of {_merged(names)}")  # fmt: skip
        if probes := getattr(self.scene, "probe_positions", None):
            x, y = probes(**self.config.time_series)
            self.axes.plot(x, y, "+", color=style.LIGHT.series[1], markersize=8, zorder=4, label="probes")

    def _files(self) -> None:
        """Draw the paths that shapes were read from."""
        parts = self._parts()
        for key, traced in self.config.at_walls("traced").items():
            part = parts.get(key)
            places = part.at(self.scene.start_time).to_lab_frame(traced.places) if part else traced.places
            places = places[:: max(1, len(places) // 4000)]
            self.axes.plot(*places.T, "-", color=style.EXACT, linewidth=0.8, zorder=4, label=f"path of {traced.path}")

    def _drive(self) -> None:
        """Draw the drive as an arrow in the fluid, if it is no velocity of a wall or an inlet."""
        name, unit, drive = self.scene.drive_shown
        if not any(drive) or unit == "velocity":
            return
        size, middle = float(np.hypot(*drive)), self.low + [0.2, 0.25] * (self.high - self.low)
        self._arrows(middle[None], np.array([drive]) / size, style.LIGHT.series[0], width=0.008)
        words = f"{name} {number(size)} {unit_label(unit, self.units)}"
        self.axes.annotate(
            words, (middle[0], middle[1]), (0.0, 12.0), textcoords="offset points", ha="center", va="bottom",
            fontsize=9, zorder=5, color=style.LIGHT.series[0], bbox=BOX,
        )  # fmt: skip

    def _words(self) -> None:
        scene, figure = self.scene, self.figure
        height = figure.get_size_inches()[1]
        wanted = scene.wanted_spacing
        spacing = f"{number(wanted.smallest)} to " * wanted.varies + number(wanted.largest)
        facts = [
            f"Re = {number(scene.reynolds)}",
            f"{scene.particles} particles, spacing {spacing} {self.units.length}",
        ]
        times = self.config.time.samples
        shown = ", ".join(f"{t:g}" for t in times[-4:])
        facts.append(f"samples at t = {'..., ' * (len(times) > 4)}{shown} {self.units.time}")
        figure.text(0.02, 1.0 - 0.28 / height, self.config.heading, fontsize=15, weight="bold", va="center",
                    parse_math=False)  # fmt: skip
        figure.text(0.02, 1.0 - 0.62 / height, "     ".join(facts), fontsize=10, color=style.MUTED, va="center",
                    parse_math=False)  # fmt: skip
        if self.axes.get_legend_handles_labels()[1]:
            figure.legend(loc="lower center", ncols=4, frameon=False, fontsize=9)


def _ends(shape: Any) -> np.ndarray:
    """Return the first and the last place (2, 2) of a straight wall or an outline."""
    if isinstance(shape, Line):
        return np.stack([shape.point, shape.point + shape.length * np.array(shape.tangent)])
    return np.array(shape.ends)


def _merged(names: list[str]) -> str:
    """Return names such as u at x = 1 and v at x = 1 as one: u, v at x = 1."""
    heads, _, tails = zip(*(name.partition(" at ") for name in names), strict=True)
    return ", ".join(dict.fromkeys(heads)) + (f" at {tails[0]}" if tails[0] else "")
