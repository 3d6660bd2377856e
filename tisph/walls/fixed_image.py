"""Fixed images: wall layers, each particle extrapolating linearly from the fluid particle nearest to it.

u_I = u_F + (1 + d_I/d_F) (u_W - u_F): the velocity on the line through the nearest fluid particle F, at distance d_F
from the wall, and the wall W, continued to the image I at distance d_I beyond it (F. Bierbrauer, "No-Slip Boundary
Conditions in Smoothed Particle Hydrodynamics", slides 4 and 6, first way; the linear extrapolation of Takeda et al.
1994 and Morris et al. 1997). The factor has no bound where F comes near the wall; as Morris et al. cap it, d_F is taken
to be at least ``least_distance`` spacings. Pressure and polymer stress are those of F.
"""

from typing import Annotated, Literal

from pydantic import Field

from tisph.walls._parameters import WallParameters


class Parameters(WallParameters):
    """``least_distance``: smallest distance from the wall that the extrapolation uses, in particle spacings."""

    type: Literal["fixed_image"] = "fixed_image"
    least_distance: Annotated[float, Field(gt=0, le=1)] = 0.25
