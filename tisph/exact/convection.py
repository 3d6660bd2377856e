"""Natural convection: onset and saturated rolls in a layer heated from below, and a cavity with a hot and a cold wall.

Boussinesq's equations in units of a length H, of H^2/kappa and of the temperature difference dT, gravity along -y, with
Ra = g beta dT H^3/(nu kappa) and Pr = nu/kappa:

    (1/Pr) Du/Dt = -grad p + lap u + Ra T e_y,    DT/Dt = lap T,    div u = 0

* ``growth_rate``, ``marginal_rayleigh``, ``critical``: linear theory of the layer 0 <= y <= 1 between plates of given
  temperatures with slip lengths, disturbances v(y) cos kx. With functions v and T = h(y) cos kx that are 0 at the
  plates, v' = 0 without slip, and test functions w and e, s is the eigenvalue of

    (s/Pr) int (v' w' + k^2 v w) = -int [(v'' + k^2 v)(w'' + k^2 w) + 4 k^2 v' w'] - sum v' w'/b + Ra k^2 int h w
    s int h e = -int (h' e' + k^2 h e) + int v e

  The sum is over the plates; v'/k is the velocity along a plate and b its slip length.
* ``Rolls``: the steady rolls at finite amplitude, and ``HeatedCavity``: a box with a hot wall x = 0, a cold wall
  x = width, and insulated walls below and above. With u = psi_y, v = -psi_x, for all functions phi and e:

    int lap psi lap phi + (1/Pr) lap psi (psi_y phi_x - psi_x phi_y) + Ra T phi_x = 0
    int grad T . grad e + (psi_y T_x - psi_x T_y) e = 0

  psi and T are sums of products of functions of x and of y: Legendre polynomials, or sines and cosines along the rolls,
  whose sides are mirrors. They keep their signs, or change them, at a turn of the box by 180 degrees about its middle.
  Newton's method solves for the coefficients.

Accuracy: linear theory 1e-10; rolls 1e-9 up to Ra = 5000. Cavity up to Ra = 1e5: Nu 1e-9, velocity 1e-8, and local Nu
5e-6, because of the corners; at Ra = 1e6 1e-8, 1e-6 and 2e-4. Each takes a second or two.

Sources: S. Chandrasekhar, Hydrodynamic and Hydromagnetic Stability (1961), chapter II; G. de Vahl Davis, Int. J. Numer.
Meth. Fluids 3 (1983) 249-264, for the cavity; J. Shen, SIAM J. Sci. Comput. 15 (1994) 1489-1505, for the functions.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from tisph.exact.cavity import clamped

LINEAR_DEGREE = 24
"""Degree of the polynomials of linear theory."""

COARSE = 20
"""Order whose solution Newton's method starts from at a higher one."""

FIRST_RAYLEIGH, GROWTH = 1e4, 4.0
"""Newton's method starts from the cavity at rest; above the first Ra it continues in steps of this factor."""

START = 12.0
"""Largest v of rolls that Newton's method starts from, over kappa/H and the root of the excess of Ra."""

NEWTON_STEPS = 25
TOLERANCE = 1e-9
"""Last step of Newton's method over the largest coefficient; the error is about its square."""


def growth_rate(
    wavenumber: float, rayleigh: float, prandtl: float, slip_lengths: tuple[float, float] = (0.0, 0.0)
) -> float:
    """Return s H^2/kappa of the disturbance that grows fastest; ``wavenumber`` k H.

    ``slip_lengths`` b/H of the plates (below, above). s is real at all Ra > 0.
    """
    from scipy.linalg import block_diag, eigvals

    inertia, friction, lift, mass, conduction = _linear(wavenumber, slip_lengths)
    left = np.block([[-friction, rayleigh * wavenumber**2 * lift], [lift.T, -conduction]])
    return float(eigvals(left, block_diag(inertia / prandtl, mass)).real.max())


