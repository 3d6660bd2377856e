"""Lid-driven cavity, steady: tables for the lid of one speed, and a spectral solution for the regular lid.

The lid y = height moves along x, as a whole or, ``RegularCavity``, with U 16 X^2 (1 - X)^2, X = x/width, which leaves
the corners at rest. Re = U width/nu. The other walls are at rest.

Tables, of the square cavity: C. H. Marchi, R. Suero and L. K. Araki, J. Braz. Soc. Mech. Sci. Eng. 31 (2009) 186-198
(Re = 100, 400, 1000); O. Botella and R. Peyret, Computers & Fluids 27 (1998) 421-433, tables 9 and 10 (Re = 1000); the
extremes at Re = 400 by finite elements of our own. Those of U. Ghia, K. N. Ghia and C. T. Shin (1982) are left out: off
by 3e-3 at Re = 100, and with a misprint at 400.

Accuracy of the regular lid at order 36, against order 48, in units of U: stream function 1e-9, velocity 1e-7 (2e-8 on
the centre lines) at Re = 1 and 100; 5e-9 and 4e-7 at Re = 400, against order 40.
"""

import csv
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.polynomial import legendre

from tisph.exact._cavity_galerkin import LID, stream_function

TABLES = Path(__file__).with_name("_cavity_tables.csv")


@dataclass(frozen=True)
class CentreLine:
    """Velocity ``value`` (n,) over U at the ``coordinate`` (n,) over the width, as ``source`` has it.

    ``component`` u: along x, on x = 1/2, over y; v: along y, on y = 1/2, over x.
    """

    source: str
    component: str
    coordinate: np.ndarray
    value: np.ndarray


def centre_lines(reynolds):
    """The tabulated ``CentreLine`` s at a Reynolds number; ValueError where there is none."""
    rows = _rows(reynolds)
    pairs = dict.fromkeys((row["source"], row["quantity"]) for row in rows if row["quantity"] in ("u", "v"))
    lines = []
    for source, component in pairs:
        line = [row for row in rows if (row["source"], row["quantity"]) == (source, component)]
        numbers = np.array([(row["coordinate"], row["value"]) for row in line], dtype=float)
        lines.append(CentreLine(source, component, *numbers.T))
    return lines


def extremes(reynolds):
    """Smallest u on x = 1/2, smallest and largest v on y = 1/2 over U: ``u_min``, ``v_min``, ``v_max``.

    At Re = 1000 also ``psi_min``, of the stream function over U width. ValueError for an untabulated Reynolds number.
    """
    rows = _rows(reynolds)
    return {row["quantity"]: float(row["value"]) for row in rows if row["quantity"] not in ("u", "v")}


def _rows(reynolds):
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

    ``order``: degree of the polynomials. Solved when first asked for: seconds. ValueError where that finds no flow.
    """

    width: float
    height: float
    speed: float
    kinematic_viscosity: float
    order: int = 36

    @property
    def reynolds(self):
        """speed width/kinematic viscosity."""
        return self.speed * self.width / self.kinematic_viscosity

    def lid(self, x):
        """Velocity of the lid at ``x``."""
        return self.speed * LID(np.asarray(x, dtype=float) / self.width)

    def stream_function(self, x, y):
        """Stream function psi, 0 at the walls, of the broadcast shape of ``x`` and ``y``."""
        return self.speed * self.width * self._at(x, y, self._psi)

    def velocity(self, x, y):
        """Velocity components (u, v) = (dpsi/dy, -dpsi/dx), each of the broadcast shape of ``x`` and ``y``."""
        return self.speed * self._at(x, y, self._slope(1)), -self.speed * self._at(x, y, self._slope(0))

    def vorticity(self, x, y):
        """Vorticity dv/dx - du/dy (1/time), positive where the fluid turns counterclockwise."""
        bends = [self._at(x, y, self._slope(axis, 2)) for axis in (0, 1)]
        return -self.speed / self.width * (bends[0] + bends[1])

    def extremes(self):
        """As the function ``extremes``, over U and U width, on the lines through the middle."""
        u = self._along_line(self._slope(1), 1)
        v = -self._along_line(self._slope(0), 0)
        return {
            "u_min": _extreme_values(u).min(),
            "v_min": _extreme_values(v).min(),
            "v_max": _extreme_values(v).max(),
            "psi_min": self._least_psi(),
        }

    @property
    def _aspect(self):
        return self.height / self.width

    @cached_property
    def _psi(self):
        return stream_function(self.reynolds, self._aspect, self.order)

    def _slope(self, axis, times=1):
        """Coefficients of a derivative of psi along ``axis``, in units of the width."""
        return legendre.legder(self._psi, times, axis=axis) * (2 / (1.0, self._aspect)[axis]) ** times

    def _at(self, x, y, coefficients):
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        return legendre.legval2d(2 * x / self.width - 1, 2 * y / self.height - 1, coefficients)

    @staticmethod
    def _along_line(coefficients, axis):
        """Coefficients along ``axis`` on the line through the middle of the other one."""
        return legendre.legval(0.0, np.moveaxis(coefficients, axis, -1))

    def _least_psi(self):
        """Newton's method for the place where both derivatives vanish, from the least of a grid's values."""
        grid = np.linspace(-1.0, 1.0, 101)
        values = legendre.leggrid2d(grid, grid, self._psi)
        place = grid[list(np.unravel_index(np.argmin(values), values.shape))]
        first = [legendre.legder(self._psi, axis=axis) for axis in (0, 1)]
        second = [[legendre.legder(one, axis=axis) for axis in (0, 1)] for one in first]
        for _ in range(10):
            slope = np.array([legendre.legval2d(*place, one) for one in first])
            place = place - np.linalg.solve([[legendre.legval2d(*place, one) for one in row] for row in second], slope)
        return float(legendre.legval2d(*place, self._psi))


def _extreme_values(coefficients):
    """Return the values at the ends and where the derivative vanishes between them."""
    roots = legendre.legroots(legendre.legder(coefficients))
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1)]
    return legendre.legval(np.concatenate([inside, [-1.0, 1.0]]), coefficients)
