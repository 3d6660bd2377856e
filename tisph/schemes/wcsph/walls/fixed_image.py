"""Fixed images: wall layers, each particle extrapolating linearly from the fluid particle nearest to it.

u_I = u_F + (1 + d_I/d_F) (u_W - u_F): the velocity on the line through the nearest fluid particle F, at distance d_F
from the wall, and the wall W, continued to the image I at distance d_I beyond it (F. Bierbrauer, "No-Slip Boundary
Conditions in Smoothed Particle Hydrodynamics", slides 4 and 6, first way; the linear extrapolation of Takeda et al.
1994 and Morris et al. 1997). The factor has no bound where F comes near the wall; as Morris et al. cap it, d_F is taken
to be at least ``least_distance`` spacings. The image has the pressure and the polymer stress of F.
"""

from functools import cache
from typing import Annotated, Any, Literal

from pydantic import Field

from tisph.schemes.wcsph.walls import Treatments, WallParameters


class Parameters(WallParameters):
    """``least_distance``: smallest distance from the wall that the extrapolation uses, in particle spacings."""

    type: Literal["fixed_image"] = "fixed_image"
    least_distance: Annotated[float, Field(gt=0, le=1)] = 0.25


@cache
def treatments() -> Treatments:
    """Return the classes that Taichi compiles."""
    from tisph.runtime import scalar, ti
    from tisph.schemes.wcsph._fluid import Fluid
    from tisph.schemes.wcsph.verlet import VerletLists
    from tisph.schemes.wcsph.walls._dummies import DummyWalls

    @ti.data_oriented
    class Treatment(DummyWalls):
        """Linear extrapolation from the nearest fluid particle."""

        def __init__(self, lists: VerletLists, kernel: Any, fluid: Fluid, parameters: Parameters):
            super().__init__(lists, kernel, fluid, parameters)
            self.least_distance = scalar(parameters.least_distance * lists.spacing)

        @ti.func
        def extrapolate(self, buffer, k):
            """Set the values of image ``k``; without fluid in reach, the velocity of the wall."""
            position = self.particles.mid_position[buffer, k]
            found = -1
            shortest = self.lists.radius_squared[None] * 4.0
            for n in range(self.lists.count[k]):
                j = self.lists.table[k, n]
                apart = self.particles.mid_position[buffer, j] - position
                apart.x = self.domain.minimum_image_x(apart.x)
                squared = apart.dot(apart)
                if squared < shortest:
                    shortest = squared
                    found = j
            if found < 0:
                self.give_wall_values(buffer, k)
            else:
                self.continue_through_wall(buffer, k, found)

        @ti.func
        def continue_through_wall(self, buffer, k, j):
            """Extrapolate from fluid particle ``j`` to image ``k``."""
            y = self.particles.mid_position[buffer, k].y
            height = self.particles.mid_position[buffer, j].y
            inside = ti.max(ti.select(y < 0.0, height, self.domain.height[None] - height), self.least_distance[None])
            fluid = self.particles.mid_velocity[buffer, j]
            wall = ti.Vector([self.wall_velocity(y), 0.0])
            velocity = fluid + (1.0 + self.depth(y) / inside) * (wall - fluid)
            if ti.static(self.particles.carries_stress):
                self.set_dummy(
                    buffer, k, velocity, self.particles.mid_pressure[buffer, j], self.particles.mid_stress[buffer, j]
                )
            else:
                self.set_dummy(buffer, k, velocity, self.particles.mid_pressure[buffer, j], 0.0)

    return Treatments(Treatment)
