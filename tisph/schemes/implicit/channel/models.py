"""Response of the extra stress of a non-Newtonian fluid to the shear rate in an implicit stage.

Of a conformation tensor A a particle carries w - 1, A_xy, A_yy - 1 and, where the law has it, A_zz - 1, with

    w = A_xx - t^2 A_yy,    t = A_xy / A_yy,    w' = (1, -t) R (1, -t)^T,    R the relaxation part of dA/dt.         (9)

A shear does not change w, and A is positive definite as long as w and A_yy are positive, however large A_xx is. An A_xx
that is carried itself would have to be accurate to 1 in A_xy^2 for that. w is the square of a Cholesky factor of A
(N. Vaithianathan and L. R. Collins, J. Comput. Phys. 187 (2003) 1-21). In a parallel flow these states C follow
dC/dt = F(C, u_y), point by point. A stage of the time integration asks for C = K + g F(C, u_y) with known K. Newton's
method solves this for C at a given u_y and also gives the tangent dS_xy/du_y, with which the momentum equation is
linearised.

An inelastic fluid has no states. Its stress beyond the constant viscosity nu in ``fluid`` takes the place of a
polymer's, S_xy = (viscosity(u_y^2) - nu) u_y, so that the systems are solvable where the viscosity varies by orders of
magnitude.
"""

from functools import partial
from typing import Any

import numpy as np

from tisph.scenes._channel import Channel
from tisph.schemes._local_newton import SMALL, Modes, eliminate, matrix, solve


