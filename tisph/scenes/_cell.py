"""A cell with bodies, periodic or between walls: fluid around them, which they, walls or an acceleration drive."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tisph.bodies import _clearance
from tisph.bodies._clearance import LEAST_GAP, size_problems
from tisph.bodies._clearance import problems as room_problems
from tisph.config.base import Problem
from tisph.geometry.body import POINTS, Body, smallest_gap
from tisph.geometry.region import Region
from tisph.measures import resolution
from tisph.measures.fits import cell_mean
from tisph.scenes import _free_bodies, _suspension_stress, _two_dimensional
from tisph.scenes._body_scene import BodyScene, farthest, largest_speed
from tisph.scenes._initial import still_problem
from tisph.scenes._layers import depth
from tisph.scenes._views import TimeSeries

MOMENTS = 25
"""Times at which it is looked whether bodies that move keep apart."""


def cell_problems(config: Any, bodies: Sequence[Body], walls: dict[str, Body]) -> Iterator[Problem]:
    """What is wrong with the ``config`` of a cell with these ``bodies``, and ``walls`` by what messages call them."""
    if config.scheme.type == "wcsph":
        yield "scheme.type", "wcsph cannot serve bodies yet; take auto or implicit"
    moving = any(largest_speed(body) or body.spin.largest_speed for body in (*bodies, *walls.values()))
    free = [body for body in bodies if body.free]
    pulled = any(any(body.motion.inertia.load) for body in free) or (free and config.drive.gravity)
    if not moving and not pulled and not config.drive.acceleration:
        remedy = "give an acceleration, or let a body or a wall move"
        yield from still_problem(config, "drive.acceleration", remedy)
    if config.drive.gravity and not free:
        yield "drive.gravity", "moves free bodies alone: give one the motion free, or leave it out"
    given = config.bodies
    listed = isinstance(given, tuple)
    shapes = [(f"bodies.{index}", given[index] if listed else given, body) for index, body in enumerate(bodies)]
    shapes += [(key, config.walls.around, wall) for key, wall in walls.items() if wall.shape.area]
    found = [*size_problems(shapes, config.spacing, config.across)]
    found += room_problems(bodies, walls, config.spacing, _times(config, bodies))
    yield from found if listed else dict.fromkeys(_in_common(problem, config) for problem in found)


def _in_common(problem: Problem, config: Any) -> Problem:
    """A problem of one body of a suspension by the key that all have; where some come too close, by the cause."""
    key, text, *_ = problem
    if not key.startswith("bodies."):
        return key, text
    _, number, name = key.split(".")
    if name != "centre":
        return f"bodies.{name}", text
    close = config.bodies.least_gap < LEAST_GAP * config.spacing
    return "bodies.least_gap" if close else "bodies.motion", f"body {number} {text}"


def _times(config: Any, bodies: Sequence[Body]) -> Sequence[float]:
    """Times at which bodies are looked at: the first alone where none of them goes anywhere, or where is not known."""
    if any(body.free for body in bodies) or not any(largest_speed(body) for body in bodies):
        return (0.0,)
    return np.linspace(0.0, config.time.end, MOMENTS).tolist()


def bodies_of(config: Any, walls: dict[str, Body], origin: tuple[float, float] = (0.0, 0.0)) -> list[Body]:
    """The bodies in the fluid between these ``walls``, in a cell whose lowest corner is ``origin``.

    Its periods are infinite where there are walls. ValidationError where a suspension does not fit.
    """
    sizes = zip(config.extent, config.periodic, strict=True)
    periods = tuple(size if periodic else math.inf for size, periodic in sizes)
    given = config.bodies
    if not isinstance(given, tuple):
        high = (origin[0] + config.extent[0], origin[1] + config.extent[1])
        given = given.bodies(Region(tuple(walls.values()), origin, high, config.periodic))
    return [body.body(periods, surroundings(config)) for body in given]


@dataclass(frozen=True)
class Surroundings:
    """What moves free bodies: ``density`` of the fluid, its ``acceleration`` along x, and ``gravity`` (2,)."""

    density: float
    acceleration: float
    gravity: tuple[float, float]


def surroundings(config: Any) -> Surroundings:
    """Those of a ``config``."""
    return Surroundings(config.fluid.density, config.drive.acceleration, config.drive.gravity or (0.0, 0.0))


LOADS = ("drag", "lift", "torque")
"""Of the fluid on a body: force along x and along y, torque around its centre, per length across the plane."""


def kinds(body):
    """Those of ``LOADS`` that a body has: a straight wall, which goes on for ever, has no torque."""
    return LOADS if body.shape.area else LOADS[:2]


def _loads(bodies, index):
    """Return all loads of a body, and those of the pressure."""
    if bodies is None:
        return (None,) * 3, (None,) * 3
    pressure = (*bodies.pressure_force[index], bodies.pressure_torque[index])
    return (*bodies.force[index], bodies.torque[index]), pressure


VELOCITY = "superficial_velocity"
MOST_RATIOS = 3
"""Ratios of densities that are named one by one."""

SERIES_UNITS = {"drag": "force", "lift": "force", "torque": "torque"} | _free_bodies.UNITS


KOZENY = 5.0
"""Constant of Kozeny and Carman: permeability = porosity^3 / (5 wetted length per area^2)."""

FRONT = 2.4
"""Depth of the layer in front of a body, in sqrt(nu/a), a = 2 U/R being the strain rate there: the velocity is 99 % of
that outside (stagnation flow, K. Hiemenz, Dinglers Polytech. J. 326 (1911) 321-324)."""

CONTACT = 2.0
"""Distance, in particle spacings, from which on bodies push each other off, if a config does not give another."""

STIFFNESS = 20.0
"""Pressure of contact at half that distance, over those of inertia and viscosity. With 1 bodies in shear come within
0.4 spacings, where operators have no more than points on walls to go by."""

FEW = 100
"""Points on each wall from which gaps are taken as bodies move: once a line of the history, good to 1e-3."""


TOGETHER = 1e-3
"""Part of the reference velocity below which bodies and fluid count as moving together."""


@dataclass(frozen=True, kw_only=True)
class Cell(BodyScene):
    """``bodies`` in a cell of ``size`` (width, height) that is ``periodic`` or has walls, which are bodies, too.

    ``names`` are those of the bodies as they are put after those of their numbers, such as ``_0`` in ``drag_0``. The
    first ``count`` are in the fluid, the others around it. ``planes``: pairs as in ``Scene.walls``. ``start``: function
    of x, y with the velocities (2, ...) of the fluid before the start, None where it is at rest.
    """

    size: tuple[float, float]
    names: tuple[str, ...]
    count: int
    bodies: tuple = ()
    periodic: tuple[bool, bool] = (True, True)
    origin: tuple[float, float] = (0.0, 0.0)
    acceleration: float = 0.0
    gravity: tuple[float, float] = (0.0, 0.0)
    contact_distance: float = 0.0
    planes: tuple = ()
    start: object = None

    @classmethod
    def around(cls, config, bodies, walls, **others):
        """The scene of a ``config`` with these ``bodies`` in the fluid, and ``walls`` by their names."""
        numbers = ("",) if len(bodies) == 1 else tuple(f"_{index}" for index in range(len(bodies)))
        return cls(
            **cls.fluid_of(config),
            size=config.extent,
            names=(*numbers, *(f"_{name}" for name in walls)),
            count=len(bodies),
            bodies=(*bodies, *walls.values()),
            periodic=config.periodic,
            acceleration=config.drive.acceleration,
            gravity=config.drive.gravity or (0.0, 0.0),
            contact_distance=config.contact.distance if config.contact else CONTACT * config.spacing,
            **others,
        )

    @property
    def extent(self):
        """Width and height of the cell."""
        return self.size

    @property
    def walls(self):
        """The plane walls."""
        return self.planes

    @cached_property
    def reference_length(self):
        """Height of the largest body, as it stands at first; that of the cell without bodies."""
        heights = [np.ptp(body.shape.extent[:, 1]) for body in self.bodies[: self.count]]
        return float(max(heights, default=self.size[1]))

    @cached_property
    def fastest_body(self):
        """Speed of the fastest body or wall, roughly of those that a load moves."""
        return max(self.driven_wall, max(map(self._pulled_speed, self.bodies)))

    @property
    def driven_wall(self):
        """Speed of the fastest body or wall, as the config gives it: of free bodies before the start."""
        return max(map(largest_speed, self.bodies))

    def _pulled_speed(self, body):
        """Rough speed to which its load brings a free ``body``.

        In slow flow F = 4 pi mu U and T = 4 pi mu R U, at most that at which F = rho R U^2.
        """
        if not body.free:
            return 0.0
        *force, torque = body.motion.inertia.load
        radius = farthest(body.shape)
        pull = math.hypot(*force) + abs(torque) / radius
        slow = pull / (4.0 * math.pi * self.dynamic_viscosity)
        return min(slow, math.sqrt(pull / (self.density * radius)))

    @cached_property
    def driven_velocity(self):
        """Rough mean velocity by the acceleration: that of Kozeny and Carman, or less.

        acceleration/nu * porosity^3 / (5 s^2), s being the wetted length per area; at most that of a channel as wide as
        the smaller side of the cell, H^2/12, and sqrt(acceleration * H), which inertia allows.
        """
        area = float(np.prod(self.size))
        wetted, smaller = sum(body.shape.length for body in self.bodies) / area, min(self.size)
        permeability = min((self.region.area / area) ** 3 / (KOZENY * wetted**2), smaller**2 / 12)
        drive = abs(self.acceleration)
        return min(drive * permeability / self.kinematic_viscosity, math.sqrt(drive * smaller))

    @property
    def velocity_scale(self):
        """The larger of ``fastest_body`` and ``driven_velocity``."""
        known = max(self.fastest_body, self.driven_velocity)
        # where nothing is driven, as a body that is as heavy as the fluid: any speed serves, 0 does not
        return known or math.sqrt(math.hypot(*self.gravity) * self.reference_length)

    @property
    def peak_velocity(self):
        """What may become of it in gaps, roughly."""
        return 2.0 * super().peak_velocity

    @property
    def force_scale(self):
        """Size of forces per length: viscous ones, and the acceleration of all fluid."""
        viscous = self.dynamic_viscosity * self.reference_velocity
        return max(viscous, self.density * abs(self.acceleration) * self.region.area)

    @property
    def flow_quantities(self):
        """Forces on bodies that the flow does not carry, places and velocities of those that it does; mean velocity.

        And the mean shear stress between walls that shear free bodies.
        """
        named = zip(self.names[: self.count], self.bodies[: self.count], strict=True)
        loads = [f"{kind}{name}" for name, body in named if not body.free for kind in LOADS]
        moved = [f"{kind}{name}" for kind, name in _free_bodies.columns(self)]
        return (*loads, *moved, *_suspension_stress.columns(self), "superficial_velocity")

    def thinnest_layer(self, t):
        """Depth of the layer at walls that started at t = 0, or oscillate, or that flow comes upon; and where it is."""
        strain_rate = self.peak_velocity / self._smallest_radius[0]
        front = FRONT * math.sqrt(self.kinematic_viscosity / strain_rate) if strain_rate else math.inf
        layers = [(depth(self, t), "the layer at bodies and walls")]
        layers.append((front, "the layer in front of a body"))
        for body in self.bodies:
            for part in (body.motion.x, body.motion.y, body.motion.rotation):
                if part.oscillates and part.largest_speed:
                    moved = 0.5 * part.penetration_depth(self.kinematic_viscosity)
                    layers.append((moved, "the layer at what oscillates"))
        return min(layers)

    def initial(self, x, y):
        """As of ``BodyScene``, or the flow of ``start``."""
        fields = super().initial(x, y)
        return fields | dict(zip("uv", self.start(x, y), strict=True)) if self.start else fields

    @property
    def contact(self):
        """See ``Scene.contact``."""
        if not self.has_free_bodies:
            return None
        speed = self.reference_velocity
        pressure = self.density * speed * (speed + self.kinematic_viscosity / self.reference_length)
        return self.contact_distance, STIFFNESS * pressure

    @property
    def initial_velocity(self):
        """``start``."""
        return self.start

    def narrowest(self, t):
        """See ``Scene.narrowest``; where free bodies go only a scene that was ``seen`` knows."""
        known = self.gaps_stay or self.has_free_bodies
        return self._smallest_radius, self._first_gap if known else self._gap(t, FEW)

    @cached_property
    def _smallest_radius(self):
        radii = [body.shape.convex_radius for body in self.bodies]
        index = int(np.argmin(radii))
        return radii[index], f"the smallest radius of {self._named(index)}"

    @cached_property
    def gaps_stay(self):
        """Whether no body moves that has an inside, so that gaps are those of the start."""
        return not any(largest_speed(body) for body in self.bodies if body.shape.area)

    @cached_property
    def _first_gap(self):
        return self._gap(self.start_time, POINTS)

    def _gap(self, t, points):
        gap, pair = smallest_gap(self.bodies, t, points)
        if pair is None:
            return math.inf, ""
        one, other = map(self._named, pair)
        return gap, f"the gap between {one} and {other if one != other else 'its periodic copy'}"

    def _named(self, index):
        name = self.names[index].lstrip("_")
        return f"body {name}".rstrip() if index < self.count else f"wall {name}"

    def description(self):
        """Width and height of the cell, number of bodies."""
        return {**super().description(), "bodies": self.count}

    def diagnostics(self, snapshot, series):
        """Numbers of a snapshot: of free bodies, ``loads``, ``velocities`` and ``_two_dimensional.diagnostics``."""
        found = {**self.of_free_bodies(snapshot), **self.loads(snapshot), **self.velocities(snapshot)}
        return {**found, **_two_dimensional.diagnostics(self, snapshot)[1]}

    def of_free_bodies(self, snapshot):
        """Where they are and how they move, and the mean shear stress between walls that shear them."""
        return _free_bodies.states(self, snapshot) | _suspension_stress.stresses(self, snapshot)

    def loads(self, snapshot):
        """``LOADS`` of each body and, with ``_pressure`` after them, the part of the pressure; None without forces."""
        found = {}
        for index, (name, body) in enumerate(zip(self.names, self.bodies, strict=True)):
            for part, values in zip(("", "_pressure"), _loads(snapshot.bodies, index), strict=True):
                found |= {f"{kind}{part}{name}": value for kind, value in zip(kinds(body), values, strict=False)}
        return found

    def velocities(self, snapshot):
        """Mean velocities along x: ``superficial_velocity`` over cell and bodies, ``mean_velocity`` of the fluid.

        ``flow_rate``: the superficial velocity times the height of the cell, per length across the plane.
        """
        superficial = cell_mean(self, snapshot)[0]
        seen = self.seen(snapshot).bodies[: self.count]
        solid = sum(body.shape.area * body.motion.x.velocity(snapshot.t) for body in seen)
        area = float(np.prod(self.size))
        return {
            "superficial_velocity": superficial,
            "mean_velocity": (superficial * area - solid) / self.region.area,
            "flow_rate": superficial * self.size[1],
        }

    def profiles(self):
        """Both components of the velocity along the vertical centre line."""
        return [_two_dimensional.velocity_profile(self, field, "y") for field in "uv"]

    def time_series(self):
        """Forces and torques on the bodies in the fluid, or on its walls where there are none, and the mean velocity.

        Of bodies that the flow carries, if there are few, also places and velocities, of many means of these alone; and
        the mean shear stress between walls that shear them.
        """
        forces = self._followed_forces()
        stresses = _suspension_stress.columns(self)
        followed = [*forces, *_free_bodies.columns(self), *((name, "") for name in stresses)]
        columns = [f"{kind}{name}" for kind, name in followed]
        force, speed, free = self.force_scale, self.reference_velocity, self.has_free_bodies
        sizes = {"drag": force, "lift": force, "torque": force * self.reference_length} | _free_bodies.sizes(self)
        sizes |= dict.fromkeys(stresses, _suspension_stress.size(self))
        panels = (
            _free_bodies.panels(self)
            if free
            else {kind: (f"{kind} per length", SERIES_UNITS[kind]) for kind, _ in forces}
        )
        panels |= dict.fromkeys(stresses, ("mean shear stress", "stress"))
        # it carries all that drives the fluid
        alone = len(self.bodies) == self.count == 1 and not free and not self.fastest_body
        drive = self.density * self.acceleration * self.region.area

        def measure(snapshot):
            found = self.loads(snapshot) | self.of_free_bodies(snapshot)
            values = [np.nan if found[column] is None else found[column] for column in columns]
            return np.array([*values, self.velocities(snapshot)[VELOCITY]])

        return TimeSeries(
            content=f"{'places and velocities of bodies, ' if free else ''}forces and torques of the fluid on bodies, "
            "and the mean velocity, over time t",
            name="force per length",
            unit="force",
            scale=force,
            columns=[*columns, VELOCITY],
            labels=[*((self._called(*each), None) for each in followed), ("mean over the cell", None)],
            measure=measure,
            sizes=[*(sizes[kind] for kind, _ in followed), speed],
            levels=[drive, *[np.nan] * len(columns)] if alone else (),
            panels=[*(panels.get(kind) for kind, _ in followed), ("superficial velocity", "velocity")],
            drifting=[f"{kind}{name}" for kind, name in followed if kind in _free_bodies.PLACES],
        )

    def _followed_forces(self):
        """Pairs of a kind of force and the name of the body, or wall, that it is on."""
        chosen, many = slice(self.count or None), _free_bodies.are_many(self)
        pairs = zip(self.names[chosen], self.bodies[chosen], strict=True)
        return [(kind, name) for name, body in pairs if not (many and body.free) for kind in kinds(body)]

    def _called(self, kind, name):
        """What the legend calls a number."""
        if kind in _suspension_stress.WORDS:
            return _suspension_stress.WORDS[kind]
        if self.count:
            return _free_bodies.words(kind, name)
        return f"wall {name.lstrip('_')}"

    def movie_series(self):
        """Forces on the bodies, or on the walls where there are none; of bodies that the flow carries their motion."""
        if self.has_free_bodies:
            return _free_bodies.movie_series(self)
        return self.time_series().only(("drag", "lift"), "force per length", "force")

    def parameters(self):
        """Pairs (label, text) of what the flow is, independent of particles."""
        length, time = self.units.length, self.units.time
        width, height = self.size
        known, cause = self._cause()
        about, digits = ("", 6) if known else ("about ", 2)
        lines = [
            ("Reynolds number", f"{about}{self.reynolds:.{digits}g}  (U d / nu)"),
            ("speed U", f"{about}{self.reference_velocity:.{digits}g} {length}/{time}, {cause}"),
            (
                "length d",
                f"{self.reference_length:.6g} {length}, the height of {'the largest body' if self.count else 'all'}",
            ),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("cell", f"{width:.6g} x {height:.6g} {length}, {self.region.area / (width * height):.4g} of it fluid"),
        ]
        lines += [*self._free(), *self._narrowest()]
        if self.acceleration:
            lines.append(("drive", f"{self.acceleration:.6g} {length}/{time}^2 along x"))
        return lines

    def _cause(self):
        """Whether the reference velocity is known, and in words what has it."""
        if self.given_velocity:
            return True, "given by the config"
        if not (self.fastest_body or self.driven_velocity):
            return False, "a guess: nothing has a speed that is known"
        if self.driven_velocity >= self.fastest_body:
            return False, "an estimate: the mean velocity that the acceleration causes in a Newtonian fluid"
        if self.driven_wall >= self.fastest_body:
            return True, "of the fastest body or wall"
        return False, "an estimate: of a free body under its load, in slow flow or against inertia"

    def _free(self):
        """How many bodies the flow carries, and how heavy they are."""
        chosen = [self.bodies[index] for index in _free_bodies.numbers(self)]
        if chosen:
            ratios = [body.motion.inertia.mass[0] / (self.density * body.shape.area) for body in chosen]
            found = sorted({f"{ratio:.6g}" for ratio in ratios}, key=float)
            shown = found if len(found) <= MOST_RATIOS else [f"{found[0]} to {found[-1]}"]
            text = f"{len(chosen)} of {self.count}, of {', '.join(shown)} times the density of the fluid"
            yield "free bodies", text

    def _narrowest(self):
        """Smallest radius and gap of bodies and walls at the start, in particle spacings, and the least allowed."""
        changes = "will change" if self.has_free_bodies else "may change"
        moves = "" if self.gaps_stay and not self.has_free_bodies else f" at the start; gaps {changes} as bodies move"
        radius, gap = (size for size, _ in self.narrowest(self.start_time))
        least = f"at least {_clearance.LEAST_RADIUS:g}, a circle {0.5 * _clearance.LEAST_WIDTH:g}"
        found = [("smallest radius", radius, least, resolution.LEAST_RADIUS, "")]
        found += [("narrowest gap", gap, f"at least {_clearance.LEAST_GAP:g}", resolution.LEAST_GAP, moves)]
        for name, size, least, enough, more in found:
            if np.isfinite(size):
                spacings = f"{size / self.spacing:.3g} spacings ({least}; resolved from {enough:g} on)"
                yield name, f"{size:.4g} {self.units.length}, {spacings}{more}"

    def drift(self, snapshot):
        """See ``Scene.drift``: what the momentum of a box without walls is off the impulse of all loads, over its mass.

        A step does not conserve it by its construction, and nothing else tells how fast all moves together.
        """
        inertias = [body.motion.inertia for body in self.bodies if body.free]
        if len(inertias) < len(self.bodies) or not all(self.periodic) or any(any(each.held[:2]) for each in inertias):
            return 0.0
        area, fluid = float(np.prod(self.size)), self.density * self.region.area
        mean, bodies = cell_mean(self, snapshot), snapshot.bodies.velocity
        mass = np.array([[each.mass[0]] for each in inertias])
        displaced = self.density * np.array([[body.shape.area] for body in self.bodies])
        impulse = np.sum([each.load[:2] for each in inertias], axis=0) + fluid * np.array([self.acceleration, 0.0])
        given = np.sum(mass * [each.velocity[:2] for each in inertias], axis=0) + impulse * (
            snapshot.t - self.start_time
        )
        off = self.density * area * mean + np.sum((mass - displaced) * bodies, axis=0) - given
        apart = max(np.hypot(*(bodies - mean).T).max(), TOGETHER * self.reference_velocity)
        return float(np.hypot(*off) / (fluid + mass.sum()) / apart)
