"""A cell with bodies, periodic or between walls: its bodies from a config, the errors of a config, and its views.

``Cell`` is the scene of a lattice, of a channel with bodies and of a planar region. It records forces and torques on
the bodies, motions of free bodies, mean velocities, and the mean shear stress of a sheared suspension.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.bodies import _clearance
from tisph.bodies._clearance import LEAST_GAP, size_problems
from tisph.bodies._clearance import problems as room_problems
from tisph.config.base import Problem
from tisph.config.motion import slip_length_of
from tisph.config.schema import Config
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.outline import EndToEnd
from tisph.geometry.region import Region
from tisph.measures import resolution
from tisph.measures.fits import cell_mean, section_mean
from tisph.scenes._cell_flow import (
    MEANS,
    MOTIONS,
    PLACES,
    STRESS_WORDS,
    VELOCITY,
    CellFlow,
    load_kinds,
)
from tisph.scenes._initial import still_problem
from tisph.scenes._scene import largest_speed
from tisph.scenes._spacing import wanted_spacing
from tisph.scenes._views import SHOWN, Profile, TimeSeries, velocity_profile
from tisph.snapshot import Snapshot

MOMENTS = 25
"""Number of times at which the gaps between moving bodies are checked."""


def cell_problems(config: Config, bodies: Sequence[Body], walls: dict[str, Body]) -> Iterator[Problem]:
    """Yield the errors in the ``config`` of a cell with these ``bodies``; ``walls`` by their names in messages."""
    if config.scheme.type == "wcsph" and config.bodies:
        yield "scheme.type", "wcsph cannot serve bodies yet; take auto or implicit"
    moving = any(largest_speed(body) or body.spin.largest_speed for body in (*bodies, *walls.values()))
    free: list[Any] = [body for body in bodies if body.free]
    pulled = any(any(body.motion.inertia.load) for body in free) or (free and config.drive.gravity)
    if not (moving or pulled or config.flows_through or config.drive.acceleration):
        remedy = "give an acceleration, or let a body or a wall move"
        yield from still_problem(config, "drive.acceleration", remedy)
    held = any(wall.slip_length < math.inf or isinstance(wall.shape, EndToEnd) for wall in walls.values())
    if config.drive.acceleration and not (held or bodies or config.flows_through):
        text = "must be 0 where no wall has friction (slip_length: infinite): nothing holds the fluid"
        yield "drive.acceleration", text
    if config.contact and not free:
        yield "contact", "is for free bodies: give one the motion free, or leave it out"
    for index, body in enumerate(bodies):
        if body.enters > config.start_time and not config.flows_through:
            yield f"bodies.{index}.enters", "is for a channel with open ends: leave it out"
        elif body.enters >= config.time.end:
            yield f"bodies.{index}.enters", "must be before the end of the run"
        if body.slip_length and free and config.flows_through:
            text = "must be left out between open ends with free bodies, which leave or enter"
            yield f"bodies.{index}.slip_length", text
    if config.drive.gravity and not free:
        yield "drive.gravity", "moves free bodies alone: give one the motion free, or leave it out"
    given = config.bodies
    listed = isinstance(given, tuple)
    shapes = [(f"bodies.{index}", given[index] if listed else given, body) for index, body in enumerate(bodies)]
    shapes += [(key, config.walls.around, wall) for key, wall in walls.items() if wall.shape.area]
    wanted = wanted_spacing(config, {f"bodies.{index}": body for index, body in enumerate(bodies)} | walls)
    found = [*size_problems(shapes, wanted, config.across)]
    known = not free and any(largest_speed(body) for body in bodies)  # motions that change the gaps
    times = np.linspace(0.0, config.time.end, MOMENTS).tolist() if known else (0.0,)
    found += room_problems(bodies, walls, wanted, times)
    yield from found if listed else dict.fromkeys(_in_common(problem, config) for problem in found)


def _in_common(problem: Problem, config: Config) -> Problem:
    """Return a problem of one body of a suspension with the key that all its bodies share.

    Bodies that are too close get the key of the cause: the least gap, or the motion.
    """
    key, text, *_ = problem
    if not key.startswith("bodies."):
        return key, text
    _, number, name = key.split(".")
    if name != "centre":
        return f"bodies.{name}", text
    close = config.bodies.least_gap < LEAST_GAP * (config.bodies.spacing or config.spacing)
    return "bodies.least_gap" if close else "bodies.motion", f"body {number} {text}"


@dataclass(frozen=True)
class Surroundings:
    """Causes of the motion of free bodies: ``density`` and ``acceleration`` along x of the fluid, ``gravity`` (2,)."""

    density: float
    acceleration: float
    gravity: tuple[float, float]

    @classmethod
    def of(cls, config: Config) -> "Surroundings":
        """Return the surroundings that a ``config`` describes."""
        return cls(config.fluid.density, config.drive.acceleration, config.drive.gravity or (0.0, 0.0))


def bodies_of(config: Config, walls: dict[str, Body], origin: tuple[float, float] = (0.0, 0.0)) -> list[Body]:
    """Return the bodies in the fluid between these ``walls``, in a cell whose lowest corner is ``origin``.

    Its periods are infinite where there are walls. ValidationError where a suspension does not fit.
    """
    sizes = zip(config.extent, config.periodic, strict=True)
    periods = tuple(size if periodic else math.inf for size, periodic in sizes)
    given = config.bodies
    if not isinstance(given, tuple):
        high = (origin[0] + config.extent[0], origin[1] + config.extent[1])
        given = given.bodies(Region(tuple(walls.values()), origin, high, config.periodic))
    return [body.body(periods, Surroundings.of(config)) for body in given]


def walls_along(config: Config) -> dict[str, Body]:
    """Return the walls ``bottom`` and ``top`` of a ``config`` by name: planes along x, or of the shape of an outline.

    In axisymmetric flow no wall is where the axis is.
    """
    length, height = config.extent
    low = config.geometry.inner_radius if config.axisymmetric else 0.0
    planes = {
        "bottom": Line((0.0, low), (1.0, 0.0), length),
        "top": Line((length, low + height), (-1.0, 0.0), length),
    }
    if config.axisymmetric and not low:
        del planes["bottom"]
    walls = {}
    for name, plane in planes.items():
        wall = getattr(config.walls, name)
        motion = RigidMotion(WallMotion.from_config(wall))
        periods = (length if config.periodic[0] and wall.outline else math.inf, math.inf)
        shape = wall.shape(name, config.periodic[0]) if wall.outline else plane
        walls[name] = Body(shape, motion=motion, periods=periods, slip_length=slip_length_of(wall))
    return walls


def planes(walls: dict[str, Body]) -> tuple[tuple[str, Any], ...]:
    """Return the pairs of ``Scene.walls``, (side, motion) from top to bottom, of walls from ``walls_along``."""
    return tuple((name, walls[name].motion.x) for name in ("top", "bottom"))


@dataclass(frozen=True)
class DevelopedFlow:
    """Steady flow of a Newtonian fluid in the channel without bodies: u = U_b + (U_t - U_b) y/gap + c y (gap - y)."""

    gap: float
    bottom: float
    top: float
    curvature: float

    @classmethod
    def of(cls, config: Config) -> "DevelopedFlow":
        """Return the flow of a ``config``, whose walls have constant velocities."""
        speeds = config.walls.bottom.velocity or 0.0, config.walls.top.velocity or 0.0
        return cls(config.geometry.gap, *speeds, config.drive.acceleration / (2.0 * config.kinematic_viscosity))

    def __call__(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the velocities (2, ...) along x and y."""
        along = self.bottom + (self.top - self.bottom) * y / self.gap + self.curvature * y * (self.gap - y)
        return np.stack([along + 0.0 * x, 0.0 * x])


