"""Density and polymer stress of the fluid on the walls, at points that move with them, for ``consistent_image.py``.

At the wall u_x = v_x = 0, so that at a point of the wall density and stress follow from the slopes u_y and v_y,

    d rho_W/dt = -rho_W v_y,      dS_W/dt = rate of ``Stress`` with the velocity gradient [[0, u_y], [0, v_y]]

and the slope of the stress from the derivative of that law across the wall,

    dS_y/dt = (L S_y + S_y L^T) + (L_y S + S L_y^T) - v_y S_y - S_y/lambda + G (L_y + L_y^T),
    L_y = [[0, u_yy], [0, 0]]

where the momentum equation at the wall gives u_yy = (dU/dt - g - S_xy,y/rho_W)/nu_s. This is the order of Bierbrauer's
slides 14 to 20: density, stress, velocity; derivatives along the wall are left out, as rho_x is on slide 21. A slope of
the stress fitted to the particles would feed back on them through u_yy: with a solvent fraction of 0.1 the velocity of
the row next to the wall then diverges within a few relaxation times.

u_y and v_y come from the particles near each point: f - f_W = a d + b d^2 is fitted by weighted least squares over the
distance d from the wall, with two rows in reach the one-sided difference (-8 f_W + 9 f_1 - f_2)/(6 d).
"""

from typing import Any

import numpy as np

from tisph.runtime import integer, real, scalar, ti, view
from tisph.scenes._channel import Channel
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.verlet import VerletLists
from tisph.size_class import size_class

STEP = 1e-4
"""Step of the one-sided difference that gives the slope of the initial stress at the walls, over the gap."""


