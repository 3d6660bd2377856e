"""Steady Stokes flow between two eccentric cylinders that turn: a journal bearing.

The outer cylinder is around the origin, the axis of the inner one at (d, 0). Between them, with z = x + i y and the
stream function Re(conj(z) phi + chi),

    u + i v = -i (phi + z conj(phi') + conj(chi')),   vorticity = -4 Re phi',   p = -4 dynamic viscosity Im phi'

A sum of six stream functions satisfies no slip; L carries a torque and x L a force:

    L = ln|(z - beta)/(R2 (1 - b z))|,   x,   |z|^2,   x L,   (R2^2 - |z|^2) Re g  with g = z/(1 - b z) and 1/(z - beta)

beta, within the inner cylinder, and 1/b, outside the outer one, are mirror images of each other in both. Sources: G. B.
Jeffery, Proc. R. Soc. Lond. A 101 (1922) 169-174; G. H. Wannier, Q. Appl. Math. 8 (1950) 1-32, with another origin.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np


@dataclass(frozen=True)
class EccentricCylinders:
    """Cylinders of ``inner_radius`` around (``distance``, 0) and ``outer_radius`` around the origin.

    ``inner`` and ``outer``: angular velocities (1/time), counterclockwise. Places ``x``, ``y`` between the cylinders
    broadcast against each other; results have their shape. ValueError for cylinders that touch.
    """

    inner_radius: float
    outer_radius: float
    distance: float
    inner: float
    outer: float

    def __post_init__(self) -> None:
        if not 0 < self.inner_radius < self.outer_radius - abs(self.distance):
            raise ValueError(f"a radius of {self.inner_radius} at {self.distance} is not within {self.outer_radius}")

    def velocity(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocity components (u, v)."""
        velocity = np.tensordot(self._weights, self._velocities(1j * np.asarray(y, dtype=float) + x), 1)
        return velocity.real, velocity.imag

    def vorticity(self, x: Any, y: Any) -> np.ndarray:
        """Return the vorticity dv/dx - du/dy (1/time)."""
        return -4 * self._slope(x, y).real

    def pressure(self, x: Any, y: Any, *, dynamic_viscosity: float) -> np.ndarray:
        """Return the pressure, which has opposite signs above and below the line of centres, and zero mean."""
        return -4 * dynamic_viscosity * self._slope(x, y).imag

    def force(self, *, dynamic_viscosity: float) -> np.ndarray:
        """Return the fluid's force (2,) on the inner cylinder, per length; on the outer one it is the opposite."""
        return np.array([0.0, -4 * np.pi * dynamic_viscosity * self._weights[3]])

    def torque(self, *, dynamic_viscosity: float) -> tuple[float, float]:
        """Return the fluid's torques (inner, outer), each around its own axis, counterclockwise, per length."""
        outer = -4 * np.pi * dynamic_viscosity * self._weights[0]
        return -outer - self.distance * self.force(dynamic_viscosity=dynamic_viscosity)[1], outer

    def _functions(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return phi', phi and chi' (6, ...) of each stream function, without angles, which cancel in the velocity."""
        d, square = self.distance, self.outer_radius**2
        squares = square - self.inner_radius**2 + d**2
        b = 2 * d / (squares + np.sqrt(squares**2 - 4 * square * d**2))
        away, far, none = z - square * b, 1 - b * z, np.zeros_like(z)
        log = np.log(np.abs(away / (self.outer_radius * far)))
        slope = 1 / away + b / far
        return (
            np.stack([none, none, none + 1, slope / 2, -z * (1 + far) / far**2, square * b / away**2]),
            np.stack([none, none, z, log / 2, -(z**2) / far, -z / away]),
            np.stack([slope, none + 1, none, (log + z * slope) / 2, square / far**2, -square / away**2]),
        )

    def _velocities(self, z: np.ndarray) -> np.ndarray:
        """Return u + i v (6, ...) of each stream function."""
        phi_slope, phi, chi_slope = self._functions(z)
        return -1j * (phi + z * np.conj(phi_slope) + np.conj(chi_slope))

    @cached_property
    def _weights(self) -> np.ndarray:
        """Coefficients of the stream functions (6,)."""
        circle = np.exp(0.125j * np.pi * (np.arange(16) + 0.5))  # at least three points are needed
        inner, outer = self.inner_radius * circle, self.outer_radius * circle
        functions = self._velocities(np.concatenate([self.distance + inner, outer]))
        walls = 1j * np.concatenate([self.inner * inner, self.outer * outer])
        matrix, values = (np.concatenate([each.real, each.imag], axis=-1) for each in (functions, walls))
        return np.linalg.lstsq(matrix.T, values, rcond=None)[0]

    def _slope(self, x: Any, y: Any) -> np.ndarray:
        return np.tensordot(self._weights, self._functions(1j * np.asarray(y, dtype=float) + x)[0], 1)
