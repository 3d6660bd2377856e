"""A cell with bodies in it: fluid around them, at rest at first, driven by them, by walls or by an acceleration."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry.body import POINTS, smallest_gap
from tisph.scenes._body_scene import BodyScene, farthest, largest_speed
from tisph.scenes._cell import diagnostics, free_bodies, shear_stress, views
from tisph.scenes._layers import depth

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
        loads = [f"{kind}{name}" for name, body in named if not body.free for kind in diagnostics.LOADS]
        moved = [f"{kind}{name}" for kind, name in free_bodies.columns(self)]
        return (*loads, *moved, *shear_stress.columns(self), "superficial_velocity")

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

    diagnostics = diagnostics.diagnostics
    drift = free_bodies.drift
    parameters = views.parameters
    profiles = views.profiles
    movie_series = views.movie_series
    time_series = views.time_series
