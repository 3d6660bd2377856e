"""Co-moving images: every fluid particle near a wall is mirrored in it (second order on plane walls).

Image of a particle at distance d inside the wall: at distance d beyond it, with the same x, pressure, density and
polymer stress, velocity u_I = 2 u_W - u_F, v_I = -v_F (Bierbrauer, "No-Slip Boundary Conditions in Smoothed
Particle Hydrodynamics", slide 4, third way; d_I = d_F in slide 6's formula). In a circle with the curvature of the
wall: ``_images.py``.
"""

from typing import Literal

from tisph.schemes.wcsph.walls import Treatments, WallParameters


class Parameters(WallParameters):
    """No parameters: the images follow from the fluid."""

    type: Literal["comoving_image"] = "comoving_image"


def treatments() -> Treatments:
    """Return the classes that Taichi compiles."""
    from tisph.schemes.wcsph.walls._images import CircleImages, ImageWalls

    return Treatments(ImageWalls, CircleImages)
