"""Slip images: walls along which the fluid slips without friction, u_I = u_F and v_I = -v_F."""

from functools import cache
from typing import Literal

from tisph.schemes.wcsph.walls import Treatments, WallParameters


class Parameters(WallParameters):
    """No parameters: the images follow from the fluid."""

    type: Literal["slip_image"] = "slip_image"


@cache
def treatments() -> Treatments:
    """Return the class that Taichi compiles."""
    from tisph.runtime import ti
    from tisph.schemes.wcsph.walls._images import ImageWalls

    @ti.data_oriented
    class SlipImages(ImageWalls):
        """Mirror images that keep the velocity along the wall."""

        @ti.func
        def image_velocity(self, top: ti.template(), position, velocity):
            """Return the velocity of the image: tangential part kept, normal part reflected."""
            return ti.Vector([velocity.x, -velocity.y])

        @ti.func
        def image_stress(self, top: ti.template(), position, stress):
            """Return the polymer stress of the image: the sign of its shear part changed."""
            return ti.Vector([stress[0], -stress[1], stress[2]])

    return Treatments(SlipImages)
