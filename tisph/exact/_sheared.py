"""Equations of a liquid that is sheared between two walls, on spectral elements, as ``_stiff`` wants them.

    dv/dt = g + d/dy [ flux(rate) + sum S_xy(C) ],    dC/dt = law.sheared(C, rate),    rate = dv/dy + layer

and between cylinders as in ``_elements``, v the angular velocity. The state is v at the nodes, then the components of C
of each law at the points of each element. ``layer`` is a known part of the shear rate (``_layer``). Derivatives of laws
are taken by complex steps, which are exact to rounding.

In a system (shift - J) x = b the C of each point follow from the shear rate there alone; put into the equation of v,
they leave a banded matrix of v, however many modes there are.
"""

from itertools import pairwise

import numpy as np

STEP = 1e-30
"""Complex step: no difference is taken, so that it may be as small as one likes."""

NEGLIGIBLE = 1e-12
"""Of the largest component of C: what is smaller counts as zero in the tolerance."""


class Equations:
    """Equations of ``liquid`` (``flux``, ``laws``) on ``elements``; walls are (bottom, top), with ``acceleration(t)``.

    Walls that are ``driven`` (``geometry/plate.py``) have ``stress(t)`` and ``mass_per_area`` over the density instead:
    their mass is added to that of their node, which obeys the weak form of the momentum equation as all others do.

    ``layer``: a ``_layer.Layer``. ``speed`` is what 1 of the velocity is in the tolerance, at least. ``mass`` (nodes,):
    of each node with the plate on it.
    """

    def __init__(self, elements, liquid, walls, acceleration, layer, speed):
        self.elements, self.liquid, self.layer = elements, liquid, layer
        self.walls = dict(zip((0, elements.size - 1), walls, strict=True))
        self.drive, self.speed = acceleration, speed
        self.mass = elements.mass.copy()
        for place, wall in self.walls.items():
            if wall.driven:
                self.mass[place] += wall.mass_per_area
        self.free = np.array([not (k in self.walls and not self.walls[k].driven) for k in range(elements.size)])
        points = elements.y.size
        ends = elements.size + np.cumsum([0, *(law.components * points for law in liquid.laws)])
        self.parts = [slice(a, b) for a, b in pairwise(ends.tolist())]
        self.size = int(ends[-1])

    def deviations(self, states):
        """List of C (components, ..., count, p + 1) of each law, of ``states`` (..., size)."""
        shape = (*states.shape[:-1], -1, *self.elements.y.shape)
        return [np.moveaxis(states[..., part].reshape(shape), -3, 0) for part in self.parts]

    def shear_rate(self, states, times):
        """Shear rate (times, count, p + 1)."""
        return self.elements.shear_rate(states[..., : self.elements.size]) + self.layer.shear_rates(times)

    def stress(self, deviations, rate):
        """Shear stress of solvent and laws together."""
        return self.liquid.flux(rate) + sum(
            law.stress(c)[1] for law, c in zip(self.liquid.laws, deviations, strict=True)
        )

    def rates(self, states, times):
        """dX/dt, shape of ``states`` (times, size)."""
        result = np.empty_like(states)
        whole, deviations = self.shear_rate(states, times), self.deviations(states)
        # the flux of ``layer`` through the solvent is balanced by its own inertia, but for the drift, where one is
        flux = self.stress(deviations, whole) - self.liquid.carried(self.layer.shear_rates(times))
        own = self.drive + self.layer.drift(times)
        result[:, : self.elements.size] = own + self.elements.weak_divergence(flux)
        for place, wall in self.walls.items():
            if wall.driven:
                pull = result[:, place] * self.elements.mass[place] + wall.stress(times)
                result[:, place] = pull / self.mass[place]
            else:
                result[:, place] = wall.acceleration(times)
        for law, c, part in zip(self.liquid.laws, deviations, self.parts, strict=True):
            change = np.stack([np.broadcast_to(one, whole.shape) for one in law.sheared(tuple(c), whole)], axis=1)
            result[:, part] = change.reshape(len(states), -1)
        return result

    def scales(self, states):
        """Largest magnitudes (size,) of v and of each component of C in ``states`` (stages, size)."""
        result = np.empty(self.size)
        result[: self.elements.size] = max(self.speed, np.abs(states[:, : self.elements.size]).max())
        for c, part in zip(self.deviations(states), self.parts, strict=True):
            largest = np.abs(c).reshape(len(c), -1).max(axis=1)
            floor = NEGLIGIBLE * largest.max() + 1e-200
            result[part] = np.repeat(np.maximum(largest, floor), self.elements.y.size)
        return result

    def jacobian(self, state, time):
        """Jacobian at ``state`` (size,) and ``time``; None where it is not a number."""
        rate = self.shear_rate(state[None], np.array([time]))[0]
        local = [_derivatives(law, c, rate) for law, c in zip(self.liquid.laws, self.deviations(state), strict=True)]
        flux = np.broadcast_to(np.imag(self.liquid.flux(rate + 1j * STEP)) / STEP, rate.shape)
        if not all(np.isfinite(part).all() for part in (flux, *(part for parts in local for part in parts))):
            return None
        return Jacobian(self, flux, local)


