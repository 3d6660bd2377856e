"""Positions of the particles, and how a step moves them."""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real, ti, view


class Motion:
    """Positions (fluid), what moves them, and positions and velocities (2, fluid) before the last step."""

    def __init__(self, field, shift, period):
        step = field.step
        self.field, self.step, self.points, self.shift = field, step, step.points, shift
        self.period = period
        self.position, self.start_position = (self.points.field(ti.types.vector(2, real())) for _ in range(2))
        self.start_velocity = self.points.field(real(), 2)

    def predict(self, half):
        """Put the points where the particles are in the middle of a step twice as long as ``half``."""
        place = active(self.position) + half * active(self.step.velocity).T
        place[:, 0] = self.wrapped(place[:, 0])
        view(self.points.position)[: self.points.fluid] = place

    def shift_fields(self, half):
        """Transfer positions and velocities to the shifted points: by the Taylor series of the velocities.

        A shift D in the middle of the step is one by D_x - ``half`` u_y D_y along the channel at its start.
        """
        shift = view(self.shift.moved)[: self.points.fluid]
        moved = np.flatnonzero(shift.any(axis=1))
        x, y = shift[moved].T
        slope, curvature = active(self.field.slope)[:, moved], active(self.field.curvature)[:, moved]
        x = x - half * slope[0, :, 1] * y
        squares = np.stack([0.5 * x * x, x * y, 0.5 * y * y], axis=1)
        change = slope[..., 0] * x + slope[..., 1] * y + np.einsum("cnk,nk->cn", curvature, squares)
        self.step.shift_fields(moved, y)
        velocity = active(self.step.velocity)
        velocity[:, moved] += change
        active(self.position)[moved] = view(self.points.position)[moved] - half * velocity[:, moved].T

    def move(self, dt):
        """Move the particles over the step and take up the velocities at its end."""
        position, velocity, end = (active(field) for field in (self.position, self.step.velocity, self.step.end))
        active(self.start_position)[...] = position
        active(self.start_velocity)[...] = velocity
        position += (0.5 * dt) * (velocity + end).T
        position[:, 0] = self.wrapped(position[:, 0])
        self.step.accept()

    def wrapped(self, x):
        """Return ``x`` moved by whole periods into [0, period)."""
        inside = x - np.floor(x / self.period) * self.period
        return np.where(inside < self.period, inside, 0.0)