def marginal_rayleigh(wavenumber: float, slip_lengths: tuple[float, float] = (0.0, 0.0)) -> float:
    """Return the Ra at which a disturbance neither grows nor decays, whatever Pr; arguments as of ``growth_rate``."""
    from scipy.linalg import eigh

    _, friction, lift, _, conduction = _linear(wavenumber, slip_lengths)
    drive = wavenumber**2 * lift @ np.linalg.solve(conduction, lift.T)
    return float(1 / eigh(drive, friction, eigvals_only=True)[-1])


def critical(slip_lengths: tuple[float, float] = (0.0, 0.0)) -> tuple[float, float]:
    """Return the least Ra at which any disturbance grows, and its wavenumber k H."""
    from scipy.optimize import brentq

    def slope(k: float) -> float:
        values = [marginal_rayleigh(k + 0.01 * step, slip_lengths) for step in (-2, -1, 1, 2)]
        return float(np.dot((1, -8, 8, -1), values))  # a difference of fourth order

    k = brentq(slope, 1.0, 5.0, xtol=1e-10)
    return marginal_rayleigh(k, slip_lengths), k


def _linear(k: float, slip_lengths: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """Return the matrices of inertia, friction, buoyancy over Ra k^2, heat capacity and conduction."""
    from scipy.linalg import null_space

    ends = np.array([0.0, 1.0])
    unit = _Polynomials(np.eye(LINEAR_DEGREE + 1), 1.0)
    held = unit.at(ends)
    stuck = [unit.at(ends, 1)[[end]] for end, slip in enumerate(slip_lengths) if slip == 0.0]
    flow = _Polynomials(null_space(np.vstack([held, *stuck])), 1.0)
    heat = _Polynomials(null_space(held), 1.0)
    y, weight = _gauss(LINEAR_DEGREE + 2, 1.0)
    (v, slope, bend), (h, gradient) = ([part.at(y, n) for n in range(3 - (part is heat))] for part in (flow, heat))

    def integral(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return (one.T * weight) @ other

    friction = integral(bend + k**2 * v, bend + k**2 * v) + 4 * k**2 * integral(slope, slope)
    for end, slip in zip(ends, slip_lengths, strict=True):
        if slip != 0.0:
            along = flow.at(np.array([end]), 1)
            friction += along.T @ along / slip
    inertia = integral(slope, slope) + k**2 * integral(v, v)
    return inertia, friction, integral(v, h), integral(h, h), integral(gradient, gradient) + k**2 * integral(h, h)


def _gauss(count: int, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss's points and weights on [0, length]."""
    node, weight = legendre.leggauss(count)
    return length * (node + 1) / 2, length * weight / 2


@dataclass(frozen=True)
class _Polynomials:
    """Functions on [0, length] with Legendre ``coefficients`` (degrees, functions)."""

    coefficients: np.ndarray
    length: float

    def at(self, x: np.ndarray, order: int = 0) -> np.ndarray:
        """Return the derivatives of an ``order`` (points, functions) at ``x`` (points,)."""
        series = legendre.legder(self.coefficients, order)
        return legendre.legvander(2 * x / self.length - 1, len(series) - 1) @ series * (2 / self.length) ** order


@dataclass(frozen=True)
class _Waves:
    """The sines sin(m pi x/length), m = 1 to ``count``, or, if ``even``, the cosines, m = 0 to ``count`` - 1."""

    count: int
    length: float
    even: bool

    def at(self, x: np.ndarray, order: int = 0) -> np.ndarray:
        """Return the derivatives of an ``order`` (points, functions) at ``x`` (points,)."""
        k = (np.arange(self.count) + (not self.even)) * np.pi / self.length
        return k**order * np.sin(k * x[:, None] + (order + self.even) * np.pi / 2)


def _held(order: int) -> np.ndarray:
    """Return coefficients (order + 1, order - 1) of functions that are 0 at both ends; the n-th has the parity of n."""
    n = np.arange(order - 1)
    result = np.zeros((order + 1, order - 1))
    result[n, n], result[n + 2, n] = 1.0, -1.0
    return result / np.sqrt(4 * n + 6)  # derivatives of norm 1


def _free(order: int) -> np.ndarray:
    """Return coefficients of the Legendre polynomials up to an ``order``, scaled to similar derivatives."""
    return np.diag(1 / np.sqrt(1.0 + np.arange(order + 1.0) ** 3))


X, Y, VALUE = (1, 0), (0, 1), (0, 0)
"""Orders of derivatives along x and y."""


class _Convection:
    """Weak form in a box of ``sizes`` with ``functions`` of x and of y for psi, and for T minus its conducting state.

    ``gradient`` of the conducting state, (d/dx, d/dy), along which the walls are held.
    """

    def __init__(self, functions: tuple, gradient: tuple[float, float], sizes: tuple[float, float]) -> None:
        self.functions, self.gradient = functions, gradient
        self.tables: list[list] = []
        # twice the functions along x: enough for their products, and for waves, whose points must be pi/2 times denser
        count = 2 * max(one.at(np.zeros(1)).shape[1] for pair in functions for one in pair) + 10
        places, weights = zip(*(_gauss(count, size) for size in sizes), strict=True)
        self.weight, self.area = np.outer(*weights), sizes[0] * sizes[1]
        for pair in functions:
            self.tables.append([[one.at(x, n) for n in range(3)] for one, x in zip(pair, places, strict=True)])
        self.shapes = [tuple(table[0].shape[1] for table in pair) for pair in self.tables]
        self.first = int(np.prod(self.shapes[0]))
        odd = [np.add.outer(*map(np.arange, shape)).ravel() % 2 == 1 for shape in self.shapes]
        self.kept = np.flatnonzero(np.concatenate([~odd[0], odd[1]]))
        laplacian = (2, 0), (0, 2)
        self.viscous = sum(self._products(self.weight, 0, test, 0, trial) for test in laplacian for trial in laplacian)
        self.conduction = sum(self._products(self.weight, 1, one, 1, one) for one in (X, Y))
        self.buoyancy = self._products(self.weight, 0, X, 1, VALUE)
        self.of_conducting = self._tested(self._conducting(places), 0, X)

    def _conducting(self, places: tuple) -> np.ndarray:
        """Return the temperature of the conducting state at the points, up to a constant."""
        return self.gradient[0] * places[0][:, None] + self.gradient[1] * places[1][None, :]

    def embedded(self, other: "_Convection", c: np.ndarray) -> np.ndarray:
        """Return the coefficients here of the fields that have the coefficients ``c`` in ``other``, of lower orders."""
        result = [np.zeros(shape) for shape in self.shapes]
        for part, whole in zip(other.split(c), result, strict=True):
            whole[: part.shape[0], : part.shape[1]] = part
        return np.concatenate([part.ravel() for part in result])

    def split(self, c: np.ndarray) -> list[np.ndarray]:
        """Return the coefficients of psi and of T as matrices (functions of x, functions of y)."""
        return [part.reshape(shape) for part, shape in zip(np.split(c, [self.first]), self.shapes, strict=True)]

    def linearised(self, c: np.ndarray, rayleigh: float, prandtl: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the Jacobian of the equations at the coefficients ``c`` and their residuals, of kept functions."""
        psi, temperature = self.split(c)
        x, y = self._field(psi, 0, X), self._field(psi, 0, Y)
        lap = (self._field(psi, 0, (2, 0)) + self._field(psi, 0, (0, 2))) / prandtl
        across, up = (self._field(temperature, 1, one) + part for one, part in zip((X, Y), self.gradient, strict=True))
        flow = self.viscous @ c[: self.first] + self._tested(lap * y, 0, X) - self._tested(lap * x, 0, Y)
        flow += rayleigh * (self.buoyancy @ c[self.first :] + self.of_conducting)
        heat = self.conduction @ c[self.first :] + self._tested(y * across - x * up, 1, VALUE)
        x, y, lap, across, up = (self.weight * part for part in (x, y, lap, across, up))
        inertia = self._products(lap, 0, X, 0, Y) - self._products(lap, 0, Y, 0, X)
        for trial in ((2, 0), (0, 2)):
            inertia += (self._products(y, 0, X, 0, trial) - self._products(x, 0, Y, 0, trial)) / prandtl
        carried = self._products(y, 1, VALUE, 1, X) - self._products(x, 1, VALUE, 1, Y)
        moved = self._products(across, 1, VALUE, 0, Y) - self._products(up, 1, VALUE, 0, X)
        jacobian = np.block([[self.viscous + inertia, rayleigh * self.buoyancy], [moved, self.conduction + carried]])
        return jacobian[np.ix_(self.kept, self.kept)], np.concatenate([flow, heat])[self.kept]

    def solved(self, c: np.ndarray, rayleigh: float, prandtl: float) -> np.ndarray:
        """Return the coefficients that Newton's method reaches from ``c``. ValueError if it does not converge."""
        c = c.copy()
        for _ in range(NEWTON_STEPS):
            step = np.linalg.solve(*self.linearised(c, rayleigh, prandtl))
            c[self.kept] -= step
            if np.abs(step).max() <= TOLERANCE * np.abs(c).max():
                return c
        raise ValueError(f"no steady convection was found at Ra = {rayleigh:g}: take a higher order, or a smaller Ra")

    def heated(self, c: np.ndarray) -> np.ndarray:
        """Return ``c`` with the temperature that its flow carries and conducts."""
        c = c.copy()
        kept = self.kept >= self.first
        jacobian, residual = self.linearised(c, 0.0, 1.0)
        c[self.kept[kept]] -= np.linalg.solve(jacobian[np.ix_(kept, kept)], residual[kept])
        return c

    def at(self, c: np.ndarray, part: int, x: Any, y: Any, order: tuple[int, int] = VALUE) -> np.ndarray:
        """Return a derivative of psi, ``part`` 0, or of T minus its conducting state, 1, at ``x`` and ``y``."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        first, second = (
            one.at(place.ravel(), n) for one, place, n in zip(self.functions[part], (x, y), order, strict=True)
        )
        return np.sum(first @ self.split(c)[part] * second, axis=1).reshape(x.shape)[()]

    def nusselt(self, c: np.ndarray) -> float:
        """Return the mean heat flux against ``gradient`` over the conducted heat flux, by velocity times T."""
        psi, temperature = self.split(c)
        along = self.gradient[0] * self._field(psi, 0, Y) - self.gradient[1] * self._field(psi, 0, X)
        return 1.0 - float(np.sum(self.weight * along * self._field(temperature, 1, VALUE))) / self.area

    def _field(self, c: np.ndarray, part: int, order: tuple[int, int]) -> np.ndarray:
        """Return a derivative at the points of the sum with coefficients ``c`` of functions of a ``part``."""
        first, second = (table[n] for table, n in zip(self.tables[part], order, strict=True))
        return first @ c @ second.T

    def _tested(self, field: np.ndarray, part: int, order: tuple[int, int]) -> np.ndarray:
        """Return the integrals of a ``field`` times a derivative of each function of a ``part``."""
        first, second = (table[n] for table, n in zip(self.tables[part], order, strict=True))
        return (first.T @ (self.weight * field) @ second).ravel()

    def _products(self, field: np.ndarray, part: int, test: Any, other: int, trial: Any) -> np.ndarray:
        """Return the sums over the points of a ``field`` times derivatives of any functions of a part and another."""
        pairs, shape = [], []
        for axis in (0, 1):
            one, two = self.tables[part][axis][test[axis]], self.tables[other][axis][trial[axis]]
            pairs.append((one[:, :, None] * two[:, None]).reshape(len(one), -1))
            shape += [one.shape[1], two.shape[1]]
        sums = (pairs[0].T @ (field @ pairs[1])).reshape(shape)
        return sums.transpose(0, 2, 1, 3).reshape(shape[0] * shape[2], -1)


def _largest(function: Callable, length: float, sign: float = 1.0) -> tuple[float, float]:
    """Return the largest value of ``function`` on [0, length], or the smallest, with ``sign`` -1, and its place."""
    from scipy.optimize import minimize_scalar

    grid = np.linspace(0.0, length, 201)
    near = grid[np.argmax(sign * function(grid))]
    bounds = max(near - grid[1], 0.0), min(near + grid[1], length)
    found = minimize_scalar(
        lambda place: -sign * float(function(place)), bounds=bounds, method="bounded", options={"xatol": 1e-10}
    )
    return -sign * float(found.fun), float(found.x)


@dataclass(frozen=True)
class Rolls:
    """Steady rolls along z in a layer 0 <= y <= ``height`` without slip, hot below; the fluid rises at x = 0.

    Ra and Pr with H = height; ``wavenumber`` k of the period 2 pi/k; ``diffusivity`` kappa; ``temperatures`` of the
    plates (below, above). ``order``: degree of the polynomials of y, twice the number of waves along x. Computed at
    first use. ValueError if Ra is too small for rolls of this k, or if Newton's method does not converge.
    """

    rayleigh: float
    prandtl: float
    wavenumber: float
    height: float = 1.0
    diffusivity: float = 1.0
    temperatures: tuple[float, float] = (0.5, -0.5)
    order: int = 28

    def velocity(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocity (u, v)."""
        return _velocity(self._solution, x, y, self.height, self.diffusivity)

    def temperature(self, x: Any, y: Any) -> np.ndarray:
        """Return the temperature T."""
        return _temperature(self._solution, x, y, self.height, self.temperatures)

    @property
    def nusselt(self) -> float:
        """Heat flux over the heat flux of the layer at rest."""
        form, c = self._solution
        return form.nusselt(c)

    @property
    def largest_velocity(self) -> float:
        """Largest v on the line x = 0."""
        return _largest(lambda y: self.velocity(0.0, y)[1], self.height)[0]

    def _form(self, order: int) -> _Convection:
        length, waves = np.pi / (self.wavenumber * self.height), max(order // 2, 2)
        flow = _Waves(waves, length, even=False), _Polynomials(clamped(order), 1.0)
        heat = _Waves(waves, length, even=True), _Polynomials(_held(order), 1.0)
        return _Convection((flow, heat), (0.0, -1.0), (length, 1.0))

    @cached_property
    def _solution(self) -> tuple[_Convection, np.ndarray]:
        k = self.wavenumber * self.height
        least = marginal_rayleigh(k)
        if self.rayleigh <= least:
            raise ValueError(
                f"rolls of this wavenumber need a Rayleigh number above {least:.8g}, not {self.rayleigh:g}"
            )
        form = self._form(COARSE)
        c = np.zeros(form.first + int(np.prod(form.shapes[1])))
        middle = form.functions[0][1].at(np.array([0.5]))[0, 0]
        c[0] = -START * np.sqrt(self.rayleigh / least - 1.0) / (k * middle)
        c = form.solved(form.heated(c), self.rayleigh, self.prandtl)
        fine = self._form(self.order)
        return fine, fine.solved(fine.embedded(form, c), self.rayleigh, self.prandtl)


@dataclass(frozen=True)
class HeatedCavity:
    """Steady convection in 0 <= x <= ``width``, 0 <= y <= ``height`` between a hot wall x = 0 and a cold one x = width.

    The other walls are insulated; no slip. ``temperatures`` (hot, cold); Ra and Pr with H = width; ``diffusivity``
    kappa; ``order``: degree of the polynomials. Computed at first use, in seconds. ValueError if Newton's method does
    not converge.
    """

    rayleigh: float
    prandtl: float
    width: float = 1.0
    height: float = 1.0
    diffusivity: float = 1.0
    temperatures: tuple[float, float] = (0.5, -0.5)
    order: int = 40

    def velocity(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocity (u, v)."""
        return _velocity(self._solution, x, y, self.width, self.diffusivity)

    def stream_function(self, x: Any, y: Any) -> np.ndarray:
        """Return the stream function psi, 0 at the walls, with u = psi_y and v = -psi_x."""
        form, c = self._solution
        return self.diffusivity * form.at(c, 0, np.asarray(x) / self.width, np.asarray(y) / self.width)

    def temperature(self, x: Any, y: Any) -> np.ndarray:
        """Return the temperature T."""
        return _temperature(self._solution, x, y, self.width, self.temperatures)

    @property
    def nusselt(self) -> float:
        """Mean heat flux from wall to wall over the heat flux of the fluid at rest."""
        form, c = self._solution
        return form.nusselt(c)

    def local_nusselt(self, y: Any) -> np.ndarray:
        """Return the heat flux of the hot wall over the heat flux of the fluid at rest."""
        form, c = self._solution
        return 1.0 - form.at(c, 1, 0.0, np.asarray(y) / self.width, X)

    def extremes(self) -> dict[str, float]:
        """Return the largest u on x = width/2 and v on y = height/2, and largest and smallest local Nu, with places."""
        found = {
            "u_max": _largest(lambda y: self.velocity(self.width / 2, y)[0], self.height),
            "v_max": _largest(lambda x: self.velocity(x, self.height / 2)[1], self.width),
            "nusselt_max": _largest(self.local_nusselt, self.height),
            "nusselt_min": _largest(self.local_nusselt, self.height, sign=-1.0),
        }
        places = dict(zip(found, ("y_u_max", "x_v_max", "y_nusselt_max", "y_nusselt_min"), strict=True))
        return {name: value for name, (value, _) in found.items()} | {
            places[name]: at for name, (_, at) in found.items()
        }

    def _form(self, order: int) -> _Convection:
        sizes = 1.0, self.height / self.width
        flow = tuple(_Polynomials(clamped(order), size) for size in sizes)
        heat = _Polynomials(_held(order), 1.0), _Polynomials(_free(order), sizes[1])
        return _Convection((flow, heat), (-1.0, 0.0), sizes)

    @cached_property
    def _solution(self) -> tuple[_Convection, np.ndarray]:
        form, stages = self._form(min(COARSE, self.order)), [self.rayleigh]
        while stages[-1] > FIRST_RAYLEIGH:
            stages.append(stages[-1] / GROWTH)
        c = np.zeros(form.first + int(np.prod(form.shapes[1])))
        for stage in reversed(stages):
            c = form.solved(c, stage, self.prandtl)
        fine = self._form(self.order)
        return fine, fine.solved(fine.embedded(form, c), self.rayleigh, self.prandtl)


def _velocity(solution: Any, x: Any, y: Any, length: float, diffusivity: float) -> tuple[np.ndarray, np.ndarray]:
    form, c = solution
    place, unit = (np.asarray(x) / length, np.asarray(y) / length), diffusivity / length
    return unit * form.at(c, 0, *place, Y), -unit * form.at(c, 0, *place, X)


def _temperature(solution: Any, x: Any, y: Any, length: float, temperatures: tuple[float, float]) -> np.ndarray:
    form, c = solution
    hot, cold = temperatures
    place = np.asarray(x) / length, np.asarray(y) / length
    share = 1 + form.gradient[0] * place[0] + form.gradient[1] * place[1] + form.at(c, 1, *place)
    return cold + (hot - cold) * share
