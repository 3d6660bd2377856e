"""Consistent images: mirror images whose velocity obeys the momentum equation at the wall (second order).

From the three-point formula for the second derivative across the wall, with the image at the particle's distance d,

    u_I = 2 u_W - u_F + d^2 u_nn|_W,      v_I = -v_F

where the momentum equation at the wall, whose acceleration is known, gives

    u_nn|_W = (dU/dt - g) / nu                          (Newtonian)
    u_nn|_W = (dU/dt - g - S_xy,y / rho_W) / nu_s       (with polymer stress S, and then S_I = S_F - 2 d S_n|_W)

with the density and the stress of the fluid on the wall from ``_wall_stress.py``.

F. Bierbrauer, "No-Slip Boundary Conditions in Smoothed Particle Hydrodynamics", slides 7 to 23; the slides' formulas
are lost and the formulas here are reconstructed: p_y = 0 and p_x = 0 from rho_y = rho_x = 0 (slides 13 and 21), no
compressible terms v_xy/3 and u_xy/4, since the operators here have the plain Laplacian, and v_nn = -u_xy = 0 by
continuity. With steady walls, no body force and no stress, u_nn = 0: the images are co-moving images, at the same cost.
``schemes/wcsph/_boundaries.py`` treats a wall whose velocity jumps at the start.
"""

from functools import cache
from typing import Any, ClassVar, Literal

from tisph.measures.channel import ChannelFlow
from tisph.schemes.wcsph.walls import Treatments, WallParameters


class Parameters(WallParameters):
    """No parameters: the images follow from the fluid and the momentum equation."""

    obeys_momentum: ClassVar[bool] = True

    type: Literal["consistent_image"] = "consistent_image"


@cache
def treatments() -> Treatments:
    """Return the classes that Taichi compiles."""
    from tisph.runtime import ti
    from tisph.schemes.wcsph._fluid import Fluid
    from tisph.schemes.wcsph.verlet import VerletLists
    from tisph.schemes.wcsph.walls._images import ImageWalls
    from tisph.schemes.wcsph.walls._wall_stress import WallStress

    @ti.data_oriented
    class Treatment(ImageWalls):
        """Mirror images corrected by the second derivative of the velocity at the wall."""

        def __init__(self, lists: VerletLists, kernel: Any, fluid: Fluid, parameters: WallParameters | None):
            super().__init__(lists, kernel, fluid, parameters)
            self.fluid = fluid
            self.tracks_walls = fluid.carries_stress
            self.corrects = self.tracks_walls or self.domain.has_body_force or self.domain.oscillates
            if self.tracks_walls:
                self.track = WallStress(lists, fluid, self.domain.columns)

        def load(self, channel: ChannelFlow) -> None:
            """Set the tracked points on the walls of the ``channel``."""
            if self.tracks_walls:
                self.track.load(channel)

        def parts(self) -> dict[str, Any]:
            """Return the tracked points, which hold fields, by name."""
            return {"track": self.track} if self.tracks_walls else {}

        def lay_out(self, now: int) -> None:
            """Update the images after a sort, and the cells of the tracked points."""
            if self.tracks_walls:
                self.track.locate()
            self.lay_out_images(now)

        @ti.func
        def image_velocity(self, top: ti.template(), position, velocity):
            """Return the velocity of the image of a particle: u_I = 2 U_W - u_F + d^2 u_nn, v_I = -v_F."""
            image = ti.Vector([2.0 * self.domain.wall_velocity(top) - velocity.x, -velocity.y])
            if ti.static(self.corrects):
                distance = self.domain.wall_distance(top, position.y)
                image.x += distance * distance * self.curvature(top, position)
            return image

        @ti.func
        def curvature(self, top: ti.template(), position):
            """Return the second derivative of the velocity across the wall below or above a particle."""
            curvature = self.domain.relative_acceleration(top) / self.fluid.kinematic_viscosity[None]
            if ti.static(self.tracks_walls):
                curvature = self.track.curvature_at(top, position.x)
            return curvature

        @ti.func
        def image_stress(self, top: ti.template(), position, stress):
            """Return the polymer stress of the image, S_I = S_F - 2 d S_n."""
            height = self.domain.wall_distance(top, position.y)
            if ti.static(top):
                height = -height
            return stress - 2.0 * height * self.track.slope_at(top, position.x)

    return Treatments(Treatment)
