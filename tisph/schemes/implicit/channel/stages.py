"""The stages of an implicit step: weights, the flow in a stage, and the operators between two walls.

The method is described in ``step.py``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

GAMMA = 1767732205903 / 4055673282236

A = (
    (0.0, 0.0, 0.0, 0.0),
    (GAMMA, GAMMA, 0.0, 0.0),
    (2746238789719 / 10658868560708, -640167445237 / 6845629431997, GAMMA, 0.0),
    (1471266399579 / 7840856788654, -4482444167858 / 7529755066697, 11266239266428 / 11593286722821, GAMMA),
)
B = A[3]
C = (0.0, 2.0 * GAMMA, 0.6, 1.0)

B_HAT = (
    2756255671327 / 12835298489170,
    -10771552573575 / 22201958757719,
    9247589265047 / 10645013368117,
    2193209047091 / 5459859503100,
)
"""Weights of the second-order result; the difference from ``B`` estimates the error."""

EMBEDDED_ORDER = 2

DEFECT = tuple(b - b_hat for b, b_hat in zip(B, B_HAT, strict=True))

FIT_TERMS = 3
"""Terms of the polynomial in the wall distance that describes the fluid near a wall."""

EVEN_POWERS = (0, 2, 4)
"""Powers of the wall distance in the fit for a value at a stress-controlled wall."""

Series = Sequence[float]
"""c0, c1, c2 of the boundary value c0 + c1 d^2 + c2 d^4 of an image; with an even reflection times d."""

Solution = tuple[np.ndarray, Any, Any]
"""Velocity, shear rate and stress (n,) of a stage, linearised; the latter two None without an extra stress."""


@dataclass
class FlowState:
    """The flow in one stage, of n points.

    ``substances`` (substances, n): temperature and dissolved substances; ``substance_rates``: their time derivatives.
    ``factor`` (n,): of viscosity and relaxation times by the temperature; None without an effect.

    ``velocity`` (n,) and ``state`` (components, n), the states C of the extra stress; ``velocity_rate`` and
    ``state_rate``: their time derivatives. ``shear_rate`` (n,): D u; ``stress`` (n,): S_xy per unit density;
    ``tangent`` (n,): dS_xy/d(D u). The last three are None without an extra stress, for which ``state`` is (0, n).
    """

    velocity: np.ndarray
    state: np.ndarray
    shear_rate: Any = None
    stress: Any = None
    velocity_rate: Any = None
    state_rate: Any = None
    tangent: Any = None
    substances: Any = None
    substance_rates: Any = None
    factor: Any = None


class ClosedOperators:
    """Base of the operators A and D on n points between two walls, closed by images beyond them; arrays are (n,).

    Images have a sign times the value of their source plus a boundary value. The latter is a power series in the
    distance from the wall, with three coefficients for each wall (``series``, (2, 3), see ``PrescribedWall``).
    """

    diffusivity: float
    """Factor of A in the linear systems: the solvent viscosity, or the diffusivity of another field."""

    round_off = float(np.finfo(float).eps)
    """Round-off of the numbers, over their size."""

    def of_field(self, even: Sequence[bool], diffusivity: float) -> "ClosedOperators":
        """Return the operators of another field, which the (bottom, top) wall reflects evenly or oddly."""
        raise NotImplementedError

    def prepare(self) -> None:
        """Prepare linear systems with the assembled operators."""

    def point_heights(self) -> np.ndarray:
        """Return the y of the points."""
        raise NotImplementedError

    def laplacian(self, values: np.ndarray) -> np.ndarray:
        """Return A of velocities, without the boundary values of their images."""
        return self.derivative("laplacian", values, -1.0)

    def gradient(self, values: np.ndarray, parity: float) -> np.ndarray:
        """Return D of ``values`` whose images have ``parity`` times the value of their source."""
        return self.derivative("d_dy", values, parity)

    def boundary_laplacian(self, series: Sequence[Series]) -> np.ndarray:
        """Return the part of A u that the boundary values of the images contribute."""
        return self.boundary("laplacian", series)

    def boundary_gradient(self, series: Sequence[Series]) -> np.ndarray:
        """Return the part of D u that the boundary values of the images contribute."""
        return self.boundary("d_dy", series)

    def even_fit(self, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the indices of points near the wall ``side``, their distances from it, and their weights.

        The weighted sum of values is the value at the wall of the even polynomial that fits them best.
        """
        points, distance, radius = self.near_wall(side)
        near = np.flatnonzero(distance < radius)
        weights = np.linalg.pinv((distance[near, None] / radius) ** np.array(EVEN_POWERS))[0]
        return points[near], distance[near], weights

    def wall_values(self, values: np.ndarray) -> np.ndarray:
        """Return ``values`` (quantities, n) extrapolated to each wall (2, quantities).

        They follow from the least-squares fit of a polynomial in the wall distance to the points near a wall.
        """
        found = []
        for side in range(2):
            points, distance, radius = self.near_wall(side)
            near = distance < radius
            powers = (distance[near, None] / radius) ** np.arange(FIT_TERMS)
            found.append(np.linalg.lstsq(powers, values[:, points].T[near], rcond=None)[0][0])
        return np.array(found)

    def near_wall(self, side: int) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the indices of points that may be near a wall, their distances from it, and the radius of fits."""
        raise NotImplementedError

    def derivative(self, operator: str, values: np.ndarray, parity: float) -> np.ndarray:
        """Return an operator, ``laplacian`` or ``d_dy``, of ``values``; see ``gradient``."""
        raise NotImplementedError

    def boundary(self, operator: str, series: Sequence[Series]) -> np.ndarray:
        """Return the part of an operator that the boundary values of the images contribute."""
        raise NotImplementedError

    def boundary_stress(self, side: int, slope: Any, third: Any) -> np.ndarray:
        """Return the part of D S that the images beyond the wall ``side`` contribute, see ``stress_excess``."""
        raise NotImplementedError

    def solve(
        self, gamma_dt: float, tangent: np.ndarray | None, right: np.ndarray, guess: np.ndarray, tolerance: float
    ) -> np.ndarray | None:
        """Solve (1 - g ``diffusivity`` A - g D T D) x = ``right`` with g = ``gamma_dt`` and T = ``tangent`` (None: 0).

        Return x, from ``guess`` on solved to a residual of ``tolerance`` over |right|; None where that fails.
        """
        raise NotImplementedError


def weighted(weights: Sequence[float] | np.ndarray, values: Sequence[Any]) -> Any:
    """Return the sum of ``values``, numbers or arrays, times as many of the ``weights``."""
    total = weights[0] * values[0]
    for weight, value in zip(weights[1:], values[1:], strict=False):
        total = total + weight * value
    return total


def explicit_part(start: Any, stage: int, dt: float, rates: Sequence[Any]) -> Any:
    """Return the explicit part (4a) of a ``stage``, start + dt sum_{j<i} a_ij k_j, with the ``rates`` k_j so far."""
    return start + dt * weighted(A[stage], rates) if stage else start


def stage_predictors() -> np.ndarray:
    """Return the weights (4, 4) that integrate the polynomial through the rates before a stage up to its time.

    Row i predicts u_i = u^n + dt sum_{j<i} weights_ij k_j.
    """
    weights = np.zeros((4, 4))
    for stage in range(1, 4):
        powers = np.arange(stage)
        nodes = np.array(C[:stage])[:, None] ** powers
        weights[stage, :stage] = np.linalg.solve(nodes.T, C[stage] ** (powers + 1) / (powers + 1))
    return weights


def hermite(
    theta: Any, dt: float, start: np.ndarray, end: np.ndarray, start_rate: np.ndarray, end_rate: np.ndarray
) -> np.ndarray:
    """Return at the part ``theta`` of a step of ``dt`` the cubic with these values and time derivatives at its ends."""
    late = theta * theta * (3.0 - 2.0 * theta)
    change = dt * theta * (1.0 - theta) * ((1.0 - theta) * start_rate - theta * end_rate)
    return (1.0 - late) * start + late * end + change


def norm(values: np.ndarray) -> float:
    """Return the root mean square of ``values`` (n,)."""
    return float(np.sqrt(np.mean(np.square(values))))


PREDICTORS = stage_predictors()
