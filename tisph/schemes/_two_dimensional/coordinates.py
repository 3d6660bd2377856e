"""Planar or axisymmetric: by what factors the equations of the two differ, and what their unknowns are.

In axisymmetric flow x is along the axis, y = r the distance from it, and the unknowns at a particle are

    u,   V = v/r,   W = w/r   and the pressure,

with v along r and w around the axis: all of them even in r, so that the operators of ``least_squares``, d/dx, d/ds with
s = r^2/2, and the Laplacian d2/dx2 + d2/dr2 + (1/r) d/dr, hold for all, and nothing is divided by r. With them

    div u = du/dx + r^2 dV/ds + 2 V,      vorticity around the axis = r (dV/dx - du/ds),
    DV/Dt = W^2 - V^2 - dp/ds + nu (Lap V + 2 dV/ds),      DW/Dt = -2 V W + nu (Lap W + 2 dW/ds),

Lap u and Lap p being the Laplacian alone. Along the path of a particle r V is a velocity and r^2 W the circulation,
whose derivatives have neither V^2 nor 2 V W: these are what backward differences are taken of, at the earlier r.
Planar flow has the factors 1 for r and r^2 and nothing for the rest; compiled in, they cost nothing.
"""

from tisph.runtime import ti


@ti.data_oriented
class Coordinates:
    """Of the points of ``operators``; ``components`` of a velocity."""

    def __init__(self, operators):
        self.operators, self.axisymmetric = operators, operators.axisymmetric
        self.components = 3 if self.axisymmetric else 2

    @ti.func
    def radius(self, i):
        """Return r of a point, 1 in planar flow."""
        result = 1.0
        if ti.static(self.axisymmetric):
            result = self.operators.radius(i)
        return result

    @ti.func
    def hoop(self, value):
        """Return what divergences have of a ``value`` beside derivatives: twice it, nothing in planar flow."""
        result = 0.0
        if ti.static(self.axisymmetric):
            result = 2.0 * value
        return result

    @ti.func
    def divergence(self, i, stress: ti.template(), first: ti.template(), d_dx, d_dy):
        """Return the force of a stress whose components begin at ``first`` of a field, of its derivatives.

        In axisymmetric flow xx, xr/r, rr, tt and, where there are as many, xt/r and rt/r^2; all but the first over r.
        """
        result = ti.Vector([0.0 for _ in range(self.components)])
        result[0], result[1] = d_dx[first] + d_dy[first + 1], d_dx[first + 1] + d_dy[first + 2]
        if ti.static(self.axisymmetric):
            own, square = stress[i], self.radius(i) ** 2
            result[0] = d_dx[first] + 2.0 * own[first + 1] + square * d_dy[first + 1]
            result[1] += (own[first + 2] - own[first + 3]) / square
            if ti.static(stress.n >= first + 6):
                result[2] = d_dx[first + 4] + 4.0 * own[first + 5] + square * d_dy[first + 5]
        return result

    @ti.func
    def displacement(self, y, velocity):
        """Return the displacement per time of what is at ``y`` and has these unknowns."""
        result = ti.Vector([velocity[0], velocity[1]])
        if ti.static(self.axisymmetric):
            result.y *= y + self.operators.lowest_radius[None]
        return result

    @ti.func
    def above_axis(self, position):
        """Return a position on the fluid's side of the axis."""
        result = position
        if ti.static(self.axisymmetric):
            lowest = self.operators.lowest_radius[None]
            result.y = ti.abs(position.y + lowest) - lowest
        return result

    @ti.func
    def carried(self, velocity, before, i):
        """Return unknowns of a particle that was at the position ``before`` as those of where it is now."""
        result = velocity
        if ti.static(self.axisymmetric):
            ratio = (before.y + self.operators.lowest_radius[None]) / self.operators.radius(i)
            result.y *= ratio
            result.z *= ratio * ratio
        return result

    @ti.func
    def gradient_product(self, i, velocity: ti.template(), d_dx, d_dy):
        """Return grad u : grad u, of a flow without divergence minus the Laplacian of the pressure."""
        radius = self.radius(i)
        result = d_dx[0] ** 2 + 2.0 * radius**2 * d_dy[0] * d_dx[1]
        if ti.static(self.axisymmetric):
            across, around = velocity[i][1], velocity[i][2]
            result += (across + radius**2 * d_dy[1]) ** 2 + across**2
            result -= 2.0 * around * (around + radius**2 * d_dy[2])
        else:
            result += d_dy[1] ** 2
        return result

    @ti.func
    def squared(self, i, velocity):
        """Return the square of the velocity of a point with these unknowns."""
        result = velocity.dot(velocity)
        if ti.static(self.axisymmetric):
            across = self.radius(i) * ti.Vector([velocity[1], velocity[2]])
            result = velocity[0] ** 2 + across.dot(across)
        return result

    @ti.func
    def shifted(self, i, moved):
        """Return the change of x and y, or x and s, of a particle that has ``moved`` to where it is now."""
        result = moved
        if ti.static(self.axisymmetric):
            result.y *= self.radius(i) - 0.5 * moved.y
        return result
