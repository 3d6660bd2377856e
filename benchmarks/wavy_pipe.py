"""Steady flow through a periodic pipe with a wavy wall, by a spectral method: reference values of the tests.

The pipe has the radius R(x) = 1 - depth (1 - cos(2 pi x/length))/2. With q = r^2 Stokes' stream function is q phi:

    u = 2 (phi + q phi_q),   v/r = -phi_x,   vorticity/r = zeta = -M phi,   M = d_xx + 4 q d_qq + 8 d_q,

and the flow of a given volume rate Q obeys, without any boundary condition at the axis,

    2 (phi + q phi_q) zeta_x - 2 q phi_x zeta_q = nu M zeta,   phi = Q/(2 pi R^2) and phi + q phi_q = 0 at the wall.

Along the axis the momentum equation is -dp/dx/rho = u u_x - nu (u_xx + 16 phi_q), with the mean: acceleration = -16 nu
mean(phi_q). Fourier points in x, Chebyshev points in q/R^2, Newton's method with the whole matrix.

    python benchmarks/wavy_pipe.py

prints the acceleration, -(mean pressure gradient)/density, at two resolutions for mean velocities through the full
radius of 1, viscosities of 2/Re, so that Re is by the diameter there; and pressure drops of a
straight pipe with one wave, along the axis.
"""

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev

LENGTH, DEPTH = 3.0, 0.4
REYNOLDS = 0.0, 10.0, 30.0, 100.0
OPEN = {10.0: (6.0, 12.0, (121, 161)), 30.0: (8.0, 24.0, (241, 281)), 100.0: (8.0, 24.0, (241, 281))}
"""By Reynolds number: length of a pipe with open ends and one wave, period of a pipe in which the flow develops again
behind the wave, and coarse and fine numbers of points along that, with 13 and 15 across."""


