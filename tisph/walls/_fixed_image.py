"""What Taichi compiles for ``fixed_image.py``, where its formulas are."""

from tisph.runtime import scalar, ti
from tisph.walls._dummies import DummyWalls


@ti.data_oriented
class Treatment(DummyWalls):
    """Linear extrapolation from the nearest fluid particle."""

    def __init__(self, lists, kernel, fluid, parameters):
        super().__init__(lists, kernel, fluid, parameters)
        self.least_distance = scalar(parameters.least_distance * lists.spacing)

    @ti.func
    def extrapolate(self, buffer, k):
        """Set what image ``k`` carries; without fluid in reach, the velocity of the wall."""
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