MOST_RATIOS = 3
"""Most density ratios that are listed one by one."""


@dataclass(frozen=True, kw_only=True)
class Cell(CellFlow):
    """The flow in a cell with its views: profiles, panels over time, and lines that describe the flow."""

    without_bodies = "all"
    """Whose height the reference length is without bodies."""

    def profiles(self) -> list[Profile]:
        """Return both components of the velocity along the vertical centre line."""
        return [velocity_profile(self, field, "y") for field in "uv"]

    def time_series(self) -> TimeSeries:
        """Return forces and torques on the bodies, or on the walls of a cell without bodies, and the mean velocity.

        Also places and velocities of few free bodies, or only means of many, and the mean shear stresses of a sheared
        suspension.
        """
        chosen, free = slice(self.count or None), self.has_free_bodies
        pairs = zip(self.names[chosen], self.bodies[chosen], strict=True)
        forces = [
            (kind, name) for name, body in pairs if not (self._means_only and body.free) for kind in load_kinds(body)
        ]
        followed = [*forces, *self._motion_columns, *((name, "") for name in self.mean_stress_names)]
        columns = [f"{kind}{name}" for kind, name in followed]
        force, length, speed = self.force_scale, self.reference_length, self.reference_velocity
        sizes = {"drag": force, "lift": force, "torque": force * length, **self._motion_sizes}
        walls = max((wall.largest_speed for _, wall in self.walls), default=0.0)
        sizes |= dict.fromkeys(STRESS_WORDS, self.dynamic_viscosity * walls / self.size[1])
        units = {"drag": "force", "lift": "force", "torque": "torque"}
        panels = self._motion_panels if free else {kind: (f"{kind} per length", units[kind]) for kind, _ in forces}
        panels |= dict.fromkeys(STRESS_WORDS, ("mean shear stress", "stress"))
        # a single fixed body bears all of the drive
        alone = len(self.bodies) == self.count == 1 and not free and not self.fastest_body
        drive = self.density * self.acceleration * self.region.area

        def measure(snapshot: Snapshot) -> np.ndarray:
            found = {**self.loads(snapshot), **self.free_motions(snapshot), **self.mean_stresses(snapshot)}
            values = [np.nan if found[column] is None else found[column] for column in columns]
            seen: Any = self.seen(snapshot)
            place = seen.open_section(snapshot.t)
            if place is None:
                return np.array([*values, cell_mean(self, snapshot)[0]])
            return np.array([*values, section_mean(seen, snapshot, place, degree=2)])  # it costs less

        return TimeSeries(
            content=f"{'places and velocities of bodies, ' if free else ''}forces and torques of the fluid on bodies, "
            "and the mean velocity, over time t",
            name="force per length",
            unit="force",
            scale=force,
            columns=[*columns, VELOCITY],
            labels=[*((self._label(*each), None) for each in followed), ("mean over the cell", None)],
            measure=measure,
            sizes=[*(sizes[kind] for kind, _ in followed), speed],
            levels=[drive, *[np.nan] * len(columns)] if alone and self.isothermal else (),
            panels=[  # the mean velocity in a closed box is 0
                *(panels.get(kind) for kind, _ in followed),
                ("superficial velocity", "velocity") if self.periodic[0] else None,
            ],
            drifting=[f"{kind}{name}" for kind, name in followed if kind in PLACES],
        )

    @property
    def _motion_sizes(self) -> dict[str, float]:
        """Magnitude of each kind of motion, for axes and for the criterion of a steady state."""
        length, speed = self.reference_length, self.reference_velocity
        by_unit = {"length": length, "angle": 1.0, "velocity": speed, "rate": speed / length}
        return {kind: by_unit[unit] for kind, unit in (*MOTIONS.items(), *((kind, MEANS[kind][0]) for kind in MEANS))}

    @property
    def _motion_panels(self) -> dict[str, tuple[str, str]]:
        """Axes (name, unit) by kind of motion: places of few bodies, mean velocities of many."""
        if self._means_only:
            return {kind: (words, unit) for kind, (unit, words, _) in MEANS.items()}
        return {kind: (kind, MOTIONS[kind]) for kind in PLACES}

    def _label(self, kind: str, name: str) -> str:
        """Return the name of a recorded number in a legend."""
        if kind in STRESS_WORDS:
            return STRESS_WORDS[kind]
        if kind in MEANS:
            return MEANS[kind][2]
        return f"body {name.lstrip('_')}".rstrip() if self.count else f"wall {name.lstrip('_')}"

    def movie_series(self) -> TimeSeries:
        """Return forces on the bodies, or on the walls of a cell without bodies.

        With free bodies: the distance of two, without open ends; of many the relative viscosity in shear, else mean
        velocities. Of the first ``SHOWN`` of few the velocities along their weight or force; in shear the angles of
        those that are not round, one ellipse beside Jeffery's orbit; else the heights.
        """
        if not self.has_free_bodies:
            return self.time_series().only(("drag", "lift"), "force per length", "force")
        if len(self._free) == 2 and not self.flows_through:
            return self._distance_series()
        if self._means_only and self.mean_stress_names:
            return self._relative_viscosity_series()
        pull, body = np.abs(self._pull(self._free[0])), self.bodies[self._free[0]]
        orbit = None
        if self._means_only:
            kinds: tuple[str, ...] = ("bodies_mean_u", "bodies_mean_v")
        elif pull.any():
            kinds = ("u",) if pull[0] >= pull[1] else ("v",)
        elif self.mean_stress_names and not isinstance(body.shape, Circle):
            kinds, orbit = ("angle",), self._orbit(body)
        else:
            kinds = ("y",)
        found = [(kind, name) for kind, name in self._motion_columns if kind in kinds][:SHOWN]
        chosen = [f"{kind}{name}" for kind, name in found]
        name, unit = self._motion_panels.get(kinds[0], (f"{kinds[0]} of the body", "velocity"))

        def measure(snapshot: Snapshot) -> np.ndarray:
            values = self.free_motions(snapshot)
            return np.array([values[column] for column in chosen])

        return TimeSeries(
            content="places or velocities of bodies over time t",
            name=name,
            unit=unit,
            scale=self._motion_sizes[kinds[0]],
            columns=chosen,
            labels=[(self._label(*each), None) for each in found],
            measure=measure,
            exact=orbit[0] if orbit else lambda times: None,
            reference=orbit[1] if orbit else "",
        )

    def _orbit(self, body: Body) -> tuple[Callable, str] | None:
        """Return the angles (times, 1) of a free ellipse at times, and their name: Jeffery's orbit, without walls.

        In steady shear of the rate G the angle phi of its half axis a to x obeys tan(psi) = (a/b) tan(phi) with
        dpsi/dt = -G a b/(a^2 + b^2), if the fluid has no inertia. None for other shapes, walls and fluids.

        Source: G. B. Jeffery, Proc. R. Soc. Lond. A 102 (1922) 161-179, in two dimensions.
        """
        motion: Any = body.motion
        rate, steady = self._shear_rate(self.start_time), not any(wall.oscillates for _, wall in self.walls)
        if not (isinstance(body.shape, Ellipse) and steady and rate and len(self._free) == 1 and not self.rheology):
            return None
        if motion.inertia.held[2]:
            return None
        a, b = body.shape.half_axes

        def rotated(angle: Any, a: float, b: float) -> Any:  # psi of phi, and phi of psi with a and b exchanged
            sine, cosine = np.sin(angle), np.cos(angle)
            return angle + np.arctan2((a - b) * sine * cosine, b * cosine**2 + a * sine**2)

        def exact(times: np.ndarray) -> np.ndarray:
            psi = rotated(body.angle, a, b) - rate * a * b / (a**2 + b**2) * (times - self.start_time)
            return rotated(psi, b, a)[:, None]

        period = 2.0 * math.pi * (a / b + b / a) / abs(rate)
        return exact, f"Jeffery, without walls: period {period:.4g} {self.units.time}"

    def _distance_series(self) -> TimeSeries:
        """Return the distance between the centres of two free bodies, and where contact begins if both are round.

        A body that has left a periodic box counts where it comes in again.
        """
        near = sum(getattr(self.bodies[index].shape, "radius", math.nan) for index in self._free)
        near += self.contact_distance

        def measure(snapshot: Snapshot) -> np.ndarray:
            bodies: Any = snapshot.bodies
            apart = bodies.centre[self._free[0]] - bodies.centre[self._free[1]]
            nearest = apart - np.array(self.extent) * np.rint(apart / self.extent)
            return np.array([np.hypot(*np.where(self.periodic, nearest, apart))])

        return TimeSeries(
            content="distance of two bodies over time t",
            name="distance",
            unit="length",
            scale=self.reference_length,
            columns=["distance"],
            labels=[("between their centres", None)],
            measure=measure,
            levels=[near],
            level_name="contact",
            event=("contact", lambda distance: distance[0] <= near),
        )

    def _relative_viscosity_series(self) -> TimeSeries:
        """Return ``mean_stresses`` over viscosity and shear rate; NaN while the walls are not moving."""
        names = self.mean_stress_names[:2]

        def measure(snapshot: Snapshot) -> np.ndarray:
            stresses = self.mean_stresses(snapshot)
            viscous = self.dynamic_viscosity * self._shear_rate(snapshot.t) or math.nan
            return np.array([stresses[name] for name in names]) / viscous

        return TimeSeries(
            content="relative viscosity of the suspension over time t",
            name="relative viscosity",
            unit="number",
            scale=1.0,
            columns=[name.replace("shear_stress", "relative_viscosity") for name in names],
            labels=[(STRESS_WORDS[name], None) for name in names],
            measure=measure,
        )

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        length, time = self.units.length, self.units.time
        width, height = self.size
        known, cause = self._cause()
        about, digits = ("", 6) if known else ("about ", 2)
        of = "the largest body" if self.count else self.without_bodies
        lines = [
            ("Reynolds number", f"{about}{self.reynolds:.{digits}g}  (U d / nu)"),
            ("speed U", f"{about}{self.reference_velocity:.{digits}g} {length}/{time}, {cause}"),
            ("length d", f"{self.reference_length:.6g} {length}, the height of {of}"),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("cell", f"{width:.6g} x {height:.6g} {length}, {self.region.area / (width * height):.4g} of it fluid"),
        ]
        if self._free:
            free: list[Any] = [self.bodies[index] for index in self._free]
            ratios = [body.motion.inertia.mass[0] / (self.density * body.shape.area) for body in free]
            found = sorted({f"{ratio:.6g}" for ratio in ratios}, key=float)
            shown = found if len(found) <= MOST_RATIOS else [f"{found[0]} to {found[-1]}"]
            text = f"{len(free)} of {self.count}, of {', '.join(shown)} times the density of the fluid"
            lines.append(("free bodies", text))
        changes = "will change" if self._free else "may change"
        moves = "" if self.gaps_stay and not self._free else f" at the start; gaps {changes} as bodies move"
        radius, gap = self.narrowest(self.start_time)
        least_radius = f"at least {_clearance.LEAST_RADIUS:g}, a circle {0.5 * _clearance.LEAST_WIDTH:g}"
        least_gap = f"at least {_clearance.LEAST_GAP:g}"
        for name, (size, _, *there), least, enough, more in (
            ("smallest radius", radius, least_radius, resolution.LEAST_RADIUS, ""),
            ("narrowest gap", gap, least_gap, resolution.LEAST_GAP, moves),
        ):
            if np.isfinite(size):
                spacings = f"{size / there[0]:.3g} spacings ({least}; resolved from {enough:g} on)"
                lines.append((name, f"{size:.4g} {length}, {spacings}{more}"))
        if self.acceleration:
            lines.append(("drive", f"{self.acceleration:.6g} {length}/{time}^2 along x"))
        return lines

    def _cause(self) -> tuple[bool, str]:
        """Return whether the reference velocity is known exactly, and its cause in words."""
        if self.given_velocity:
            return True, "given by the config"
        if not (self.fastest_body or self.driven_velocity):
            return False, "a guess: nothing has a speed that is known"
        if self.driven_velocity >= self.fastest_body:
            return False, "an estimate: the mean velocity that the acceleration causes in a Newtonian fluid"
        if self.driven_wall >= self.fastest_body:
            return True, "of the fastest body or wall"
        return False, "an estimate: of a free body under its load, in slow flow or against inertia"
