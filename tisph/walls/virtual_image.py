"""Virtual images: wall layers, each particle reflecting the fluid interpolated at its mirror point.

u_I = u_V + (1 + d_I/d_V) (u_W - u_V) with d_V = d_I: the virtual point V is the mirror point of the fixed image I, in
line with it, so that no error arises where fluid and image are not aligned (F. Bierbrauer, "No-Slip Boundary Conditions
in Smoothed Particle Hydrodynamics", slides 4 and 6, second way). At a curved wall it is the mirror point in the
nearest point of the wall, whose velocity and acceleration a_W count; p_I = p_V + a_W . r_VI per unit density, r_VI from
I to V (a channel leaves a_W, which is along its walls, out). Values at V are first-order consistent: a moving
least-squares fit of c0 + c1 x + c2 y, exact for linear fields, also for disordered particles (the slides say
"interpolation"; an average would sit at the wrong depth next to the wall). Pressure and polymer stress are those at V.
"""

from typing import Literal

from tisph.walls._parameters import WallParameters


class Parameters(WallParameters):
    """No parameters: virtual points mirror the images, which continue the lattice."""

    type: Literal["virtual_image"] = "virtual_image"