def chebyshev_points(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points s (count,) from 0 to 1, and the matrix of derivatives at them."""
    s = 0.5 - 0.5 * np.cos(np.pi * np.arange(count) / (count - 1))
    values = chebyshev.chebvander(2.0 * s - 1.0, count - 1)
    slopes = np.stack([2.0 * chebyshev.chebval(2.0 * s - 1.0, chebyshev.chebder(row)) for row in np.eye(count)], axis=1)
    return s, slopes @ np.linalg.inv(values)


def fourier_points(count: int, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (count,) over a ``period``, an odd number of them, and the matrix of derivatives at them."""
    k = np.arange(count)
    apart = k[:, None] - k
    with np.errstate(divide="ignore"):
        matrix = 0.5 * (-1.0) ** apart / np.sin(np.pi * apart / count)
    matrix[k, k] = 0.0
    return period * k / count, 2.0 * np.pi / period * matrix


def wave(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the radius of the wavy pipe at ``x``, and its slope."""
    phase = 2.0 * np.pi * x / LENGTH
    return 1.0 - 0.5 * DEPTH * (1.0 - np.cos(phase)), -np.pi * DEPTH / LENGTH * np.sin(phase)


def constriction(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the radius of a straight pipe with one wave from x = 1 to 3, and its slope."""
    phase, there = np.pi * (x - 2.0), np.abs(x - 2.0) < 1.0
    return 1.0 - 0.5 * DEPTH * there * (1.0 + np.cos(phase)), 0.5 * np.pi * DEPTH * there * np.sin(phase)


def along_axis(
    reynolds: float, columns: int, rows: int, length: float = LENGTH, wall: Callable = wave
) -> tuple[float, np.ndarray, np.ndarray]:
    """Return nu, and u and phi_q (columns,) along the axis, for Q = pi and nu = 2/``reynolds``.

    For a Reynolds number of 0 nu is 1, without inertia.
    """
    (x, d_x), (s, d_s) = fourier_points(columns, length), chebyshev_points(rows)
    radius, slope = wall(x)
    squares = np.repeat(radius**2, rows)
    height = np.tile(s, columns)
    q = squares * height
    along = np.kron(np.eye(columns), d_s)
    by_q = along / squares[:, None]
    by_x = np.kron(d_x, np.eye(rows)) - (np.repeat(2.0 * slope / radius, rows) * height)[:, None] * along
    laplacian = by_x @ by_x + q[:, None] * 4.0 * (by_q @ by_q) + 8.0 * by_q
    stretched = 2.0 * (np.eye(len(q)) + q[:, None] * by_q)
    viscosity, inertia = (2.0 / reynolds, 1.0) if reynolds else (1.0, 0.0)
    wall = np.arange(rows - 1, len(q), rows)
    linear = viscosity * laplacian @ laplacian
    linear[wall], linear[wall - 1] = np.eye(len(q))[wall], 0.5 * stretched[wall]
    right = np.zeros(len(q))
    right[wall] = 0.5 / radius**2
    phi = np.linalg.solve(linear, right)
    for _ in range(20 if inertia else 0):
        zeta, u, across = -laplacian @ phi, stretched @ phi, -2.0 * q * (by_x @ phi)
        convective = u * (by_x @ zeta) + across * (by_q @ zeta)
        change = (by_x @ zeta)[:, None] * stretched - 2.0 * (q * (by_q @ zeta))[:, None] * by_x
        change -= (u[:, None] * by_x + across[:, None] * by_q) @ laplacian
        residual, matrix = linear @ phi - right, linear.copy()
        inner = np.ones(len(q), bool)
        inner[wall] = inner[wall - 1] = False
        # nu M zeta is -linear phi
        residual[inner] += convective[inner]
        matrix[inner] += change[inner]
        step = np.linalg.solve(matrix, residual)
        phi = phi - step
        if np.abs(step).max() < 1e-9:
            break
    return viscosity, (stretched @ phi)[::rows], (by_q @ phi)[::rows]


def acceleration(reynolds: float, columns: int, rows: int, length: float = LENGTH, wall: Callable = wave) -> float:
    """Return the acceleration along the axis; arguments as for ``along_axis``."""
    viscosity, _, slope = along_axis(reynolds, columns, rows, length, wall)
    return float(-16.0 * viscosity * np.mean(slope))


def pressure_drop(reynolds: float, columns: int, rows: int, length: float, period: float) -> float:
    """Return the pressure drop over density along the axis of a pipe with one wave, from x = 0 to ``length``."""
    viscosity, u, slope = along_axis(reynolds, columns, rows, period, constriction)
    d_x = fourier_points(columns, period)[1]
    modes = np.fft.rfft(-16.0 * viscosity * slope) / columns
    k = 2j * np.pi / period * np.arange(1, len(modes))
    drag = modes[0].real * length + 2.0 * np.sum(modes[1:] * np.expm1(k * length) / k).real

    def at(values: np.ndarray, x: float) -> float:
        parts = np.fft.rfft(values) / columns
        return float(parts[0].real + 2.0 * np.sum(parts[1:] * np.exp(k * x)).real)

    ends = [0.5 * at(u, x) ** 2 - viscosity * at(d_x @ u, x) for x in (0.0, length)]
    return drag + ends[1] - ends[0]


def main() -> None:
    """Print the table."""
    print(f"R = 1 - {0.5 * DEPTH:g} (1 - cos(2 pi x/{LENGTH:g})), Q = pi, nu = 2/Re (1 without inertia, Re 0)")
    print(f"{'Re':>6} {'31 x 15':>12} {'41 x 21':>12} {'difference':>11}")
    for reynolds in REYNOLDS:
        coarse, fine = acceleration(reynolds, 31, 15), acceleration(reynolds, 41, 21)
        print(f"{reynolds:6g} {coarse:12.7f} {fine:12.7f} {abs(coarse / fine - 1.0):11.1e}")
    print("straight pipe with one wave from x = 1 to 3: pressure drop from x = 0 to the length")
    print(f"{'Re':>6} {'length':>7} {'period':>7} {'coarse':>12} {'fine':>12}")
    for reynolds, (length, period, points) in OPEN.items():
        drops = [
            pressure_drop(reynolds, count, rows, length, period) for count, rows in zip(points, (13, 15), strict=True)
        ]
        print(f"{reynolds:6g} {length:7g} {period:7g} {drops[0]:12.4f} {drops[1]:12.4f}")


if __name__ == "__main__":
    main()
