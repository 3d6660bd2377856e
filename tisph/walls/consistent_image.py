"""Consistent images: mirror images whose velocity obeys the momentum equation at the wall (second order).

From the three-point formula for the second derivative across the wall, with the image at the particle's distance d,

    u_I = 2 u_W - u_F + d^2 u_nn|_W,      v_I = -v_F

where the momentum equation at the wall, whose acceleration is known, gives

    u_nn|_W = (dU/dt - g) / nu                          (Newtonian)
    u_nn|_W = (dU/dt - g - S_xy,y / rho_W) / nu_s       (with polymer stress S, and then S_I = S_F - 2 d S_n|_W)

with the density and the stress of the liquid on the wall from ``walls/_track.py``.

F. Bierbrauer, "No-Slip Boundary Conditions in Smoothed Particle Hydrodynamics", slides 7 to 23; the slides' formulas
are lost and these are reconstructed: p_y = 0 and p_x = 0 from rho_y = rho_x = 0 (slides 13 and 21), no compressible
terms v_xy/3 and u_xy/4, since the operators here have the plain Laplacian, and v_nn = -u_xy = 0 by continuity. Where a
wall is steady, nothing drives the liquid and it carries no stress, u_nn = 0: these are the co-moving images, at their
cost. A wall whose velocity jumps at the start accelerates infinitely for no time: ``schemes/wcsph/_impulse.py``.
"""

from typing import Literal

from tisph.config.base import Model
from tisph.runtime import ti
from tisph.walls._images import ImageWalls
from tisph.walls._track import WallTrack


class Parameters(Model):
    """No parameters: the images follow from the fluid and the momentum equation."""

    type: Literal["consistent_image"] = "consistent_image"


@ti.data_oriented
class Treatment(ImageWalls):
    """Mirror images corrected by the curvature that the velocity has at the wall."""

    obeys_momentum = True

    def __init__(self, lists, kernel, liquid, parameters):
        super().__init__(lists, kernel, liquid, parameters)
        self.liquid = liquid
        self.tracks_walls = liquid.carries_stress
        self.corrects = self.tracks_walls or self.domain.driven or self.domain.oscillates
        if self.tracks_walls:
            self.track = WallTrack(lists, liquid, self.domain.columns)

    def load(self, channel):
        """Place the tracked points on the walls."""
        if self.tracks_walls:
            self.track.load(channel)

    def parts(self):
        """Return what else holds fields, by name."""
        return {"track": self.track} if self.tracks_walls else {}

    def lay_out(self, now):
        """Lay out the images after a sort, and see to it that tracked points find their particles."""
        if self.tracks_walls:
            self.track.locate()
        self.lay_out_images(now)

    @ti.func
    def image_velocity(self, top: ti.template(), position, velocity):
        """Return the velocity of the image of a particle: reflected about that of the wall, on a curved profile."""
        image = ti.Vector([2.0 * self.domain.wall_velocity(top) - velocity.x, -velocity.y])
        if ti.static(self.corrects):
            distance = self.domain.inside(top, position.y)
            image.x += distance * distance * self.curvature(top, position)
        return image

    @ti.func
    def curvature(self, top: ti.template(), position):
        """Return the second derivative of the velocity across the wall below or above a particle."""
        curvature = self.domain.relative_acceleration(top) / self.liquid.kinematic_viscosity[None]
        if ti.static(self.tracks_walls):
            curvature = self.track.curvature_at(top, position.x)
        return curvature

    @ti.func
    def image_stress(self, top: ti.template(), position, stress):
        """Return the polymer stress of the image: continued with its slope at the wall."""
        height = self.domain.inside(top, position.y)
        if ti.static(top):
            height = -height
        return stress - 2.0 * height * self.track.slope_at(top, position.x)