@ti.data_oriented
class WallStress:
    """Points one spacing apart on both walls, index [top, k]: compression, stress, slope of the stress over y.

    ``count``: points on a wall, not compiled in; point k is at ``origin[top]`` + k spacing. Stresses are over the
    reference density.
    """

    def __init__(self, lists: VerletLists, fluid: Fluid, points: int):
        self.lists = lists
        self.particles, self.cells, self.domain, self.fluid = lists.particles, lists.cells, lists.domain, fluid
        self.count = integer(points)
        self.spacing = scalar(lists.spacing)
        self.radius_squared = scalar(lists.cutoff**2)
        self.origin = ti.field(real(), shape=2)
        shape = 2, size_class(points)
        self.column = ti.field(ti.i32, shape=shape)
        self.compression = ti.field(real(), shape=shape)
        tensor = ti.types.vector(3, real())
        self.stress, self.mid_stress, self.slope, self.mid_slope = (ti.field(tensor, shape=shape) for _ in range(4))
        for field in (self.column, *self.fields()):
            field.used = np.s_[:, :points]

    def fields(self) -> list[Any]:
        """Return the fields that a step changes."""
        return [self.compression, self.stress, self.mid_stress, self.slope, self.mid_slope]

    def load(self, channel: Channel) -> None:
        """Set stress and slope of the points from the initial polymer stress of the fluid."""
        step = STEP * channel.gap
        inside = step * np.arange(3)
        heights = np.concatenate([inside, channel.gap - inside])
        stress = channel.exact_polymer_stress(heights, channel.start_time)[:2]
        xx, xy = (values.reshape(2, 3) / channel.density for values in stress)
        inward = np.array([1.0, -1.0]) / (2 * step)
        slopes = [inward * (one @ [-3.0, 4.0, -1.0]) for one in (xx, xy)]
        for fields, (first, second) in (
            ((self.stress, self.mid_stress), (xx[:, 0], xy[:, 0])),
            ((self.slope, self.mid_slope), slopes),
        ):
            for field in fields:
                view(field)[...] = np.stack([first, second, 0.0 * first], 1)[:, None, :]
        view(self.origin)[...] = 0.5 * channel.spacing

    @ti.kernel
    def locate(self):
        """Find the column of cells that each point is in, at the time of a sort."""
        for top in ti.static(range(2)):
            ti.loop_config(serialize=True)
            for k in range(self.count[None]):
                self.column[top, k] = self.cells.column_of(self.along(top, k))

    @ti.func
    def along(self, top: ti.template(), k):
        """Return the place of point ``k`` along its wall, in [0, length)."""
        return self.domain.wrap_x(self.origin[top] + k * self.spacing[None])

    @ti.func
    def follow(self, now, k, top: ti.template(), length, half):
        """Advance density, stress and slope of point ``k`` by ``length``; their middles are ``half`` a step ahead."""
        gradient = self.gradient(now, k, top)
        bent = ti.Matrix([[0.0, self.curvature(k, top)], [0.0, 0.0]])
        stress, slope = self.mid_stress[top, k], self.mid_slope[top, k]
        stress_rate = self.fluid.stress.rate(stress, gradient)
        # the law is linear in stress and gradient alike; its parts without gradient belong to the slope alone
        slope_rate = self.fluid.stress.rate(slope, gradient) - self.fluid.stress.strained(gradient)
        slope_rate += self.fluid.stress.stretched(stress, bent) + self.fluid.stress.strained(bent)
        slope_rate -= gradient[1, 1] * slope
        self.compression[top, k] -= length * (1.0 + self.compression[top, k]) * gradient[1, 1]
        self.stress[top, k] += length * stress_rate
        self.slope[top, k] += length * slope_rate
        self.mid_stress[top, k] = self.stress[top, k] + half * stress_rate
        self.mid_slope[top, k] = self.slope[top, k] + half * slope_rate

    @ti.func
    def curvature(self, k, top: ti.template()):
        """Return the second derivative u_yy that the momentum equation gives at point ``k``."""
        polymer = self.mid_slope[top, k][1] / (1.0 + self.compression[top, k])
        return (self.domain.relative_acceleration(top) - polymer) / self.fluid.kinematic_viscosity[None]

    @ti.func
    def move(self, top: ti.template(), elapsed):
        """Move the points of a wall with it."""
        self.origin[top] = self.domain.wrap_x(self.origin[top] + self.domain.wall_velocity(top) * elapsed)

    @ti.func
    def gradient(self, now, k, top: ti.template()):
        """Return the velocity gradient [[0, u_y], [0, v_y]] at point ``k``."""
        wall = ti.Vector([self.domain.wall_velocity(top), 0.0])
        second, third, fourth = 0.0, 0.0, 0.0
        once, twice = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
        x = self.along(top, k)
        columns = self.cells.columns[None]
        row = self.cells.place(self.cells.rows[None] if ti.static(top) else 1, 0)
        for side in range(-1, 2):
            cell = row + (self.column[top, k] + side + columns) % columns
            for j in range(self.cells.start[cell], self.cells.start[cell + 1]):
                place = self.particles.mid_position[now, j]
                along = self.domain.minimum_image_x(place.x - x)
                distance = self.domain.wall_distance(top, place.y)
                part = ti.max(0.0, 1.0 - (along * along + distance * distance) / self.radius_squared[None])
                weight = part * part * distance
                faster = self.particles.mid_velocity[now, j] - wall
                second += weight * distance
                third += weight * distance * distance
                fourth += weight * distance * distance * distance
                once += weight * faster
                twice += weight * distance * faster
        slope = (fourth * once - third * twice) / (second * fourth - third * third)
        if ti.static(top):
            slope = -slope  # from distance to height
        return ti.Matrix([[0.0, slope.x], [0.0, slope.y]])

    @ti.func
    def curvature_at(self, top: ti.template(), x):
        """Return the curvature of the velocity at a place along a wall, linear between points."""
        k, part = self.place(top, x)
        return self.curvature(k, top) * (1.0 - part) + self.curvature((k + 1) % self.count[None], top) * part

    @ti.func
    def slope_at(self, top: ti.template(), x):
        """Return the slope of the stress over y at a place along a wall, linear between points."""
        k, part = self.place(top, x)
        return self.mid_slope[top, k] * (1.0 - part) + self.mid_slope[top, (k + 1) % self.count[None]] * part

    @ti.func
    def place(self, top: ti.template(), x):
        """Return the point before ``x``, and the distance of ``x`` from it in spacings."""
        along = self.domain.wrap_x(x - self.origin[top]) / self.spacing[None]
        k = ti.cast(along, ti.i32)
        part = along - k
        return k % self.count[None], part
