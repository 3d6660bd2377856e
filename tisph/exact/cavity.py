"""Lid-driven cavity, steady: tables for the lid of one speed, and a spectral solution for the regular lid.

The lid y = height moves along x with the same speed U everywhere or, ``RegularCavity``, with U 16 X^2 (1 - X)^2, X =
x/width, with which the corners are at rest. Re = U width/nu. The other walls are at rest.

Tables, of the square cavity: C. H. Marchi, R. Suero and L. K. Araki, J. Braz. Soc. Mech. Sci. Eng. 31 (2009) 186-198
(Re = 100, 400, 1000); O. Botella and R. Peyret, Computers & Fluids 27 (1998) 421-433, tables 9 and 10 (Re = 1000); the
extremes at Re = 400 by finite elements of our own. The tables of U. Ghia, K. N. Ghia and C. T. Shin (1982) are not
used: their error is 3e-3 at Re = 100, and there is a misprint at 400.

Accuracy of the regular lid in a square at order 36, against order 48, in units of U: stream function 1e-9, velocity
1e-7 (2e-8 on the centre lines) at Re = 1 and 100; 5e-9 and 4e-7 at Re = 400, against order 40.

The stream function of the regular lid is a polynomial, computed by Galerkin's and Newton's methods. In the cell
0 <= x <= 1, 0 <= y <= a with u = psi_y, v = -psi_x and the lid y = a moving as u = g(x), and for every
function phi that is 0 at the walls with its normal derivative,

    int lap psi lap phi + Re lap psi (psi_y phi_x - psi_x phi_y) = 0
    psi = g(x) a (Y^3 - Y^2) + sum c_kl f_k(X) f_l(Z)

with Y = y/a, X and Z in [-1, 1] across the cell. The first part of psi has the velocities of the walls; the functions
f_k are sums of the Legendre polynomials k, k + 2 and k + 4 that are 0 at both ends with their derivatives. In this weak
form the corners, where psi is only as smooth as r^3.7 (H. K. Moffatt, J. Fluid Mech. 18 (1964) 1-18), cost least; by
collocation at 48 points each way the highest polynomials spoil the velocity by 1e-6.

Source: J. Shen, SIAM J. Sci. Comput. 15 (1994) 1489-1505, equation (3.2) and section 3.
"""

import csv
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial, legendre

NEWTON_STEPS = 20
TOLERANCE = 1e-9
"""Largest last step of Newton's method, in units of the lid's speed and the width; the error is about its square."""

FIRST_ORDER = 24
"""Order whose solution, of a fourteenth of the cost, Newton's method starts from at a higher one."""

FIRST_REYNOLDS, GROWTH = 100.0, 2.0
"""Newton's method starts from Stokes flow; above the first Reynolds number it continues in steps of this factor."""

LID = Polynomial([0.0, 0.0, 16.0, -32.0, 16.0])
"""Velocity 16 x^2 (1 - x)^2 of the regular lid over its maximum, in the middle."""


@lru_cache(maxsize=8)
def stream_function(reynolds: float, aspect: float, order: int) -> np.ndarray:
    """Return the Legendre coefficients (order + 1, order + 1) of psi over X and Z; ``aspect`` a = height/width.

    ValueError if Newton's method does not converge: Re is too large for the order.
    """
    equations, c = _solved(reynolds, aspect, order)
    return equations.coefficients(c)


def _solved(reynolds: float, aspect: float, order: int) -> tuple["_Equations", np.ndarray]:
    """Return the equations and their solution c (order - 3, order - 3); see ``stream_function``."""
    equations, stages = _Equations(aspect, order), [reynolds]
    c = np.zeros((order - 3, order - 3))
    if order > FIRST_ORDER:  # there the same functions begin the list
        coarse = _solved(reynolds, aspect, FIRST_ORDER)[1]
        c[: len(coarse), : len(coarse)] = coarse
    while order <= FIRST_ORDER and stages[-1] > FIRST_REYNOLDS:
        stages.append(stages[-1] / GROWTH)
    for stage in reversed(stages):
        for _ in range(NEWTON_STEPS):
            step = np.linalg.solve(*equations.linearised(c, stage)).reshape(c.shape)
            c = c - step
            if np.abs(step).max() <= TOLERANCE:
                break
        else:
            raise ValueError(f"no steady flow was found at Re = {stage:g}: take a higher order, or a smaller Re")
    return equations, c


