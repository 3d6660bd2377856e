"""What every wall treatment has: its surroundings, and steps that most treatments do not need; alone, no walls."""

from tisph.runtime import ti


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
