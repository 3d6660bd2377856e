"""Fixed images: wall layers, each particle extrapolating linearly from the fluid particle nearest to it.

u_I = u_F + (1 + d_I/d_F) (u_W - u_F): the velocity on the line through the nearest fluid particle F, at distance d_F
from the wall, and the wall W, continued to the image I at distance d_I beyond it (F. Bierbrauer, "No-Slip Boundary
Conditions in Smoothed Particle Hydrodynamics", slides 4 and 6, first way; the linear extrapolation of Takeda et al.
1994 and Morris et al. 1997). The factor has no bound where F comes near the wall; as Morris et al. cap it, d_F is taken
to be at least ``least_distance`` spacings. Pressure and polymer stress are those of F.
"""

from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Model
from tisph.runtime import scalar, ti
from tisph.walls._dummies import DummyWalls


class Parameters(Model):
    """``least_distance``: smallest distance from the wall that the extrapolation uses, in particle spacings."""

    type: Literal["fixed_image"] = "fixed_image"
    least_distance: Annotated[float, Field(gt=0, le=1)] = 0.25


@ti.data_oriented
class Treatment(DummyWalls):
    """Linear extrapolation from the nearest fluid particle."""

    def __init__(self, lists, kernel, liquid, parameters):
        super().__init__(lists, kernel, liquid, parameters)
        self.least_distance = scalar(parameters.least_distance * lists.spacing)

    @ti.func
    def extrapolate(self, buffer, k):
        """Set what image ``k`` carries; without fluid in reach, the velocity of the wall."""
        position = self.particles.mid_position[buffer, k]
        found = -1
        shortest = self.lists.reach_squared[None] * 4.0
        for n in range(self.lists.count[k]):
            j = self.lists.table[k, n]
            apart = self.particles.mid_position[buffer, j] - position
            apart.x = self.domain.nearest(apart.x)
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
        inside = ti.max(ti.select(y < 0.0, height, self.domain.gap[None] - height), self.least_distance[None])
        fluid = self.particles.mid_velocity[buffer, j]
        wall = ti.Vector([self.wall_velocity(y), 0.0])
        velocity = fluid + (1.0 + self.depth(y) / inside) * (wall - fluid)
        if ti.static(self.particles.carries_stress):
            self.give(buffer, k, velocity, self.particles.mid_pressure[buffer, j], self.particles.mid_stress[buffer, j])
        else:
            self.give(buffer, k, velocity, self.particles.mid_pressure[buffer, j], 0.0)
