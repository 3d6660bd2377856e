"""Consistent images: mirror images whose velocity obeys the momentum equation at the wall (second order).

From the three-point formula for the second derivative across the wall, with the image at the particle's distance d,

    u_I = 2 u_W - u_F + d^2 u_nn|_W,      v_I = -v_F

where the momentum equation at the wall, whose acceleration is known, gives

    u_nn|_W = (dU/dt - g) / nu                          (Newtonian)
    u_nn|_W = (dU/dt - g - S_xy,y / rho_W) / nu_s       (with polymer stress S, and then S_I = S_F - 2 d S_n|_W)

with the density and the stress of the fluid on the wall from ``walls/_consistent_image.py``.

F. Bierbrauer, "No-Slip Boundary Conditions in Smoothed Particle Hydrodynamics", slides 7 to 23; the slides' formulas
are lost and these are reconstructed: p_y = 0 and p_x = 0 from rho_y = rho_x = 0 (slides 13 and 21), no compressible
terms v_xy/3 and u_xy/4, since the operators here have the plain Laplacian, and v_nn = -u_xy = 0 by continuity. Where a
wall is steady, nothing drives the fluid and it carries no stress, u_nn = 0: these are the co-moving images, at their
cost. A wall whose velocity jumps at the start accelerates infinitely for no time: ``schemes/wcsph/_boundaries.py``.
"""

from typing import ClassVar, Literal

from tisph.walls._parameters import WallParameters


class Parameters(WallParameters):
    """No parameters: the images follow from the fluid and the momentum equation."""

    obeys_momentum: ClassVar[bool] = True

    type: Literal["consistent_image"] = "consistent_image"