class ViscoelasticModel(Modes):
    """Response of a viscoelastic fluid; its states C (components, n) are the states of all modes, one after another.

    Stresses are per unit density.
    """

    def __init__(self, rheology: Any, kinematic_viscosity: float) -> None:
        super().__init__(rheology, kinematic_viscosity, conformation_excess)

    def initial(self, channel: Channel, heights: np.ndarray) -> np.ndarray:
        """Return C at ``heights`` of a channel when the run starts."""
        modes = channel.initial_conformation_excess(heights)
        states = [[xx - xy * xy / (1.0 + others[0]), xy, *others] for xx, xy, *others in modes]
        return np.concatenate([np.stack(state) for state in states])

    def shear_stress(self, state: np.ndarray, shear_rate: Any) -> Any:
        """Return S_xy, which does not depend on the instantaneous ``shear_rate``."""
        return sum(_shear_stress(law, state[part]) for law, part in self)

    def apply_shear(self, state: np.ndarray, strain: np.ndarray) -> None:
        """Shear the states at once by ``strain``, A to F A F^T."""
        for part in self.parts:
            state[part][1] += strain * (1.0 + state[part][2])

    def rate(self, state: np.ndarray, shear_rate: np.ndarray) -> np.ndarray:
        """Return dC/dt of particles in simple shear."""
        each = [_rate(law, shear_rate, state[part]) for law, part in self]
        return np.concatenate([np.stack(rate) for rate in each])

    def update(
        self, known: np.ndarray, gamma_dt: float, shear_rate: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, Any]:
        """Solve C = ``known`` + ``gamma_dt`` F(C, ``shear_rate``) from a ``guess``; return C and dS_xy/d shear_rate."""
        state, tangent = np.empty_like(known), 0.0
        for law, part in self:
            rate = partial(_rate, law, shear_rate)
            state[part], jacobian = solve(rate, known[part], gamma_dt, guess[part])
            stretching = np.zeros_like(state[part])
            stretching[1] = 1.0 + state[part][2]
            tangent = tangent + _derivative(law, state[part], eliminate(jacobian, gamma_dt * stretching))
        return state, tangent

    def linear(self, state: np.ndarray, gamma_dt: float, shear_rate: np.ndarray, defect: np.ndarray) -> Any:
        """Return dS_xy/dC . (1 - gamma_dt F_C)^-1 ``defect`` (n,), linearised about ``state``."""
        total = 0.0
        for law, part in self:
            jacobian = matrix(partial(_rate, law, shear_rate), state[part], gamma_dt)
            total = total + _derivative(law, state[part], eliminate(jacobian, defect[part]))
        return total

    def jacobian(self, state: np.ndarray, shear_rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Return F_C (components, components), F_u' and dS_xy/dC (components,) at one point with this ``state``.

        The last number is the derivative of S_xy by the instantaneous shear rate, 0.
        """
        size = self.components
        decay, stretching, stress = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        for law, part in self:
            unity = np.eye(part.stop - part.start)
            ahead = state[part][:, None] + 1j * SMALL * unity
            decay[part, part] = np.imag(np.stack(_rate(law, shear_rate, ahead))) / SMALL
            stress[part] = np.imag(_shear_stress(law, ahead)) / SMALL
            stretching[part][1] = 1.0 + state[part][2]
        return decay, stretching, stress, 0.0

    def by_factor(self, state: np.ndarray, shear_rate: float) -> tuple[np.ndarray, float]:
        """Return the derivatives of F and S_xy by a factor of viscosities, which there is none of."""
        return np.zeros(self.components), 0.0

    def indefinite(self, state: np.ndarray) -> np.ndarray:
        """Return the indices of particles whose conformation tensor is not positive definite."""
        found = np.zeros(state.shape[1], dtype=bool)
        for part in self.parts:
            first, _, *others = state[part]
            found |= ~(np.min([first, *others], axis=0) > -1.0)
        return np.flatnonzero(found)


class NewtonianModel:
    """A Newtonian fluid: no extra stress, and states (0, n)."""

    components = 0

    def initial(self, channel: Channel, heights: np.ndarray) -> np.ndarray:
        """Return the states at ``heights``, (0, n)."""
        return np.zeros((0, np.size(heights)))

    def stress(self, state: np.ndarray) -> Any:
        """Return no stress: it does not follow from states."""
        return ()

    def indefinite(self, state: np.ndarray) -> np.ndarray:
        """Return no particles: there is no conformation tensor."""
        return np.zeros(0, dtype=int)


class InelasticModel(NewtonianModel):
    """Response of a fluid whose viscosity depends on the shear rate: as ``ViscoelasticModel``, without states."""

    def __init__(self, law: Any, kinematic_viscosity: float) -> None:
        self.law, self.constant = law, kinematic_viscosity

    def shear_stress(self, state: Any, shear_rate: Any) -> Any:
        """Return S_xy."""
        return (self.law.viscosity(shear_rate * shear_rate) - self.constant) * shear_rate

    def rate(self, state: np.ndarray, shear_rate: np.ndarray) -> np.ndarray:
        """Return the time derivatives (0, n)."""
        return state

    def update(
        self, known: np.ndarray, gamma_dt: float, shear_rate: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, Any]:
        """Return no states, and dS_xy/d shear_rate."""
        return known, self._tangent(shear_rate)

    def linear(self, state: np.ndarray, gamma_dt: float, shear_rate: np.ndarray, defect: np.ndarray) -> Any:
        """Return 0: without states they have no defect."""
        return np.zeros_like(shear_rate)

    def jacobian(self, state: np.ndarray, shear_rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Return the derivatives at one point; see ``ViscoelasticModel.jacobian``."""
        nothing = np.zeros(0)
        return np.zeros((0, 0)), nothing, nothing, float(self._tangent(shear_rate))

    def by_factor(self, state: np.ndarray, shear_rate: float) -> tuple[np.ndarray, float]:
        """Return the derivatives by a factor of viscosities; see ``ViscoelasticModel.by_factor``."""
        return np.zeros(0), 0.0

    def apply_shear(self, state: np.ndarray, strain: np.ndarray) -> None:
        """Change nothing: there are no states."""

    def _tangent(self, shear_rate: Any) -> Any:
        return np.imag(self.shear_stress(None, shear_rate + 1j * SMALL)) / SMALL


class ThermalModel:
    """Response of a ``base`` model where a ``factor`` a (n,) multiplies viscosities and relaxation times; moduli stay.

    With the ``viscosity`` nu_s of the base,

        S(C, u_y) = S_1(C, a u_y) + (a - 1) nu_s u_y,    F(C, u_y) = F_1(C, a u_y)/a.
    """

    def __init__(self, base: "StressModel", viscosity: float, factor: Any) -> None:
        self.base, self.viscosity, self.factor = base, viscosity, factor

    def shear_stress(self, state: np.ndarray, shear_rate: Any) -> Any:
        """Return S_xy."""
        thermal = (self.factor - 1.0) * self.viscosity * shear_rate
        return self.base.shear_stress(state, self.factor * shear_rate) + thermal

    def rate(self, state: np.ndarray, shear_rate: np.ndarray) -> np.ndarray:
        """Return dC/dt."""
        return self.base.rate(state, self.factor * shear_rate) / self.factor

    def update(
        self, known: np.ndarray, gamma_dt: Any, shear_rate: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, Any]:
        """Solve for C; see ``ViscoelasticModel.update``."""
        a = self.factor
        state, tangent = self.base.update(known, gamma_dt / a, a * shear_rate, guess)
        return state, a * tangent + (a - 1.0) * self.viscosity

    def linear(self, state: np.ndarray, gamma_dt: Any, shear_rate: np.ndarray, defect: np.ndarray) -> Any:
        """Return the linearised stress; see ``ViscoelasticModel.linear``."""
        return self.base.linear(state, gamma_dt / self.factor, self.factor * shear_rate, defect)

    def jacobian(self, state: np.ndarray, shear_rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Return the derivatives at one point; see ``ViscoelasticModel.jacobian``."""
        a = self.factor
        decay, stretching, stress, tangent = self.base.jacobian(state, a * shear_rate)
        return decay / a, stretching, stress, a * tangent + (a - 1.0) * self.viscosity

    def by_factor(self, state: np.ndarray, shear_rate: float) -> tuple[np.ndarray, float]:
        """Return the derivatives of F (components,) and of S_xy by the factor, at one point."""
        a = self.factor
        _, stretching, _, tangent = self.base.jacobian(state, a * shear_rate)
        rate = self.rate(state[:, None], np.array([shear_rate]))[:, 0]
        return (shear_rate * stretching - rate) / a, shear_rate * (tangent + self.viscosity)

    def apply_shear(self, state: np.ndarray, strain: np.ndarray) -> None:
        """Shear the states at once by ``strain``."""
        self.base.apply_shear(state, strain)


StressModel = ViscoelasticModel | InelasticModel
"""Response of an extra stress."""


def at_factor(model: Any, viscosity: float, factor: Any) -> Any:
    """Return a ``model`` whose viscosities and relaxation times have a ``factor``, None where nothing changes them."""
    return model if factor is None else ThermalModel(model, viscosity, factor)


FluidModel = StressModel | NewtonianModel


def model_of(rheology: Any, channel: Channel) -> FluidModel:
    """Return the model of a fluid's extra stress.

    At a wall of unknown velocity a Newtonian fluid counts as inelastic: the wall needs its shear stress. So it does
    where its viscosity depends on the temperature.
    """
    if rheology.carries_stress:
        return ViscoelasticModel(rheology, channel.kinematic_viscosity)
    temperature = channel.temperature
    if rheology.type == "newtonian" and not (channel.seeks_wall_velocity or (temperature and temperature.law)):
        return NewtonianModel()
    return InelasticModel(rheology.law(channel.kinematic_viscosity, channel.density), channel.kinematic_viscosity)


def conformation_excess(state: Any) -> tuple[Any, ...]:
    """Return A - 1 of one mode: components xx, xy, yy and, where the law has it, zz."""
    first, xy, *others = state
    return (first + xy * xy / (1.0 + others[0]), xy, *others)


def _rate(law: Any, shear_rate: Any, state: Any) -> tuple[Any, ...]:
    """Return dC/dt of one mode in simple shear."""
    xx, xy, *others = law.relaxation(conformation_excess(state))
    tilt = state[1] / (1.0 + state[2])
    return (xx + tilt * (tilt * others[0] - 2.0 * xy), shear_rate * (1.0 + state[2]) + xy, *others)


def _shear_stress(law: Any, state: Any) -> Any:
    return law.stress(conformation_excess(state))[1]


def _derivative(law: Any, state: np.ndarray, direction: np.ndarray) -> Any:
    """Return the derivative of S_xy by the states in a ``direction`` of them."""
    return np.imag(_shear_stress(law, state + 1j * SMALL * direction)) / SMALL
