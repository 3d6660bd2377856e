"""The base of wall treatments, which alone stands for no walls, and the base of treatments of bodies' walls."""

import math

from tisph.runtime import real, ti, view


@ti.data_oriented
class WallTreatment:
    """Wall particles around the fluid; a treatment replaces the methods that it needs.

    ``has_dummies`` tells whether a loop over the wall particles follows the one over the fluid, ``tracks_walls``
    whether one over points of the walls comes before it. ``uses_mirror_points``: the lists of wall particles are
    those of their mirror points. ``fluid`` is the ``Fluid``, ``parameters`` the treatment's own from the config.
    """

    has_dummies = False
    tracks_walls = False
    uses_mirror_points = False

    def __init__(self, lists, kernel, fluid, parameters):
        self.particles = lists.particles
        self.cells = lists.cells
        self.domain = lists.domain
        self.lists = lists

    @staticmethod
    def wall_slots(channel, cutoff):
        """Return (dummy particles, room for images)."""
        return 0, 0

    def load(self, channel):
        """Place wall particles of their own at the start."""

    def lay_out(self, now):
        """Prepare the wall particles after a sort, before the lists are built."""

    def refresh(self, now):
        """Prepare the wall particles once the lists are built."""

    def present_images(self):
        """Return the number of images in use."""
        return 0

    def overflow(self):
        """Return the number of images if there was no room for them, else 0."""
        needed = self.present_images()
        return needed if needed > self.particles.slots - self.particles.first_wall else 0

    def parts(self):
        """Return what else holds fields, by name, for checkpoints."""
        return {}

    @ti.func
    def publish(self, buffer, i, position, velocity, pressure, stress):
        """Write the mid-step values of fluid particle ``i``, and of what follows from them."""
        self.write(buffer, i, position, velocity, pressure, stress)

    @ti.func
    def write(self, buffer, slot, position, velocity, pressure, stress):
        """Write the mid-step values of one slot; ``stress`` is read only where particles carry it."""
        self.particles.mid_position[buffer, slot] = position
        self.particles.mid_velocity[buffer, slot] = velocity
        self.particles.mid_pressure[buffer, slot] = pressure
        if ti.static(self.particles.carries_stress):
            self.particles.mid_stress[buffer, slot] = stress


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
