"""Walls of bodies: where these are and how they move, for treatments of any kind."""

import math

from tisph.runtime import real, ti, view
from tisph.walls._treatment import WallTreatment


@ti.data_oriented
class SolidWalls(WallTreatment):
    """Walls of ``bodies`` in the periodic box around them, whose lowest corner is ``origin``.

    The bodies are where ``place_bodies`` has put them last. A treatment says with ``arrange`` what wall particles
    there are: how many ``slots`` they need, and how far from its centre those of a body go around with it, ``radius``.
    ``displacement_factor``: how much farther they go than the fluid that they are images of.
    """

    displacement_factor = 1.0

    def __init__(self, lists, kernel, fluid, parameters, bodies, origin):
        super().__init__(lists, kernel, fluid, parameters)
        self.bodies, self.origin = bodies, origin
        vector = ti.types.vector(2, real())
        # of each body: centre in the box, cosine and sine of its angle, and its motion
        self.centre, self.rotation, self.velocity, self.acceleration = (
            ti.field(vector, shape=len(bodies)) for _ in range(4)
        )
        self.angular_velocity, self.angular_acceleration = (ti.field(real(), shape=len(bodies)) for _ in range(2))

    def place_bodies(self, time):
        """Put the bodies where they are at ``time``."""
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
        """Return a vector of the frame of a body as seen from outside."""
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
