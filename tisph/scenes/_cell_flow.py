"""The flow in a cell with bodies, its scales and its measures: loads, motions, mean velocities and stresses.

Fluid around the bodies is driven by bodies, walls or an acceleration, in a cell that is periodic or has walls.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from tisph.config.schema import Config
from tisph.config.sections import GAPS
from tisph.geometry.body import POINTS, Body, gaps_below, smallest_gap
from tisph.geometry.motion import WallMotion
from tisph.geometry.outline import EndToEnd
from tisph.measures import resolution
from tisph.measures.fits import cell_mean, section_mean
from tisph.measures.flow import Size
from tisph.scenes._scene import BodyScene, bodies_in, farthest, largest_speed, open_place
from tisph.scenes._views import planar_diagnostics
from tisph.snapshot import Snapshot

_Kind = TypeVar("_Kind", bound="CellFlow")

LOADS = ("drag", "lift", "torque")
"""Loads of the fluid on a body: force along x and along y, torque around its centre, per length across the plane."""

VELOCITY = "superficial_velocity"

MOST_FOLLOWED = 6
"""Free bodies that are recorded one by one; of more, which no table or picture can show, only means are recorded."""

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


def _at_free_bodies(config: Config) -> float:
    """Return the largest particle spacing [length] at the free bodies of a ``config``, or that of gaps between them."""
    gaps = [place.spacing for place in config.discretisation.places if place.near == GAPS]
    if gaps:
        return min(gaps)
    listed = config.bodies if isinstance(config.bodies, tuple) else (config.bodies,)
    return max((body.spacing or config.spacing for body in listed if body.motion == "free"), default=config.spacing)


def load_kinds(body: Body) -> tuple[str, ...]:
    """Return the ``LOADS`` that a body has: a straight wall, which is infinitely long, has no torque."""
    return LOADS if body.shape.area else LOADS[:2]


@dataclass(frozen=True, kw_only=True)
class CellFlow(BodyScene):
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

    @classmethod
    def around(
        cls: type[_Kind], config: Config, bodies: Sequence[Body], enclosing: dict[str, Body], **others: Any
    ) -> _Kind:
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
            contact_distance=config.contact.distance if config.contact else CONTACT * _at_free_bodies(config),
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

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: layers at walls that started at t = 0, oscillate, or face the flow.

        In a flow that is developed at the start without the bodies, layers start at these alone.
        """
        started = max(self.wall_spacings[: self.count], default=0.0) if self.initial_velocity else self.wall_spacing
        layers, peak = [(self.layer_depth(t), "the layer at bodies and walls", started)], self.peak_velocity
        for body, spacing in zip(self.bodies, self.wall_spacings, strict=True):
            strain_rate = peak / body.shape.convex_radius if body.shape.area else 0.0
            if strain_rate:
                front = FRONT * math.sqrt(self.kinematic_viscosity / strain_rate)
                layers.append((front, "the layer in front of a body", spacing))
            parts: tuple[Any, ...] = (body.motion.x, body.motion.y, body.motion.rotation)
            for part in parts:
                if part.oscillates and part.largest_speed:
                    moved = 0.5 * part.penetration_depth(self.kinematic_viscosity)
                    layers.append((moved, "the layer at the oscillating body", spacing))
        return min(layers, key=lambda layer: layer[0] / layer[2])

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

    def narrowest(self, t: float) -> tuple[Size, Size]:
        """See ``Scene.narrowest``; the gaps of free bodies at times after the start need a ``seen`` scene.

        Gaps that change count where they may be too narrow for the spacing.
        """
        known = self.gaps_stay or self.has_free_bodies or t == self.start_time
        enough = resolution.LEAST_GAP * self.spacing
        return self._smallest_radius, self._first_gap if known else self._gap(t, FEW, enough)

    @cached_property
    def _smallest_radius(self) -> Size:
        radii = np.array([body.shape.convex_radius for body in self.bodies])
        spacings = np.array([self.wanted_spacing.along(body) for body in self.bodies])
        index = int(np.argmin(radii / spacings))
        return float(radii[index]), f"the smallest radius of {self._named(index)}", float(spacings[index])

    @cached_property
    def gaps_stay(self) -> bool:
        """Whether all gaps stay as at the start, because no closed body moves."""
        return not any(largest_speed(body) for body in self.bodies if body.shape.area)

    @cached_property
    def _first_gap(self) -> Size:
        return self._gap(self.start_time, POINTS)

    def _gap(self, t: float, points: int, below: float = math.inf) -> Size:
        present = [index for index, body in enumerate(self.solids) if body.enters <= self.start_time]
        bodies = [self.solids[index] for index in present]
        gap, pair = smallest_gap(bodies, t, points, below)
        if pair is None:
            return math.inf, ""
        found, wanted = [(gap, *pair)], self.wanted_spacing
        if wanted.varies:  # a wider gap may have fewer of its own spacings
            found += gaps_below(bodies, resolution.LEAST_GAP * self.spacing, t, points)
        spacings = [wanted.between(bodies[i], bodies[j], t) for _, i, j in found]
        k = int(np.argmin([size / spacing for (size, _, _), spacing in zip(found, spacings, strict=True)]))
        one, other = (self._named(present[index]) for index in found[k][1:])
        name = f"the gap between {one} and {other if one != other else 'its periodic copy'}"
        return found[k][0], name, spacings[k]

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

    @property
    def named_loads(self) -> dict[str, tuple[int, int]]:
        """See ``Scene.named_loads``: loads on closed bodies and walls, unless bodies are free."""
        named = [] if self.has_free_bodies else list(enumerate(zip(self.names, self.solids, strict=False)))
        closed = [(index, name) for index, (name, body) in named if body.shape.area]
        return {f"{kind}{name}": (index, part) for index, name in closed for part, kind in enumerate(LOADS)}

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
        superficial, place = cell_mean(self, snapshot)[0], self.open_section(snapshot.t)
        if place is not None and any(body.slip_length for body in self.bodies[: self.count]):
            superficial = section_mean(self, snapshot, place)  # the velocity jumps at these bodies, within the cell
        seen = self.seen(snapshot).bodies[: self.count]
        solid = sum(body.shape.area * body.motion.x.velocity(snapshot.t) for body in seen)
        return {
            VELOCITY: superficial,
            "mean_velocity": (superficial * self.area - solid) / self.region.area,
            "flow_rate": superficial * self.size[1],
        }

    def open_section(self, t: float) -> float | None:
        """Return the middle of the longest part of the cell along x without bodies at time ``t``; None without one.

        None, too, where the flow rate may vary along x: without a period.
        """
        return open_place(self.bodies[: self.count], self.size[0], t) if self.periodic[0] else None

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
            inside = [index for index in chosen if not np.isnan(bodies.angle[index])]
            mean = bodies.velocity[inside].mean(axis=0) if inside else [math.nan, math.nan]
            values = [*mean, np.abs(bodies.angular_velocity[inside]).mean() if inside else math.nan]
        else:
            parts = bodies.centre, bodies.angle[:, None], bodies.velocity, bodies.angular_velocity[:, None]
            values = np.hstack([part[chosen] for part in parts]).ravel()
        return {f"{kind}{name}": float(value) for (kind, name), value in zip(self._motion_columns, values, strict=True)}

    # Mean shear stress of a suspension --------------------------------------------------------------------------------

    @property
    def mean_stress_names(self) -> tuple[str, ...]:
        """Names of the ``mean_stresses``; none without free bodies, or without plane walls that shear the fluid.

        The stress by the bodies is not known where the viscosity varies.
        """
        sheared = self.has_free_bodies and any(wall.largest_speed for _, wall in self.walls) and not self.acceleration
        if not sheared or any(isinstance(body.shape, EndToEnd) for body in self.bodies):
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
            mean = float(np.mean(snapshot.weight * carried, dtype=float))
            fluid = self.density * self.solvent_viscosity * rate + fraction * mean
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
