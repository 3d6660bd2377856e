"""Heat or a dissolved substance that a developed flow carries: entrance of a heated channel, and dispersion.

A scalar T obeys T_t + u T_x = kappa lap T in the flow u(y) between planes 0 <= y <= width, or u(r) in a pipe whose
radius is the ``width``. Any self-consistent units.

* ``Entrance`` (Graetz problem): steady T behind x = 0, where the fluid enters at one temperature, without conduction
  along x. Walls from x = 0 on have one temperature, or one heat flux q. Nu = q Dh/(k (T_wall - T_bulk)), with
  T_bulk = int u T dA/int u dA and Dh = 4 area/perimeter: twice the gap, or the diameter.
* ``Dispersion``: the modes f(y) exp(i k x + s t) between insulated walls. For small k the slowest one has
  s = -i k V - D_eff k^2 with the mean velocity V: Taylor's dispersion.

Numerics: Galerkin's method with polynomials of y, or of r^2, and their eigenfunctions: for functions phi_i of the cross
section, the matrices int phi_i phi_j dA (M), int grad phi_i grad phi_j dA (K) and int u phi_i phi_j dA (C) turn the
entrance into C da/dx = -kappa K a + heat flux, and modes into s M a = -(kappa (K + k^2 M) + i k C) a.

Accuracy: 1e-10; Nusselt numbers 1e-7 from x kappa/(V Dh^2) = 1e-4 on.

Sources: R. K. Shah and A. L. London, Laminar Flow Forced Convection in Ducts (1978), chapters V and VI; G. I. Taylor,
Proc. R. Soc. A 219 (1953) 186-203; R. Aris, Proc. R. Soc. A 235 (1956) 67-77.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

DEGREE = 44
"""Degree of the polynomials in y or in r^2."""


def parabola(mean: float, width: float, pipe: bool = False) -> Callable[[Any], np.ndarray]:
    """Return the profile of Poiseuille flow of a ``mean`` velocity between planes, or in a pipe of radius ``width``."""
    if pipe:
        return lambda r: 2 * mean * (1 - (np.asarray(r) / width) ** 2)
    return lambda y: 6 * mean * np.asarray(y) / width * (1 - np.asarray(y) / width)


@dataclass(frozen=True)
class _CrossSection:
    """Polynomials in the cross section of a flow with the profile ``velocity``; ``pipe``: the ``width`` is its radius.

    Areas of a pipe are divided by 2 pi.
    """

    width: float
    velocity: Callable[[Any], Any]
    diffusivity: float
    pipe: bool = False

    @property
    def area(self) -> float:
        """Area per depth."""
        return self.width**2 / 2 if self.pipe else self.width

    @property
    def perimeter(self) -> float:
        """Length of the walls."""
        return self.width if self.pipe else 2.0

    @property
    def hydraulic_diameter(self) -> float:
        """Dh = 4 area/perimeter."""
        return 4 * self.area / self.perimeter

    @property
    def mean_velocity(self) -> float:
        """Mean V of the velocity over the area."""
        _, _, _, weight, flow = self._matrices
        return float(np.sum(weight * flow) / self.area)

    def _polynomials(self, y: Any) -> np.ndarray:
        """Return the Legendre polynomials (..., degrees) at places ``y``, which are radii in a pipe."""
        share = np.asarray(y, dtype=float) / self.width
        return legendre.legvander(2 * (share**2 if self.pipe else share) - 1, DEGREE)

    @cached_property
    def _matrices(self) -> tuple[np.ndarray, ...]:
        """M, K and C, and the weights dA and velocities at the points of Gauss's quadrature."""
        node, weight = legendre.leggauss(DEGREE + 20)
        y = self.width * (node + 1) / 2
        weight = weight * self.width / 2 * (y if self.pipe else 1.0)
        flow = np.asarray(self.velocity(y)) + 0.0 * y
        values = self._polynomials(y)
        place = 2 * (y / self.width) ** 2 - 1 if self.pipe else node
        scale = 4 * y / self.width**2 if self.pipe else np.full(len(y), 2 / self.width)
        slopes = scale[:, None] * legendre.legval(place, legendre.legder(np.eye(DEGREE + 1))).T
        pairs = ((values, weight), (slopes, weight), (values, weight * flow))
        return *((part.T * factor) @ part for part, factor in pairs), weight, flow

    @property
    def _walls(self) -> np.ndarray:
        """Polynomials (walls, degrees) at the walls."""
        return self._polynomials([self.width] if self.pipe else [0.0, self.width])