def _derivatives(law, c, rate):
    """Of one law: d(dC/dt)/dC (..., m, m), d(dC/dt)/drate (..., m) and dS_xy/dC (..., m), by complex steps."""

    def slopes(function, *arguments):
        parts = function(*arguments)
        return np.stack([np.broadcast_to(np.imag(part) / STEP, rate.shape) for part in parts], axis=-1)

    by_c, shear = [], []
    for k in range(law.components):
        moved = tuple(part + 1j * STEP * (k == j) for j, part in enumerate(c))
        by_c.append(slopes(law.sheared, moved, rate))
        shear.append(slopes(law.stress, moved)[..., 1])
    return np.stack(by_c, axis=-1), slopes(law.sheared, tuple(c), rate + 1j * STEP), np.stack(shear, axis=-1)


class Jacobian:
    """d(dX/dt)/dX; ``flux`` is d(flux)/drate (count, p + 1), ``local`` what ``_derivatives`` gives for each law."""

    def __init__(self, equations, flux, local):
        self.equations, self.elements = equations, equations.elements
        self.flux, self.local = flux, local

    def solver(self, shift):
        """A function that solves (shift - J) x = b for complex x and b (size,)."""
        from scipy.linalg.lapack import zgbtrf, zgbtrs

        elements, order = self.elements, self.elements.order
        # points' own answers: C = inverse (b_C + by_rate dv/dy), of which the shear stress takes ``pull``
        inverses = [np.linalg.inv(shift * np.eye(len(by_c[0, 0])) - by_c) for by_c, _, _ in self.local]
        pulls = [
            np.einsum("eqm,eqmn->eqn", shear, inverse)
            for (_, _, shear), inverse in zip(self.local, inverses, strict=True)
        ]
        coefficient = self.flux + sum(
            np.einsum("eqm,eqm->eq", pull, by_rate) for pull, (_, by_rate, _) in zip(pulls, self.local, strict=True)
        )
        factors, pivots, _ = zgbtrf(self._banded(shift, coefficient), order, order)

        def solve(b):
            right = b[: elements.size] * self.equations.mass
            free = self.equations.free
            points = [b[part].reshape(-1, *elements.y.shape).transpose(1, 2, 0) for part in self.equations.parts]
            if points:
                flux = sum(np.einsum("eqm,eqm->eq", pull, c) for pull, c in zip(pulls, points, strict=True))
                right = right + (elements.weak_divergence(flux) * elements.mass) * free
            v, _ = zgbtrs(factors, order, order, right.astype(complex), pivots)
            rate = elements.shear_rate(v)
            rest = [
                np.einsum("eqmn,eqn->meq", inverse, c + by_rate * rate[..., None]).ravel()
                for inverse, c, (_, by_rate, _) in zip(inverses, points, self.local, strict=True)
            ]
            return np.concatenate([v, *rest])

        return solve

    def _banded(self, shift, coefficient):
        """shift * mass + stiffness in LAPACK's banded storage; where a wall's velocity is given, that is its own."""
        elements, order = self.elements, self.elements.order
        matrices = elements.stiffness(coefficient)
        matrices[0, 0] *= self.equations.free[0]
        matrices[-1, -1] *= self.equations.free[-1]
        band = np.zeros((3 * order + 1, elements.size), dtype=complex)
        row, column = elements.nodes[:, :, None], elements.nodes[:, None, :]
        band[2 * order + row - column, column + 0 * row] = matrices
        joints = elements.nodes[1:, 0]
        band[2 * order, joints] += matrices[:-1, -1, -1]
        band[2 * order] += shift * self.equations.mass
        return band