class _Equations:
    """The weak form for all phi = f_k f_l as one vector, and its derivatives; integrals by Gauss's quadrature.

    Functions and points are products, so that fields at the points (n, n) and integrals are products of small matrices:
    ``functions[axis][k]`` (n, functions) has the k-th derivatives along an axis.
    """

    def __init__(self, aspect: float, order: int) -> None:
        self.aspect = aspect
        self.basis = clamped(order)
        node, weight = legendre.leggauss(order + 5)  # exact for lap psi lap phi with the lift
        self.place = 0.5 * (1 + node)
        values = [legendre.legvander(node, order - k) @ legendre.legder(self.basis, k) for k in range(3)]
        self.functions = [[value * (2 / size) ** k for k, value in enumerate(values)] for size in (1.0, aspect)]
        self.weight = np.outer(weight, weight)
        laplacian = (2, 0), (0, 2)
        self.viscous = sum(self._products(self.weight, test, trial) for test in laplacian for trial in laplacian)

    def linearised(self, c: np.ndarray, reynolds: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the Jacobian (n, n) of the equations at the coefficients ``c``, n in all, and their residuals (n,)."""
        x, y, lap = self._field(c, 1, 0), self._field(c, 0, 1), self._field(c, 2, 0) + self._field(c, 0, 2)
        x, y, weighted = self.weight * x, self.weight * y, self.weight * lap
        equations = self._tested(weighted, 2, 0) + self._tested(weighted, 0, 2)
        equations += reynolds * (self._tested(lap * y, 1, 0) - self._tested(lap * x, 0, 1))
        slopes = self._products(weighted, (1, 0), (0, 1)) - self._products(weighted, (0, 1), (1, 0))
        for trial in ((2, 0), (0, 2)):
            slopes += self._products(y, (1, 0), trial) - self._products(x, (0, 1), trial)
        return self.viscous + reynolds * slopes, equations

    def _field(self, c: np.ndarray, i: int, j: int) -> np.ndarray:
        """Return d^(i + j) psi/dx^i dy^j at the points."""
        return self.functions[0][i] @ c @ self.functions[1][j].T + self._lift(i, j)

    def _tested(self, field: np.ndarray, i: int, j: int) -> np.ndarray:
        """Return the sums over the points of a ``field`` times d^(i + j) phi/dx^i dy^j, for all phi."""
        return (self.functions[0][i].T @ field @ self.functions[1][j]).ravel()

    def _products(self, field: np.ndarray, test: tuple[int, int], trial: tuple[int, int]) -> np.ndarray:
        """Return the sums over the points of a ``field`` times derivatives, of the orders given, of any two phi."""
        pairs = [
            (functions[i][:, :, None] * functions[j][:, None]).reshape(len(field), -1)
            for functions, i, j in zip(self.functions, test, trial, strict=True)
        ]
        count = self.basis.shape[1]
        sums = (pairs[0].T @ (field @ pairs[1])).reshape(4 * [count])
        return sums.transpose(0, 2, 1, 3).reshape(count**2, -1)

    def coefficients(self, c: np.ndarray) -> np.ndarray:
        """Return the Legendre coefficients of psi."""
        total = self.basis @ c @ self.basis.T
        half = Polynomial([0.5, 0.5])
        profile, height = (legendre.poly2leg(part(half).coef) for part in (LID, Polynomial([0.0, 0.0, -1.0, 1.0])))
        total[: len(profile), : len(height)] += self.aspect * np.outer(profile, height)
        return total

    def _lift(self, i: int, j: int) -> np.ndarray:
        """Return d^(i + j)/dx^i dy^j of the first part of psi at the points."""
        height = Polynomial([0.0, 0.0, -1.0, 1.0]).deriv(j)(self.place)
        return np.outer(LID.deriv(i)(self.place), height) * self.aspect ** (1 - j)


def clamped(order: int) -> np.ndarray:
    """Return the Legendre coefficients (order + 1, order - 3) of the functions f_k, scaled so that int f_k''^2 = 1.

    The k-th function has the parity of k.
    """
    k = np.arange(order - 3)
    scale = 1 / np.sqrt(2 * (2 * k + 3) ** 2 * (2 * k + 5))
    basis = np.zeros((order + 1, order - 3))
    basis[k, k] = scale
    basis[k + 2, k] = -scale * 2 * (2 * k + 5) / (2 * k + 7)
    basis[k + 4, k] = scale * (2 * k + 3) / (2 * k + 7)
    return basis


TABLES = Path(__file__).with_name("_cavity_tables.csv")


@dataclass(frozen=True)
class CentreLine:
    """Velocity ``value`` (n,) over U at the ``coordinate`` (n,) over the width, from ``source``.

    ``component`` u: along x, on x = 1/2, over y; v: along y, on y = 1/2, over x.
    """

    source: str
    component: str
    coordinate: np.ndarray
    value: np.ndarray


def centre_lines(reynolds: float) -> list[CentreLine]:
    """Return the tabulated centre lines at a Reynolds number; ValueError if there is none."""
    rows = _rows(reynolds)
    pairs = dict.fromkeys((row["source"], row["quantity"]) for row in rows if row["quantity"] in ("u", "v"))
    lines = []
    for source, component in pairs:
        line = [row for row in rows if (row["source"], row["quantity"]) == (source, component)]
        numbers = np.array([(row["coordinate"], row["value"]) for row in line], dtype=float)
        lines.append(CentreLine(source, component, *numbers.T))
    return lines


def extremes(reynolds: float) -> dict[str, float]:
    """Return the smallest u on x = 1/2, smallest and largest v on y = 1/2 over U: ``u_min``, ``v_min``, ``v_max``.

    At Re = 1000 also ``psi_min``, of the stream function over U width. ValueError for an untabulated Reynolds number.
    """
    rows = _rows(reynolds)
    return {row["quantity"]: float(row["value"]) for row in rows if row["quantity"] not in ("u", "v")}


def _rows(reynolds: float) -> list[dict[str, str]]:
    with TABLES.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    tabulated = sorted({float(row["reynolds"]) for row in rows})
    if reynolds not in tabulated:
        known = ", ".join(f"{number:g}" for number in tabulated)
        raise ValueError(f"the cavity is tabulated at Re = {known}, not {reynolds:g}")
    return [row for row in rows if float(row["reynolds"]) == reynolds]


@dataclass(frozen=True)
class RegularCavity:
    """Flow in 0 <= x <= ``width``, 0 <= y <= ``height`` under the regular lid, whose middle has ``speed``.

    An infinite ``kinematic_viscosity`` makes it Stokes flow. ``order``: degree of the polynomials. The solution is
    computed at first use, in seconds. ValueError if Newton's method does not converge.
    """

    width: float
    height: float
    speed: float
    kinematic_viscosity: float
    order: int = 36

    @property
    def reynolds(self) -> float:
        """speed width/kinematic viscosity."""
        return self.speed * self.width / self.kinematic_viscosity

    def lid(self, x: Any) -> np.ndarray:
        """Return the velocity of the lid at ``x``."""
        return self.speed * LID(np.asarray(x, dtype=float) / self.width)

    def stream_function(self, x: Any, y: Any) -> np.ndarray:
        """Return the stream function psi, 0 at the walls, of the broadcast shape of ``x`` and ``y``."""
        return self.speed * self.width * self._at(x, y, self._psi)

    def velocity(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocity (u, v) = (dpsi/dy, -dpsi/dx), each of the broadcast shape of ``x`` and ``y``."""
        return self.speed * self._at(x, y, self._slope(1)), -self.speed * self._at(x, y, self._slope(0))

    def vorticity(self, x: Any, y: Any) -> np.ndarray:
        """Return the vorticity dv/dx - du/dy (1/time)."""
        bends = [self._at(x, y, self._slope(axis, 2)) for axis in (0, 1)]
        return -self.speed / self.width * (bends[0] + bends[1])

    def extremes(self) -> dict[str, float]:
        """Return the numbers of the function ``extremes``, over U and U width, on the lines through the middle."""
        u = self._along_line(self._slope(1), 1)
        v = -self._along_line(self._slope(0), 0)
        return {
            "u_min": _extreme_values(u).min(),
            "v_min": _extreme_values(v).min(),
            "v_max": _extreme_values(v).max(),
            "psi_min": self._least_psi(),
        }

    @property
    def _aspect(self) -> float:
        return self.height / self.width

    @cached_property
    def _psi(self) -> np.ndarray:
        return stream_function(self.reynolds, self._aspect, self.order)

    def _slope(self, axis: int, times: int = 1) -> np.ndarray:
        """Return the coefficients of a derivative of psi along ``axis``, in units of the width."""
        return legendre.legder(self._psi, times, axis=axis) * (2 / (1.0, self._aspect)[axis]) ** times

    def _at(self, x: Any, y: Any, coefficients: np.ndarray) -> np.ndarray:
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        return legendre.legval2d(2 * x / self.width - 1, 2 * y / self.height - 1, coefficients)

    @staticmethod
    def _along_line(coefficients: np.ndarray, axis: int) -> np.ndarray:
        """Return the coefficients along ``axis`` on the line through the middle of the other axis."""
        return legendre.legval(0.0, np.moveaxis(coefficients, axis, -1))

    def _least_psi(self) -> float:
        """Return the minimum of psi by Newton's method, from the smallest value on a grid."""
        grid = np.linspace(-1.0, 1.0, 101)
        values = legendre.leggrid2d(grid, grid, self._psi)
        place: Any = grid[list(np.unravel_index(np.argmin(values), values.shape))]
        first = [legendre.legder(self._psi, axis=axis) for axis in (0, 1)]
        second = [[legendre.legder(one, axis=axis) for axis in (0, 1)] for one in first]

        def at(coefficients: np.ndarray) -> Any:
            return legendre.legval2d(place[0], place[1], coefficients)

        for _ in range(10):
            slope, bends = np.array([at(one) for one in first]), [[at(one) for one in row] for row in second]
            place = place - np.linalg.solve(bends, slope)
        return float(at(self._psi))


def _extreme_values(coefficients: np.ndarray) -> np.ndarray:
    """Return the values at the ends and where the derivative vanishes between them."""
    roots = legendre.legroots(legendre.legder(coefficients))
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1)]
    return legendre.legval(np.concatenate([inside, [-1.0, 1.0]]), coefficients)
