"""A cell with bodies, periodic or between walls: fluid around the bodies, driven by bodies, walls or an acceleration.

``Cell`` is the scene of a lattice, of a channel with bodies and of a planar region. It records forces and torques on
the bodies, motions of free bodies, mean velocities, and the mean shear stress of a sheared suspension.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tisph.bodies import _clearance
from tisph.bodies._clearance import LEAST_GAP, size_problems
from tisph.bodies._clearance import problems as room_problems
from tisph.config.base import Problem
from tisph.geometry.body import POINTS, Body, smallest_gap
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.region import Region
from tisph.measures import resolution
from tisph.measures.fits import cell_mean, section_mean
from tisph.scenes._initial import still_problem
from tisph.scenes._scene import BodyScene, bodies_in, farthest, largest_speed
from tisph.scenes._views import Profile, TimeSeries, planar_diagnostics, velocity_profile
from tisph.snapshot import Snapshot

MOMENTS = 25
"""Number of times at which the gaps between moving bodies are checked."""


def cell_problems(config: Any, bodies: Sequence[Body], walls: dict[str, Body]) -> Iterator[Problem]:
    """Yield the errors in the ``config`` of a cell with these ``bodies``; ``walls`` by their names in messages."""
    if config.scheme.type == "wcsph" and config.bodies:
        yield "scheme.type", "wcsph cannot serve bodies yet; take auto or implicit"
    moving = any(largest_speed(body) or body.spin.largest_speed for body in (*bodies, *walls.values()))
    free: list[Any] = [body for body in bodies if body.free]
    pulled = any(any(body.motion.inertia.load) for body in free) or (free and config.drive.gravity)
    if not (moving or pulled or config.has_open_ends or config.drive.acceleration):
        remedy = "give an acceleration, or let a body or a wall move"
        yield from still_problem(config, "drive.acceleration", remedy)
    if config.contact and not free:
        yield "contact", "is for free bodies: give one the motion free, or leave it out"
    if config.drive.gravity and not free:
        yield "drive.gravity", "moves free bodies alone: give one the motion free, or leave it out"
    given = config.bodies
    listed = isinstance(given, tuple)
    shapes = [(f"bodies.{index}", given[index] if listed else given, body) for index, body in enumerate(bodies)]
    shapes += [(key, config.walls.around, wall) for key, wall in walls.items() if wall.shape.area]
    found = [*size_problems(shapes, config.spacing, config.across)]
    known = not free and any(largest_speed(body) for body in bodies)  # motions that change the gaps
    times = np.linspace(0.0, config.time.end, MOMENTS).tolist() if known else (0.0,)
    found += room_problems(bodies, walls, config.spacing, times)
    yield from found if listed else dict.fromkeys(_in_common(problem, config) for problem in found)


def _in_common(problem: Problem, config: Any) -> Problem:
    """Return a problem of one body of a suspension with the key that all its bodies share.

    Bodies that are too close get the key of the cause: the least gap, or the motion.
    """
    key, text, *_ = problem
    if not key.startswith("bodies."):
        return key, text
    _, number, name = key.split(".")
    if name != "centre":
        return f"bodies.{name}", text
    close = config.bodies.least_gap < LEAST_GAP * config.spacing
    return "bodies.least_gap" if close else "bodies.motion", f"body {number} {text}"


@dataclass(frozen=True)
class Surroundings:
    """Causes of the motion of free bodies: ``density`` and ``acceleration`` along x of the fluid, ``gravity`` (2,)."""

    density: float
    acceleration: float
    gravity: tuple[float, float]

    @classmethod
    def of(cls, config: Any) -> "Surroundings":
        """Return the surroundings that a ``config`` describes."""
        return cls(config.fluid.density, config.drive.acceleration, config.drive.gravity or (0.0, 0.0))


def bodies_of(config: Any, walls: dict[str, Body], origin: tuple[float, float] = (0.0, 0.0)) -> list[Body]:
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


def plane_walls(length: float, gap: float, walls: Any) -> dict[str, Body]:
    """Return the walls ``bottom`` at y = 0 and ``top`` at y = ``gap`` by name, with a period ``length`` along x.

    ``walls``: a config section with ``bottom`` and ``top``, motions along x. A wall with an ``outline`` has its shape.
    """
    shapes: dict[str, Any] = {
        "bottom": Line((0.0, 0.0), (1.0, 0.0), length),
        "top": Line((length, gap), (-1.0, 0.0), length),
    }
    given = {name: getattr(walls, name) for name in shapes}
    shapes |= {name: wall.shape(name) for name, wall in given.items() if getattr(wall, "outline", None)}
    motions = {name: RigidMotion(WallMotion.from_config(wall)) for name, wall in given.items()}
    return {name: Body(shape, motion=motions[name]) for name, shape in shapes.items()}


def planes(walls: dict[str, Body]) -> tuple[tuple[str, Any], ...]:
    """Return the pairs of ``Scene.walls``, (side, motion) from top to bottom, of walls from ``plane_walls``."""
    return tuple((name, walls[name].motion.x) for name in ("top", "bottom"))


LOADS = ("drag", "lift", "torque")
"""Loads of the fluid on a body: force along x and along y, torque around its centre, per length across the plane."""

VELOCITY = "superficial_velocity"

MOST_FOLLOWED = 6
"""Free bodies that are recorded one by one; of more, which no table or picture can show, only means are recorded."""

SHOWN = 3
"""Most free bodies in the panel of a movie."""

PLACES = ("x", "y", "angle")
MOTIONS = {"x": "length", "y": "length", "angle": "angle", "u": "velocity", "v": "velocity", "angular_velocity": "rate"}
"""Recorded quantities of each free body, and their kinds of unit."""

MEANS = {
    "bodies_mean_u": ("velocity", "mean velocity of bodies", "along x"),
    "bodies_mean_v": ("velocity", "mean velocity of bodies", "along y"),
    "bodies_mean_angular_speed": ("rate", "mean angular speed of bodies", "all bodies"),
}
"""Recorded means over many free bodies: kind of unit, name of the axis, and name in the legend."""

STRESS_ON_WALLS, STRESS_BY_BODIES, STRESS_BY_CONTACTS = (
    "shear_stress_walls",
    "shear_stress_bodies",
    "shear_stress_contacts",
)
STRESS_WORDS = {
    STRESS_ON_WALLS: "on the walls",
    STRESS_BY_BODIES: "by the bodies",
    STRESS_BY_CONTACTS: "part by contacts",
}
"""Names of the mean shear stresses in a legend."""

MOST_RATIOS = 3
"""Most density ratios that are listed one by one."""

KOZENY = 5.0
"""Constant of Kozeny and Carman: permeability = porosity^3 / (5 wetted length per area^2)."""

FRONT = 2.4
"""Depth of the layer in front of a body, in sqrt(nu/a), where the velocity is 99 % of the outer one; a = 2 U/R is the
strain rate there (stagnation flow, K. Hiemenz, Dinglers Polytech. J. 326 (1911) 321-324)."""

CONTACT = 2.0
"""Default distance, in particle spacings, below which bodies repel each other."""

STIFFNESS = 20.0
"""Pressure of contact at half that distance, over the inertial plus the viscous pressure. With 1, bodies in shear come
within 0.4 spacings of each other, where operators have only points on walls as neighbours."""

FEW = 100
"""Points on each wall for the gaps of moving bodies: computed once a line of the history, good to 1e-3."""

TOGETHER = 1e-3
"""Fraction of the reference velocity below which bodies and fluid count as moving together."""


def load_kinds(body: Body) -> tuple[str, ...]:
    """Return the ``LOADS`` that a body has: a straight wall, which is infinitely long, has no torque."""
    return LOADS if body.shape.area else LOADS[:2]


@dataclass(frozen=True, kw_only=True)
class Cell(BodyScene):
    """``bodies`` in a cell of ``size`` (width, height) that is ``periodic`` or has walls, which are bodies, too.

    The first ``count`` bodies are in the fluid, the others are walls around it. ``names``: suffix of each body in names
    of quantities, such as ``_0`` in ``drag_0``. ``contact_distance``: distance below which free bodies repel.
    """

    size: tuple[float, float]
    names: tuple[str, ...]
    count: int
    bodies: tuple[Body, ...] = ()
    periodic: tuple[bool, bool] = (True, True)
    origin: tuple[float, float] = (0.0, 0.0)
    acceleration: float = 0.0
    gravity: tuple[float, float] = (0.0, 0.0)
    contact_distance: float = 0.0
    walls: tuple[tuple[str, WallMotion], ...] = ()
    initial_velocity: Callable | None = None

    without_bodies = "all"
    """Whose height the reference length is without bodies."""

    @classmethod
    def around(cls, config: Any, bodies: Sequence[Body], enclosing: dict[str, Body], **others: Any) -> "Cell":
        """Return the scene of a ``config`` with ``bodies`` in the fluid and the ``enclosing`` walls, by their names."""
        numbers = ("",) if len(bodies) == 1 else tuple(f"_{index}" for index in range(len(bodies)))
        return cls(
            **cls.fluid_of(config),
            size=config.extent,
            names=(*numbers, *(f"_{name}" for name in enclosing)),
            count=len(bodies),
            bodies=(*bodies, *enclosing.values()),
            periodic=config.periodic,
            acceleration=config.drive.acceleration,
            gravity=config.drive.gravity or (0.0, 0.0),
            contact_distance=config.contact.distance if config.contact else CONTACT * config.spacing,
            **others,
        )

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the cell."""
        return self.size

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """See ``Scene.drive_shown``."""
        if any(self.gravity):
            return "gravity", "acceleration", self.gravity
        pulled = next((load for load in map(self._pull, self._free) if any(load)), None)
        return ("force on a body", "force", pulled) if pulled else super().drive_shown

    def _pull(self, index: int) -> tuple[float, float]:
        """Return the force (2,) per length that a free body has, of its own or by its weight; 0 in a driven fluid."""
        motion: Any = self.bodies[index].motion
        return (0.0, 0.0) if self.acceleration and not any(self.gravity) else motion.inertia.load[:2]

    @property
    def solids(self) -> tuple[Body, ...]:
        """All bodies and walls, without open ends."""
        return self.bodies

    @property
    def area(self) -> float:
        """Area of the cell, fluid and bodies."""
        return float(np.prod(self.size))

    @cached_property
    def reference_length(self) -> float:
        """Height of the largest body in its initial orientation; the height of the cell without bodies."""
        heights = [np.ptp(body.shape.extent[:, 1]) for body in self.bodies[: self.count]]
        return float(max(heights, default=self.size[1]))

    @property
    def driven_wall(self) -> float:
        """Speed of the fastest body or wall in the config; for free bodies, the speed before the start."""
        return max(map(largest_speed, self.bodies))

    @cached_property
    def fastest_body(self) -> float:
        """Speed of the fastest body or wall, with estimates for free bodies under a load.

        A force F and a torque T move a free body at U with F = 4 pi mu U and T = 4 pi mu R U in slow flow, but at most
        at the U with F = rho R U^2.
        """
        speeds = [self.driven_wall]
        for body in self.bodies:
            if body.free:
                motion: Any = body.motion
                *force, torque = motion.inertia.load
                radius = farthest(body.shape)
                pull = math.hypot(*force) + abs(torque) / radius
                slow = pull / (4.0 * math.pi * self.dynamic_viscosity)
                speeds.append(min(slow, math.sqrt(pull / (self.density * radius))))
        return max(speeds)

    @cached_property
    def driven_velocity(self) -> float:
        """Estimate of the mean velocity that the acceleration drives, by Kozeny and Carman.

        acceleration/nu * porosity^3 / (5 s^2), s being the wetted length per area; at most the velocity H^2/12
        acceleration/nu of a channel as wide as the smaller side H of the cell, and sqrt(acceleration * H), the bound by
        inertia.
        """
        wetted, smaller = sum(body.shape.length for body in self.bodies) / self.area, min(self.size)
        permeability = min((self.region.area / self.area) ** 3 / (KOZENY * wetted**2), smaller**2 / 12)
        drive = abs(self.acceleration)
        return min(drive * permeability / self.kinematic_viscosity, math.sqrt(drive * smaller))

    @property
    def velocity_scale(self) -> float:
        """The larger of ``fastest_body`` and ``driven_velocity``."""
        known = max(self.fastest_body, self.driven_velocity)
        # nothing is driven, for example a neutrally buoyant body: any speed but 0 serves
        return known or math.sqrt(math.hypot(*self.gravity) * self.reference_length)

    @property
    def peak_velocity(self) -> float:
        """Rough bound of the speed in gaps between bodies."""
        return 2.0 * super().peak_velocity

    @property
    def force_scale(self) -> float:
        """Magnitude of forces per length: the viscous force, or the force that accelerates all fluid."""
        viscous = self.dynamic_viscosity * self.reference_velocity
        return max(viscous, self.density * abs(self.acceleration) * self.region.area)

    @property
    def flow_quantities(self) -> tuple[str, ...]:
        """Loads on bodies that are not free, motions of free bodies, mean shear stresses, and the mean velocity."""
        named = zip(self.names[: self.count], self.bodies[: self.count], strict=True)
        loads = [f"{kind}{name}" for name, body in named if not body.free for kind in LOADS]
        moved = [f"{kind}{name}" for kind, name in self._motion_columns]
        return (*loads, *moved, *self.mean_stress_names, VELOCITY)

    def thinnest_layer(self, t: float) -> tuple[float, str]:
        """See ``Scene.thinnest_layer``: layers at walls that started at t = 0, oscillate, or face the flow."""
        radius = min((body.shape.convex_radius for body in self.bodies if body.shape.area), default=math.inf)
        strain_rate = self.peak_velocity / radius
        front = FRONT * math.sqrt(self.kinematic_viscosity / strain_rate) if strain_rate else math.inf
        layers = [(self.layer_depth(t), "the layer at bodies and walls"), (front, "the layer in front of a body")]
        for body in self.bodies:
            parts: tuple[Any, ...] = (body.motion.x, body.motion.y, body.motion.rotation)
            for part in parts:
                if part.oscillates and part.largest_speed:
                    moved = 0.5 * part.penetration_depth(self.kinematic_viscosity)
                    layers.append((moved, "the layer at the oscillating body"))
        return min(layers)

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields at rest, or with ``initial_velocity``."""
        fields = super().initial(x, y)
        if self.initial_velocity:
            fields |= dict(zip("uv", self.initial_velocity(x, y), strict=True))
        return fields

    @property
    def contact(self) -> tuple[float, float] | None:
        """See ``Scene.contact``."""
        if not self.has_free_bodies:
            return None
        speed = self.reference_velocity
        pressure = self.density * speed * (speed + self.kinematic_viscosity / self.reference_length)
        return self.contact_distance, STIFFNESS * pressure

    def narrowest(self, t: float) -> tuple[tuple[float, str], tuple[float, str]]:
        """See ``Scene.narrowest``; the gaps of free bodies at times after the start need a ``seen`` scene.

        Gaps that change count where they may be too narrow for the spacing.
        """
        known = self.gaps_stay or self.has_free_bodies or t == self.start_time
        enough = resolution.LEAST_GAP * self.spacing
        return self._smallest_radius, self._first_gap if known else self._gap(t, FEW, enough)

    @cached_property
    def _smallest_radius(self) -> tuple[float, str]:
        radii = [body.shape.convex_radius for body in self.bodies]
        index = int(np.argmin(radii))
        return radii[index], f"the smallest radius of {self._named(index)}"

    @cached_property
    def gaps_stay(self) -> bool:
        """Whether all gaps stay as at the start, because no closed body moves."""
        return not any(largest_speed(body) for body in self.bodies if body.shape.area)

    @cached_property
    def _first_gap(self) -> tuple[float, str]:
        return self._gap(self.start_time, POINTS)

    def _gap(self, t: float, points: int, below: float = math.inf) -> tuple[float, str]:
        gap, pair = smallest_gap(self.solids, t, points, below)
        if pair is None:
            return math.inf, ""
        one, other = map(self._named, pair)
        return gap, f"the gap between {one} and {other if one != other else 'its periodic copy'}"

    def _named(self, index: int) -> str:
        name = self.names[index].lstrip("_")
        return f"body {name}".rstrip() if index < self.count else f"wall {name}"

    def description(self) -> dict[str, Any]:
        """Return width and height of the cell, and the number of bodies."""
        return {**super().description(), "bodies": self.count}

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return motions of free bodies, mean stresses, ``loads``, ``velocities`` and ``planar_diagnostics``."""
        found = {**self.free_motions(snapshot), **self.mean_stresses(snapshot), **self.loads(snapshot)}
        return {**found, **self.velocities(snapshot), **planar_diagnostics(self, snapshot)[1]}

    def loads(self, snapshot: Snapshot) -> dict[str, float | None]:
        """Return the ``LOADS`` on each body by name, and the part of the pressure with the suffix ``_pressure``.

        None where the forces are not known.
        """
        found: dict[str, float | None] = {}
        bodies = snapshot.bodies
        for index, (name, body) in enumerate(zip(self.names, self.solids, strict=False)):
            whole: tuple = (None,) * 3
            pressure = whole
            if bodies is not None:
                whole = (*bodies.force[index], bodies.torque[index])
                pressure = (*bodies.pressure_force[index], bodies.pressure_torque[index])
            for part, values in (("", whole), ("_pressure", pressure)):
                found |= {f"{kind}{part}{name}": value for kind, value in zip(load_kinds(body), values, strict=False)}
        return found

    def velocities(self, snapshot: Snapshot) -> dict[str, float]:
        """Return means of the velocity along x: ``superficial_velocity`` over the cell, ``mean_velocity`` of the fluid.

        ``flow_rate``: the superficial velocity times the height of the cell, per length across the plane.
        """
        superficial = cell_mean(self, snapshot)[0]
        seen = self.seen(snapshot).bodies[: self.count]
        solid = sum(body.shape.area * body.motion.x.velocity(snapshot.t) for body in seen)
        return {
            VELOCITY: superficial,
            "mean_velocity": (superficial * self.area - solid) / self.region.area,
            "flow_rate": superficial * self.size[1],
        }

    def open_section(self, t: float) -> float | None:
        """Return the middle of the longest part of the cell along x without bodies at time ``t``; None without one.

        None, too, where the flow rate may vary along x, or the height: without a period, and between walls that are no
        planes.
        """
        if not self.periodic[0] or any(not isinstance(body.shape, Line) for body in self.bodies[self.count :]):
            return None
        bodies, length = self.bodies[: self.count], self.size[0]
        if not bodies:
            return 0.0
        radii = np.array([farthest(body.shape) for body in bodies])
        first = (np.array([body.at(t).centre[0] for body in bodies]) - radii) % length
        order = np.argsort(first)
        first, last = first[order], np.maximum.accumulate((first + 2.0 * radii)[order])
        last = np.maximum(last, last[-1] - length)  # bodies across the end of the cell
        gaps = np.append(first[1:], first[0] + length) - last
        longest = int(np.argmax(gaps))
        return float(last[longest] + 0.5 * gaps[longest]) if gaps[longest] > 0.0 else None

    # Free bodies ------------------------------------------------------------------------------------------------------

    @cached_property
    def _free(self) -> list[int]:
        """Indices of the free bodies."""
        return [index for index, body in enumerate(self.bodies) if body.free]

    @property
    def _means_only(self) -> bool:
        """Whether there are too many free bodies to record them one by one."""
        return len(self._free) > MOST_FOLLOWED

    @property
    def _motion_columns(self) -> list[tuple[str, str]]:
        """Pairs (kind, suffix of the body) of the recorded motions of free bodies; means have no suffix."""
        if self._means_only:
            return [(kind, "") for kind in MEANS]
        return [(kind, self.names[index]) for index in self._free for kind in MOTIONS]

    def free_motions(self, snapshot: Snapshot) -> dict[str, float]:
        """Return the recorded motions of free bodies by name: places [length], not wrapped by periods, angles
        [radians], velocities; or their means.
        """
        chosen = self._free
        if not chosen:
            return {}
        bodies = bodies_in(snapshot)
        values: Any
        if self._means_only:
            mean = bodies.velocity[chosen].mean(axis=0)
            values = [*mean, np.abs(bodies.angular_velocity[chosen]).mean()]
        else:
            parts = bodies.centre, bodies.angle[:, None], bodies.velocity, bodies.angular_velocity[:, None]
            values = np.hstack([part[chosen] for part in parts]).ravel()
        return {f"{kind}{name}": float(value) for (kind, name), value in zip(self._motion_columns, values, strict=True)}

    # Mean shear stress of a suspension --------------------------------------------------------------------------------

    @property
    def mean_stress_names(self) -> tuple[str, ...]:
        """Names of the ``mean_stresses``; none without free bodies, or without walls that shear the fluid.

        The stress by the bodies is not known where the viscosity varies.
        """
        sheared = self.has_free_bodies and any(wall.largest_speed for _, wall in self.walls) and not self.acceleration
        if not sheared:
            return ()
        return (STRESS_ON_WALLS,) if self.rheology and not self.polymer else tuple(STRESS_WORDS)

    def _shear_rate(self, t: float) -> float:
        """Return the mean shear rate between the walls at time ``t``."""
        speed = {side: float(wall.velocity(t)) for side, wall in self.walls}
        return (speed["top"] - speed["bottom"]) / self.size[1]

    def mean_stresses(self, snapshot: Snapshot) -> dict[str, float]:
        """Return the mean shear stresses [stress]: from the forces on the walls, from the bodies, and by contact.

        The balance of momentum times the height y above mid-gap, over the fluid in a cell of area A, gives the mean
        stress on both walls. In the mean over a long time, or in slow flow at any time, it is

            tau = mu G + (sum over bodies of S + S_c + T/2 - y F - M u' v') / A - rho <u' v'>,

        with the rate G = (U_top - U_bottom)/H, and of each body the stresslets S of the fluid's tractions and S_c of
        near contact, the external force F along x and torque T, and the mass M if it is free along x. u' and v' are
        velocities relative to a linear profile; <> is the mean over the fluid times its fraction of the cell. With a
        polymer its mean stress is added. S_c is part of the stress by the bodies, and also returned on its own.

        Source: G. K. Batchelor, J. Fluid Mech. 41 (1970) 545-570, eqs. 3.4 to 3.8, whose forces and couples from
        outside are y F and T here.
        """
        names, (width, height) = self.mean_stress_names, self.size
        if not names:
            return {}
        bodies: Any = bodies_in(snapshot)
        drag = {side: bodies.force[self.names.index(f"_{side}"), 0] for side in ("bottom", "top")}
        found = {STRESS_ON_WALLS: 0.5 * (drag["bottom"] - drag["top"]) / width}
        if STRESS_BY_BODIES in names:
            rate, bottom = self._shear_rate(snapshot.t), float(dict(self.walls)["bottom"].velocity(snapshot.t))
            carried = -self.density * (snapshot.u - (bottom + rate * snapshot.y)) * snapshot.v
            if self.polymer:
                carried = carried + snapshot.stress_xy
            fraction = self.region.area / self.area
            fluid = self.density * self.solvent_viscosity * rate + fraction * float(np.mean(carried, dtype=float))
            total = 0.0
            for index, body in enumerate(self.bodies[: self.count]):
                force = -(bodies.force[index, 0] + bodies.contact_force[index, 0])  # holds a body that is not free
                torque = -(bodies.torque[index] + bodies.contact_torque[index])
                momentum, (y, (u, v)) = 0.0, (bodies.centre[index, 1], bodies.velocity[index])
                if body.free:
                    motion: Any = body.motion
                    inertia = motion.inertia
                    force = force if inertia.held[0] else inertia.load[0]
                    torque = torque if inertia.held[2] else inertia.load[2]
                    if not inertia.held[0]:
                        momentum = inertia.mass[0] * (u - (bottom + rate * y)) * v
                total += bodies.stresslet[index] + bodies.contact_stresslet[index]
                total += 0.5 * torque - (y - 0.5 * height) * force - momentum
            found[STRESS_BY_CONTACTS] = bodies.contact_stresslet[: self.count].sum() / self.area
            found[STRESS_BY_BODIES] = fluid + total / self.area
        return {name: float(found[name]) for name in names}

    # Views ------------------------------------------------------------------------------------------------------------

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
            levels=[drive, *[np.nan] * len(columns)] if alone else (),
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

        With free bodies: the distance of two; of many the relative viscosity in shear, else mean velocities. Of the
        first ``SHOWN`` of few the velocities along their weight or force; in shear the angles of those that are not
        round, one ellipse beside Jeffery's orbit; else the heights.
        """
        if not self.has_free_bodies:
            return self.time_series().only(("drag", "lift"), "force per length", "force")
        if len(self._free) == 2:
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
        """Return the distance between the centres of two free bodies, and their distance in contact if both are round.

        A body that has left a periodic box counts where it comes in again.
        """
        radii = [getattr(self.bodies[index].shape, "radius", math.nan) for index in self._free]

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
            levels=[sum(radii)],
            level_name="in contact",
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
        radius, gap = (size for size, _ in self.narrowest(self.start_time))
        least_radius = f"at least {_clearance.LEAST_RADIUS:g}, a circle {0.5 * _clearance.LEAST_WIDTH:g}"
        least_gap = f"at least {_clearance.LEAST_GAP:g}"
        for name, size, least, enough, more in (
            ("smallest radius", radius, least_radius, resolution.LEAST_RADIUS, ""),
            ("narrowest gap", gap, least_gap, resolution.LEAST_GAP, moves),
        ):
            if np.isfinite(size):
                spacings = f"{size / self.spacing:.3g} spacings ({least}; resolved from {enough:g} on)"
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

    def drift(self, snapshot: Snapshot) -> float:
        """See ``Scene.drift``: the error of the momentum of a box without walls, over its mass.

        The momentum should be the impulse of all loads since the start. A step does not conserve momentum by
        construction, and no other number shows a common drift of fluid and bodies.
        """
        motions: list[Any] = [body.motion for body in self.bodies if body.free]
        inertias = [motion.inertia for motion in motions]
        if len(inertias) < len(self.bodies) or not all(self.periodic) or any(any(each.held[:2]) for each in inertias):
            return 0.0
        fluid = self.density * self.region.area
        mean, bodies = cell_mean(self, snapshot), bodies_in(snapshot).velocity
        mass = np.array([[each.mass[0]] for each in inertias])
        displaced = self.density * np.array([[body.shape.area] for body in self.bodies])
        load = np.sum([each.load[:2] for each in inertias], axis=0) + fluid * np.array([self.acceleration, 0.0])
        given = np.sum(mass * [each.velocity[:2] for each in inertias], axis=0) + load * (snapshot.t - self.start_time)
        off = self.density * self.area * mean + np.sum((mass - displaced) * bodies, axis=0) - given
        apart = max(np.hypot(*(bodies - mean).T).max(), TOGETHER * self.reference_velocity)
        return float(np.hypot(*off) / (fluid + mass.sum()) / apart)
