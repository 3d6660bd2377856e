"""What Taichi compiles for ``comoving_image.py``, where its formulas are."""

from tisph.runtime import ti
from tisph.walls._circles import CircleImages
from tisph.walls._images import ImageWalls


@ti.data_oriented
class Treatment(ImageWalls):
    """Mirror images as their base has them."""


@ti.data_oriented
class BodyTreatment(CircleImages):
    """At the walls of circles."""
