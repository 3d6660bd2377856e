"""Co-moving images: every fluid particle near a wall is mirrored in it (second order on plane walls).

Image of a particle at distance d inside the wall: at distance d beyond it, with the same x, pressure and
density, velocity u_I = 2 u_W - u_F, v_I = -v_F (Bierbrauer, "No-Slip Boundary Conditions in Smoothed
Particle Hydrodynamics", slide 4, third way; d_I = d_F in slide 6's formula).
"""

from typing import Literal

from tisph.config.base import Model
from tisph.runtime import ti
from tisph.walls._images import ImageWalls


class Parameters(Model):
    """No parameters: the images follow from the fluid."""

    type: Literal["comoving_image"] = "comoving_image"


@ti.data_oriented
class Treatment(ImageWalls):
    """Mirror images with the velocity reflected about that of the wall."""

    @ti.func
    def image_velocity(self, velocity, wall_velocity):
        """Return the velocity of the image of a particle with ``velocity``."""
        return ti.Vector([2.0 * wall_velocity - velocity.x, -velocity.y])
