"""Parallel flow whose flow rate changes in time, between plane walls or in a pipe, of a fluid with linear stresses.

With the mean velocity U(t), the steady profile P of mean 1, and a velocity w of mean 0 that is 0 at the walls,

    u = U(t) P(y) + w(y, t),    dw/dt = G + (nu_s w' + sum of tau)' - dU/dt P,    T dtau/dt = nu_p w' - tau,

where G(t) keeps the mean 0, ' is the derivative along y, around an axis (1/r) (r .)' of fluxes, nu_s the
viscosity of the solvent, and T and nu_p relaxation time and viscosity of each mode of an Oldroyd-B fluid. The part
U P of the flow has stresses proportional to P', whose divergence is the same everywhere, like a pressure gradient.

w is sought among polynomials of ``DEGREE`` that obey the conditions (Galerkin's method). Their eigenfunctions phi_n
turn the equations into systems of ordinary differential equations for amplitudes, which are solved exactly: by their
eigenvalues where U is piecewise linear, and for U = Re(A e^(i w t)) in the periodic state. The polynomials resolve
layers of a thousandth of the width.

Source: J. R. Womersley, J. Physiol. 127 (1955) 553-563, for Newtonian oscillating flow in a pipe.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre

DEGREE = 40
"""Degree of the polynomials, in the square of the radius where the fluid reaches the axis."""


class ChangingProfile:
    """The velocity w between ``low`` and ``high``: ``value`` and its derivative ``slope``, and time derivatives.

    ``steady``: P. ``viscosity``: nu_s; ``modes``: pairs (T, nu_p). ``course`` of the mean velocity: with a ``wave``
    (amplitudes ``cosine`` and ``sine``, ``angular_frequency``), or with ``breakpoints``, pairs of a time and a jump of
    dU/dt after a jump of U at it. ``axisymmetric``: y is the radius.
    """

    def __init__(
        self,
        low: float,
        high: float,
        steady: Callable[[np.ndarray], np.ndarray],
        viscosity: float,
        modes: Sequence[tuple[float, float]],
        course: Any,
        axisymmetric: bool = False,
    ) -> None:
        from scipy.linalg import eigh, null_space

        self.low, self.high = low, high
        self.squared = axisymmetric and low == 0.0
        node, weight = legendre.leggauss(DEGREE + 20)
        y = 0.5 * (low + high) + 0.5 * (high - low) * node
        weight = 0.5 * (high - low) * weight * (y if axisymmetric else 1.0)
        values, slopes = self._polynomials(y)
        walls = self._polynomials(np.array([high] if self.squared else [low, high]))[0]
        basis = null_space(np.vstack([walls, weight @ values]))
        values, slopes = values @ basis, slopes @ basis
        stiffness, mass = (each.T @ (weight[:, None] * each) for each in (slopes, values))
        rates, vectors = eigh(stiffness, mass)
        self.functions, forcing = basis @ vectors, (weight * steady(y)) @ values @ vectors
        size = 1 + len(modes)
        self.system, self.forcing = np.zeros((len(rates), size, size)), np.zeros((len(rates), size))
        self.system[:, 0, 0], self.system[:, 0, 1:] = -rates * viscosity, -rates[:, None]
        for number, (time, polymer) in enumerate(modes, start=1):
            self.system[:, number, [0, number]] = polymer / time, -1.0 / time
        self.forcing[:, 0] = -forcing
        in_time, modes_of = np.linalg.eig(self.system.astype(complex))
        self.modes_in_time = in_time, modes_of, np.linalg.inv(modes_of)
        self.wave = getattr(course, "wave", None)
        self.pieces = [] if self.wave else self._pieces(course.breakpoints)

    def _polynomials(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return Legendre polynomials (n, degrees) at places ``y`` (n,), and their derivatives."""
        low, high = self.low, self.high
        place = 2.0 * (y / high) ** 2 - 1.0 if self.squared else (2.0 * y - low - high) / (high - low)
        scale = 4.0 * y / high**2 if self.squared else np.full(len(y), 2.0 / (high - low))
        slopes = legendre.legval(place, legendre.legder(np.eye(DEGREE + 1))).T
        return legendre.legvander(place, DEGREE), scale[:, None] * slopes

    def _pieces(self, breakpoints: Sequence[tuple[float, float, float]]) -> list[tuple[float, float, np.ndarray]]:
        """Return begin, dU/dt and the state (functions, unknowns) at the begin of each piece."""
        pieces = [(breakpoints[0][0], 0.0, np.zeros_like(self.forcing))]
        for begin, _, bend in breakpoints:
            last, slope, state = pieces[-1]
            pieces.append((begin, slope + bend, self._later(state, slope, begin - last)))
        return pieces

    def _later(self, state: np.ndarray, slope: float, elapsed: float) -> np.ndarray:
        """Return the state a time ``elapsed`` after a ``state`` where dU/dt is constant, ``slope``."""
        rates, vectors, inverse = self.modes_in_time
        first, forcing = (np.einsum("nij,nj->ni", inverse, each) for each in (state, slope * self.forcing))
        later = np.exp(rates * elapsed) * first + np.expm1(rates * elapsed) / rates * forcing
        return np.einsum("nij,nj->ni", vectors, later).real

    def state(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the amplitudes (functions,) of the functions at ``time``, and their time derivatives."""
        if self.wave:
            turning = 1j * self.wave.angular_frequency
            amplitude = (self.wave.cosine - 1j * self.wave.sine) * np.exp(turning * time)
            unit = np.eye(self.forcing.shape[1])
            found = np.linalg.solve(turning * unit - self.system, (turning * amplitude * self.forcing)[..., None])
            return found[:, 0, 0].real, (turning * found[:, 0, 0]).real
        begin, slope, state = next((piece for piece in reversed(self.pieces) if piece[0] <= time), self.pieces[0])
        state = self._later(state, slope, max(0.0, time - begin))
        return state[:, 0], np.einsum("nj,nj->n", self.system[:, 0], state) + slope * self.forcing[:, 0]

    def value(self, y: np.ndarray, time: float, order: int = 0) -> np.ndarray:
        """Return the time derivative of an ``order`` 0 or 1 of w at places ``y`` (n,)."""
        return self._polynomials(y)[0] @ (self.functions @ _state(self, float(time))[order])

    def slope(self, y: np.ndarray, time: float, order: int = 0) -> np.ndarray:
        """Return the derivative of ``value`` along y."""
        return self._polynomials(y)[1] @ (self.functions @ _state(self, float(time))[order])


@lru_cache(maxsize=8)
def _state(profile: ChangingProfile, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the ``state`` of a ``profile``: each step asks for a few times often. A profile that kept it could not be
    sent to the process that draws."""
    return profile.state(time)