@dataclass(frozen=True)
class Entrance(_CrossSection):
    """T behind x = 0, where the fluid enters with one temperature; the ``velocity`` is above 0 between the walls.

    With a given temperature of the walls T is 1 at the inlet and 0 at the walls, (T - T_wall)/(T_inlet - T_wall). With
    a given ``flux`` T is 0 at the inlet, (T - T_inlet) k/(q a), where a is half the gap or the radius. Distances ``x``
    >= 0 and places ``y`` broadcast.
    """

    flux: bool = False

    def temperature(self, x: Any, y: Any) -> np.ndarray:
        """Return the temperature T, in the units of the class."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        rates, functions, weights = self._modes
        modes = self._polynomials(y) @ functions * weights
        if not self.flux:
            return np.sum(modes * self._decay(x), axis=-1)
        return (
            self.bulk(x) + np.sum(modes / rates * -np.expm1(-self.diffusivity * rates * x[..., None]), -1) / self._half
        )

    def bulk(self, x: Any) -> np.ndarray:
        """Return the bulk temperature, in the units of the class."""
        x = np.asarray(x, dtype=float)
        if self.flux:
            return self.diffusivity * self.perimeter * x / (self.mean_velocity * self.area * self._half)
        return np.sum(self._modes[2] ** 2 * self._decay(x), axis=-1) / (self.mean_velocity * self.area)

    def nusselt(self, x: Any) -> np.ndarray:
        """Return the local Nusselt number at distances ``x`` > 0."""
        x = np.asarray(x, dtype=float)
        rates, _, weights = self._modes
        if self.flux:
            difference = -(weights**2) / rates * np.expm1(-self.diffusivity * rates * x[..., None])
            return self.hydraulic_diameter * self.perimeter / np.sum(difference, axis=-1)
        decay = weights**2 * np.exp(-self.diffusivity * (rates - rates[0]) * x[..., None])
        return np.sum(decay * rates, axis=-1) / np.sum(decay, axis=-1) * self._scale * self.diffusivity

    def mean_nusselt(self, x: Any) -> np.ndarray:
        """Return the mean Nusselt number from 0 to ``x`` > 0, of walls with a given temperature."""
        return -np.log(self.bulk(x)) / np.asarray(x, dtype=float) * self._scale

    def developed_nusselt(self, axial_conduction: bool = False) -> float:
        """Return the Nusselt number far behind the entrance, with ``axial_conduction`` if it is asked for.

        Then T falls as exp(-g x) and heat conducts along x, too: kappa (K - g^2 M) a = g C a. A given flux has the
        same number with and without axial conduction.
        """
        if self.flux:
            rates, _, weights = self._modes
            return float(self.hydraulic_diameter * self.perimeter / np.sum(weights**2 / rates))
        if not axial_conduction:
            return float(self._modes[0][0] * self.diffusivity * self._scale)
        mass, stiffness, carried = (self._basis.T @ matrix @ self._basis for matrix in self._matrices[:3])
        kappa, size = self.diffusivity, len(mass)
        upper = np.linalg.solve(stiffness, np.hstack([carried / kappa, mass]))
        lengths, vectors = np.linalg.eig(np.vstack([upper, np.eye(size, 2 * size)]))
        longest = np.argmax(lengths.real)  # of the lengths 1/g
        rate, mode = 1 / lengths[longest].real, self._basis @ vectors[:size, longest].real
        # the integral of a function is its product with the first column of M or C, because the first polynomial is 1
        bulk, mean = self._matrices[2][0] @ mode, self._matrices[0][0] @ mode
        return float(rate * (bulk + kappa * rate * mean) / bulk * self._scale)

    @property
    def _half(self) -> float:
        return self.width if self.pipe else self.width / 2

    @property
    def _scale(self) -> float:
        """V Dh^2/(4 kappa): a rate of the bulk temperature (1/length) times it is a Nusselt number."""
        return self.mean_velocity * self.hydraulic_diameter**2 / (4 * self.diffusivity)

    @cached_property
    def _basis(self) -> np.ndarray:
        """Polynomials (degrees, functions) that are 0 at walls with a given temperature, or whose bulk is 0."""
        from scipy.linalg import null_space

        return null_space(self._matrices[2][:1] if self.flux else self._walls)

    @cached_property
    def _modes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rates of K a = rate C a, the functions a (degrees, functions), and the weights of the inlet or the walls.

        The eigenvalues 1/rate are as exact as round-off of the largest allows; the smallest are left out.
        """
        from scipy.linalg import eigh

        _, stiffness, carried, *_ = self._matrices
        lengths, vectors = eigh(self._basis.T @ carried @ self._basis, self._basis.T @ stiffness @ self._basis)
        kept = np.flatnonzero(lengths > 1e-13 * lengths.max())[::-1]
        functions = self._basis @ vectors[:, kept] / np.sqrt(lengths[kept])
        edge = self.width if self.pipe else 1.0
        source = edge * self._walls.sum(axis=0) if self.flux else carried[0]
        return 1 / lengths[kept], functions, source @ functions

    def _decay(self, x: np.ndarray) -> np.ndarray:
        return np.exp(-self.diffusivity * self._modes[0] * x[..., None])


@dataclass(frozen=True)
class Dispersion(_CrossSection):
    """Spreading along x of a substance between insulated walls, in any profile ``velocity``."""

    @property
    def effective_diffusivity(self) -> float:
        """D_eff after long times: kappa (1 + Pe^2/210) in Poiseuille flow, 1 + Pe^2/30 in Couette flow of one wall.

        Pe = V width/kappa; in a pipe 1 + Pe^2/48.
        """
        mass, stiffness, carried, *_ = self._matrices
        excess = carried[0] - self.mean_velocity * mass[0]
        shape = np.linalg.solve(stiffness[1:, 1:], excess[1:])  # the first polynomial is constant
        return self.diffusivity + float(excess[1:] @ shape) / (self.diffusivity * self.area)

    def rate(self, wavenumber: float) -> complex:
        """Return s (1/time) of the slowest mode with the ``wavenumber`` k."""
        return self._slowest(wavenumber)[0]

    def mode(self, wavenumber: float, y: Any) -> np.ndarray:
        """Return the complex amplitude f of the slowest mode at places ``y``, with the mean 1."""
        return self._polynomials(y) @ self._slowest(wavenumber)[1]

    def _slowest(self, wavenumber: float) -> tuple[complex, np.ndarray]:
        from scipy.linalg import eig

        mass, stiffness, carried, *_ = self._matrices
        rates, vectors = eig(
            -self.diffusivity * (stiffness + wavenumber**2 * mass) - 1j * wavenumber * carried, mass.astype(complex)
        )
        slowest = np.argmax(rates.real)
        return complex(rates[slowest]), vectors[:, slowest] * self.area / (mass[0] @ vectors[:, slowest])
