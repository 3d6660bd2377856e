"""Plane channel 0 <= y <= gap, periodic in x over length: plane Couette flow between walls that move along x.

The walls are the planes y = 0 and y = gap; fluid particles start at cell centres, (i + 1/2) spacing. The
run's clock starts at ``start_time``: at the initial time of the config for the state ``exact``, else at 0.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.exact import couette


@dataclass(frozen=True)
class Channel:
    """Geometry, wall motion, liquid and exact solution; every number in the config's units.

    ``initial_state`` is ``rest`` (the liquid starts from rest at t = 0), ``developed`` (it has the steady
    linear profile) or ``exact`` (start-up from rest at t = 0, taken up at ``start_time``). ``rows`` and
    ``columns`` count the fluid particles across and along the channel, ``units`` holds the labels for plots
    and tables.
    """

    gap: float
    length: float
    density: float
    kinematic_viscosity: float
    bottom_velocity: float
    top_velocity: float
    initial_state: str
    start_time: float
    spacing: float
    columns: int
    rows: int
    units: Any

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        exact_start = config.initial.state == "exact"
        return cls(
            gap=config.geometry.gap,
            length=config.geometry.length,
            density=config.fluid.density,
            kinematic_viscosity=config.kinematic_viscosity,
            bottom_velocity=config.walls.bottom.velocity,
            top_velocity=config.walls.top.velocity,
            initial_state=config.initial.state,
            start_time=config.initial.time if exact_start else 0.0,
            spacing=config.spacing,
            columns=config.columns,
            rows=config.particles_across,
            units=config.units,
        )

    @property
    def reference_velocity(self):
        """The larger of the two wall speeds."""
        return max(abs(self.bottom_velocity), abs(self.top_velocity))

    @property
    def reynolds(self):
        """Reynolds number, reference velocity * gap / kinematic viscosity."""
        return self.reference_velocity * self.gap / self.kinematic_viscosity

    @property
    def viscous_time(self):
        """Time gap^2 / kinematic viscosity in which momentum diffuses across the channel; t* = t / this."""
        return self.gap**2 / self.kinematic_viscosity

    @property
    def dynamic_viscosity(self):
        """Density * kinematic viscosity."""
        return self.density * self.kinematic_viscosity

    def exact_velocity(self, y, t):
        """Exact velocity along x at heights ``y`` and times ``t`` (they broadcast), on the run's clock."""
        if self.initial_state == "developed":
            linear = self.bottom_velocity + self._developed_shear_rate * np.asarray(y, dtype=float)
            return (linear + np.zeros_like(t, dtype=float))[()]
        return couette.velocity(y, t, **self._start_up)

    def exact_wall_shear(self, t):
        """Exact shear stress, dynamic viscosity * du/dy, at (bottom, top) wall at time(s) ``t``.

        Infinite at t = 0 on a wall that moves in a liquid still at rest.
        """
        if self.initial_state == "developed":
            rates = (np.full(np.shape(t), self._developed_shear_rate)[()],) * 2
        else:
            rates = (couette.shear_rate(wall, t, **self._start_up) for wall in (0.0, self.gap))
        return tuple(self.dynamic_viscosity * rate for rate in rates)

    def initial_velocity(self, y):
        """Velocity along x at heights ``y`` when the run starts."""
        return self.exact_velocity(y, self.start_time)

    def lattice(self):
        """Cell centres as arrays (x, y) of shape (rows * columns,), row by row from the bottom wall."""
        y, x = np.meshgrid(np.arange(self.rows) + 0.5, np.arange(self.columns) + 0.5, indexing="ij")
        return self.spacing * x.ravel(), self.spacing * y.ravel()

    def jittered(self, seed, jitter):
        """Cell centres displaced at random, uniformly within +- ``jitter`` * spacing in x and y.

        ``0 <= jitter < 0.5`` (else ValueError), so that each particle stays in its cell: inside the walls and
        inside [0, length). The same ``seed`` gives the same positions.
        """
        if not 0 <= jitter < 0.5:
            raise ValueError(f"jitter {jitter} is outside [0, 0.5)")
        x, y = self.lattice()
        shift_x, shift_y = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, x.size))
        return x + jitter * self.spacing * shift_x, y + jitter * self.spacing * shift_y

    def tracer_positions(self, count, x="centre"):
        """Arrays (x, y) of ``count`` probes on a vertical line, at heights (k + 1/2) gap / count.

        ``x`` is a distance along the channel, or ``centre``.
        """
        position = 0.5 * self.length if x == "centre" else x
        return np.full(count, float(position)), (np.arange(count) + 0.5) * self.gap / count

    @property
    def _developed_shear_rate(self):
        return (self.top_velocity - self.bottom_velocity) / self.gap

    @property
    def _start_up(self):
        return {
            "gap": self.gap,
            "kinematic_viscosity": self.kinematic_viscosity,
            "bottom": self.bottom_velocity,
            "top": self.top_velocity,
        }


Scene = Channel
"""The name under which a run asks a module of this folder for its scene."""
