"""Virtual images: wall layers, each particle reflecting the fluid interpolated at its mirror point.

u_I = u_V + (1 + d_I/d_V) (u_W - u_V) with d_V = d_I: the virtual point V is the mirror point of the fixed image I, in
line with it, so that no error arises where fluid and image are not aligned (F. Bierbrauer, "No-Slip Boundary Conditions
in Smoothed Particle Hydrodynamics", slides 4 and 6, second way). At a curved wall it is the mirror point in the
nearest point of the wall, where u_W and the acceleration a_W are taken; p_I = p_V + a_W . r_VI per unit density, r_VI
from I to V (in a channel a_W is along the walls and left out). Values at V are first-order consistent: a moving
least-squares fit of c0 + c1 x + c2 y, exact for linear fields, also for disordered particles (the slides say
"interpolation"; an average would sit at the wrong depth next to the wall). Pressure and polymer stress are those at V.
"""

from functools import cache
from typing import Any, Literal

from tisph.schemes.wcsph.walls import Treatments, WallParameters

RADIUS = 0.75
"""Radius of the fit over the cutoff: lists of mirror points are complete up to it (wcsph/verlet.py)."""

SMALLEST_DETERMINANT = 1e-6
"""Determinant of the moments, with lengths over the radius and a sum of weights of 1, below which the points count as
lying on a line."""


class Parameters(WallParameters):
    """No parameters: virtual points mirror the images, which continue the lattice."""

    type: Literal["virtual_image"] = "virtual_image"


@cache
def treatments() -> Treatments:
    """Return the classes that Taichi compiles."""
    from tisph.runtime import real, scalar, ti
    from tisph.schemes.wcsph.verlet import VerletLists
    from tisph.schemes.wcsph.walls._dummies import Dummies, DummyWalls, LayerWalls

    @ti.data_oriented
    class MirrorPointDummies(Dummies):
        """Reflection of the velocity fitted at the mirror point."""

        uses_mirror_points = True

        def __init__(self, lists: VerletLists, kernel: Any, *others: Any):
            super().__init__(lists, kernel, *others)
            self.value = ti.func(kernel.value)
            self.support = kernel.SUPPORT
            self.radius = scalar(RADIUS * lists.cutoff)
            self.vector, self.tensor = ti.types.vector(2, real()), ti.types.vector(3, real())
            self.matrix = ti.types.matrix(3, 3, real())

        @ti.func
        def extrapolate(self, buffer, k):
            """Set the values of image ``k``; without fluid around its virtual point, the velocity of the wall."""
            total, coefficients = self.fit(buffer, k)
            if total > 0.0:
                velocity, pressure, stress = self.vector(0.0), 0.0, self.tensor(0.0)
                for n in range(self.lists.count[k]):
                    j = self.lists.table[k, n]
                    weight, basis = self.weighted_basis(buffer, k, j)
                    share = weight * coefficients.dot(basis)
                    velocity += share * self.particles.mid_velocity[buffer, j]
                    pressure += share * self.particles.mid_pressure[buffer, j]
                    if ti.static(self.particles.carries_stress):
                        stress += share * self.particles.mid_stress[buffer, j]
                if ti.static(self.accelerates):
                    across = self.lists.centre(buffer, k) - self.particles.mid_position[buffer, k]
                    pressure += self.acceleration_at(k).dot(across)
                self.set_dummy(buffer, k, 2.0 * self.velocity_at(buffer, k) - velocity, pressure, stress)
            else:
                self.give_wall_values(buffer, k)

        @ti.func
        def fit(self, buffer, k):
            """Return the sum of the weights and the coefficients c of the value at V, sum_j w_j (c . basis_j) f_j."""
            moments = self.matrix(0.0)
            for n in range(self.lists.count[k]):
                weight, basis = self.weighted_basis(buffer, k, self.lists.table[k, n])
                moments += weight * basis.outer_product(basis)
            total = moments[0, 0]
            coefficients = ti.Vector([1.0 / ti.max(total, 1e-30), 0.0, 0.0])
            if moments.determinant() > SMALLEST_DETERMINANT * total**3:
                inverse = moments.inverse()
                coefficients = ti.Vector([inverse[0, 0], inverse[1, 0], inverse[2, 0]])
            return total, coefficients

        @ti.func
        def weighted_basis(self, buffer, k, j):
            """Return the weight of particle ``j`` at the virtual point of image ``k``, and (1, x, y) around it."""
            apart = self.particles.mid_position[buffer, j] - self.lists.centre(buffer, k)
            apart = self.domain.minimum_image(apart) / self.radius[None]
            weight = self.value(self.support * ti.sqrt(apart.dot(apart)))
            return weight, ti.Vector([1.0, apart.x, apart.y])

    @ti.data_oriented
    class Treatment(MirrorPointDummies, DummyWalls):
        """The walls of a channel."""

    @ti.data_oriented
    class BodyTreatment(MirrorPointDummies, LayerWalls):
        """The walls of bodies."""

    return Treatments(Treatment, BodyTreatment)
