"""The base of wall treatments, which by itself stands for no walls, and the base of treatments of bodies' walls."""

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from tisph.config.base import Model
from tisph.geometry.body import Body
from tisph.numerics.domain import ChannelDomain, PeriodicDomain
from tisph.runtime import real, ti, view
from tisph.scenes._channel import Channel
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.verlet import VerletLists


@ti.data_oriented
class WallTreatment:
    """Wall particles around the fluid; a treatment overrides the methods that it needs.

    ``has_dummies``: whether a loop over dummy particles follows the loop over the fluid, with
    ``advance(now, k, elapsed)`` and ``extrapolate(buffer, k)`` of the treatment. ``tracks_walls``: whether a loop over
    the points of ``track`` comes before it. ``uses_mirror_points``: whether the lists of a dummy particle are those
    around its mirror point. ``kernel`` is a module of ``tisph/schemes/wcsph/kernels``.
    """

    has_dummies = False
    tracks_walls = False
    uses_mirror_points = False

    domain: PeriodicDomain | ChannelDomain
    track: Any
    """Points of the walls (``_wall_stress.WallStress``), where ``tracks_walls``."""

    def __init__(self, lists: VerletLists, kernel: Any, fluid: Fluid, parameters: Model | None):
        self.particles = lists.particles
        self.cells = lists.cells
        self.domain = lists.domain
        self.lists = lists

    @staticmethod
    def wall_slots(channel: Channel, cutoff: float) -> tuple[int, int]:
        """Return the number of dummy particles and the room for images, for lists of the radius ``cutoff``."""
        return 0, 0

    def load(self, start: Any) -> None:
        """Place the wall particles at the ``start``: in the channel, or around bodies at that time."""

    def lay_out(self, now: int) -> None:
        """Prepare the wall particles in buffer ``now`` after a sort, before the lists are built."""

    def refresh(self, now: int) -> None:
        """Prepare the wall particles in buffer ``now`` once the lists are built."""

    def present_images(self) -> int:
        """Return the number of images in use."""
        return 0

    def overflow(self) -> int:
        """Return the number of images if there was no room for them, else 0."""
        needed = self.present_images()
        return needed if needed > self.particles.slots - self.particles.first_wall else 0

    def parts(self) -> dict[str, Any]:
        """Return other objects that hold fields, by name, for checkpoints."""
        return {}

    @ti.func
    def publish(self, buffer, i, position, velocity, pressure, stress):
        """Write the mid-step values of fluid particle ``i``, and of its images."""
        self.write(buffer, i, position, velocity, pressure, stress)

    @ti.func
    def write(self, buffer, slot, position, velocity, pressure, stress):
        """Write the mid-step values of one slot; ``stress`` is read only where particles carry it."""
        self.particles.mid_position[buffer, slot] = position
        self.particles.mid_velocity[buffer, slot] = velocity
        self.particles.mid_pressure[buffer, slot] = pressure
        if ti.static(self.particles.carries_stress):
            self.particles.mid_stress[buffer, slot] = stress


class WallParticles(Protocol):
    """Wall particles of bodies before there are fields: how many there are, and how far from the bodies' centres."""

    @property
    def slots(self) -> tuple[int, int]:
        """Number of dummy particles, and room for images."""

    def radius(self, body: int, mirrored: bool) -> float:
        """Return the largest distance from the centre of a body of its dummy particles, 0 without them.

        ``mirrored``: of these and of their mirror points.
        """


@ti.data_oriented
class SolidWalls(WallTreatment):
    """Walls of ``bodies`` in the periodic box around them, whose lowest corner is ``origin`` (2,) [length].

    ``place_bodies(time)`` moves the bodies. ``displacement_factor``: largest displacement of a wall particle over the
    displacement of the fluid particle that it is the image of.
    """

    displacement_factor: float = 1.0

    def __init__(
        self,
        lists: VerletLists,
        kernel: Any,
        fluid: Fluid,
        parameters: Model | None,
        bodies: Sequence[Body],
        origin: np.ndarray,
    ):
        super().__init__(lists, kernel, fluid, parameters)
        self.bodies, self.origin = bodies, origin
        vector = ti.types.vector(2, real())
        # for each body: centre in the box, cosine and sine of its angle, and its motion
        self.centre, self.rotation, self.velocity, self.acceleration = (
            ti.field(vector, shape=len(bodies)) for _ in range(4)
        )
        self.angular_velocity, self.angular_acceleration = (ti.field(real(), shape=len(bodies)) for _ in range(2))

    @staticmethod
    def arrange(bodies: Sequence[Body], spacing: float, cutoff: float) -> WallParticles:
        """Return the wall particles of ``bodies``, a ``spacing`` apart, for lists of the radius ``cutoff``."""
        raise NotImplementedError

    def place_bodies(self, time: float) -> None:
        """Set positions and motions of the bodies at ``time``."""
        for number, body in enumerate(self.bodies):
            place, motion = body.at(time), body.motion
            view(self.centre)[number] = place.centre - self.origin
            view(self.rotation)[number] = math.cos(place.angle), math.sin(place.angle)
            view(self.velocity)[number] = motion.velocity(time)
            view(self.acceleration)[number] = motion.acceleration(time)
            view(self.angular_velocity)[number] = motion.rotation.velocity(time)
            view(self.angular_acceleration)[number] = motion.rotation.acceleration(time)

    @ti.func
    def rotated(self, body, vector):
        """Return a vector of the frame of a body in the frame of the box."""
        rotation = self.rotation[body]
        return ti.Vector([rotation.x * vector.x - rotation.y * vector.y, rotation.y * vector.x + rotation.x * vector.y])

    @ti.func
    def velocity_of(self, body, lever_arm):
        """Return the velocity of the point of a body that is a ``lever_arm`` away from its centre."""
        return self.velocity[body] + self.angular_velocity[body] * ti.Vector([-lever_arm.y, lever_arm.x])

    @ti.func
    def acceleration_of(self, body, lever_arm):
        """Return the acceleration of the point of a body that is a ``lever_arm`` away from its centre."""
        along = self.angular_acceleration[body] * ti.Vector([-lever_arm.y, lever_arm.x])
        return self.acceleration[body] + along - self.angular_velocity[body] ** 2 * lever_arm
