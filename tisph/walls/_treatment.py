"""What every wall treatment has: its surroundings, and steps that most treatments do not need."""

from tisph.runtime import ti


@ti.data_oriented
class WallTreatment:
    """Wall particles around a channel; a treatment replaces the methods that it needs.

    ``gathers`` tells whether a loop over the wall particles follows the one over the fluid.
    """

    gathers = False

    def __init__(self, particles, cells, lists, kernel):
        self.particles = particles
        self.cells = cells
        self.domain = cells.domain
        self.lists = lists

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
        return 0

    @ti.func
    def write(self, buffer, slot, position, velocity, pressure):
        """Write the mid-step values of one slot."""
        self.particles.mid_position[buffer, slot] = position
        self.particles.mid_velocity[buffer, slot] = velocity
        self.particles.mid_pressure[buffer, slot] = pressure
