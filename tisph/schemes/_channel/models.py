"""How the extra stress of a fluid that is not Newtonian responds to a shear rate over an implicit stage.

Of a conformation tensor A a particle carries w - 1, A_xy, A_yy - 1 and, where the law has it, A_zz - 1, with

    w = A_xx - t^2 A_yy,    t = A_xy / A_yy,    w' = (1, -t) R (1, -t)^T,    R the relaxation's part of dA/dt:

a shear does not change w, and A is positive definite as long as w and A_yy are positive, however large A_xx is; carried
as it stands A_xx would have to be right to 1 in A_xy^2 for that (the square root of A by Cholesky, N. Vaithianathan and
L. R. Collins, J. Comput. Phys. 187 (2003) 1-21, without the root). In a parallel flow these states C follow
dC/dt = F(C, u_y), point by point. A stage of the time integration asks for C = K + g F(C, u_y) with known K: Newton's
method finds C for a given u_y, and with it the tangent dS_xy/du_y, by which the momentum equation sees the stress of a
velocity that is still sought.

The stress of an inelastic fluid beyond that of the constant viscosity nu in ``fluid`` takes the place of a polymer's,
S_xy = (viscosity(u_y^2) - nu) u_y, without a state: so the systems are solvable where the viscosity varies by orders of
magnitude.
"""

import numpy as np

from tisph.schemes._local_newton import SMALL, Modes, eliminate, matrix, solve


class ViscoelasticModel(Modes):
    """Laws of a fluid's modes; states C are arrays (numbers of all modes, ...); stresses are per unit density."""

    def __init__(self, rheology, kinematic_viscosity):
        super().__init__(rheology, kinematic_viscosity, conformation_excess)

    def initial(self, channel, heights):
        """Return C at ``heights`` of a channel when the run starts."""
        modes = channel.initial_conformation_excess(heights)
        states = [[xx - xy * xy / (1.0 + others[0]), xy, *others] for xx, xy, *others in modes]
        return np.concatenate([np.stack(state) for state in states])

    def shear_stress(self, state, shear_rate):
        """Return S_xy, which does not depend on the instantaneous ``shear_rate``."""
        return sum(_shear_stress(law, state[part]) for law, part in self)

    def apply_shear(self, state, strain):
        """Shear the states at once by ``strain``, A to F A F^T."""
        for part in self.parts:
            state[part][1] += strain * (1.0 + state[part][2])

    def rate(self, state, shear_rate):
        """Return dC/dt of particles in simple shear."""
        each = [_rate(law, state[part], shear_rate) for law, part in self]
        return np.concatenate([np.stack(rate) for rate in each])

    def update(self, known, gamma_dt, shear_rate, guess):
        """Solve C = ``known`` + ``gamma_dt`` F(C, ``shear_rate``) from a ``guess``; return C and dS_xy/d shear_rate."""
        state, tangent = np.empty_like(known), 0.0
        for law, part in self:
            rate = lambda c, law=law: _rate(law, c, shear_rate)  # noqa: E731
            state[part], jacobian = solve(rate, known[part], gamma_dt, guess[part])
            stretching = np.zeros_like(state[part])
            stretching[1] = 1.0 + state[part][2]
            tangent = tangent + _derivative(law, state[part], eliminate(jacobian, gamma_dt * stretching))
        return state, tangent

    def linear(self, state, gamma_dt, shear_rate, defect):
        """Return dS_xy/dC . (1 - gamma_dt F_C)^-1 ``defect``, linearised about ``state``."""
        total = 0.0
        for law, part in self:
            jacobian = matrix(lambda c, law=law: _rate(law, c, shear_rate), state[part], gamma_dt)
            total = total + _derivative(law, state[part], eliminate(jacobian, defect[part]))
        return total

    def jacobian(self, state, shear_rate):
        """Return F_C (components, components), F_u' and dS_xy/dC (components) of the fluid at one point.

        And the derivative of S_xy by the instantaneous shear rate, 0.
        """
        size = self.components
        decay, stretching, stress = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        for law, part in self:
            unity = np.eye(part.stop - part.start)
            ahead = state[part][:, None] + 1j * SMALL * unity
            decay[part, part] = np.imag(np.stack(_rate(law, ahead, shear_rate))) / SMALL
            stress[part] = np.imag(_shear_stress(law, ahead)) / SMALL
            stretching[part][1] = 1.0 + state[part][2]
        return decay, stretching, stress, 0.0

    def indefinite(self, state):
        """Return which particles (n,) have a conformation tensor that is not positive definite."""
        found = np.zeros(state.shape[1], dtype=bool)
        for part in self.parts:
            first, _, *others = state[part]
            found |= ~(np.min([first, *others], axis=0) > -1.0)
        return np.flatnonzero(found)


class InelasticModel:
    """A law whose viscosity depends on the shear rate, as ``ViscoelasticModel``; states are (0, ...)."""

    components = 0

    def __init__(self, law, kinematic_viscosity):
        self.law, self.constant = law, kinematic_viscosity

    def initial(self, channel, heights):
        """Return the states at ``heights``."""
        return np.zeros((0, np.size(heights)))

    def stress(self, state):
        """Return no stress that particles carry."""
        return ()

    def shear_stress(self, state, shear_rate):
        """Return S_xy."""
        return (self.law.viscosity(shear_rate * shear_rate) - self.constant) * shear_rate

    def rate(self, state, shear_rate):
        """Return the time derivatives of no states."""
        return state

    def update(self, known, gamma_dt, shear_rate, guess):
        """Return no states, and dS_xy/d shear_rate."""
        return known, self._tangent(shear_rate)

    def linear(self, state, gamma_dt, shear_rate, defect):
        """Return the stress that no states leave."""
        return np.zeros_like(shear_rate)

    def jacobian(self, state, shear_rate):
        """Return derivatives as ``ViscoelasticModel.jacobian``."""
        nothing = np.zeros(0)
        return np.zeros((0, 0)), nothing, nothing, float(self._tangent(shear_rate))

    def apply_shear(self, state, strain):
        """Shear no states at once."""

    def indefinite(self, state):
        """Return the particles with an indefinite conformation tensor: none."""
        return np.zeros(0, dtype=int)

    def _tangent(self, shear_rate):
        return np.imag(self.shear_stress(None, shear_rate + 1j * SMALL)) / SMALL


def model_of(rheology, channel):
    """Return the model of a fluid's extra stress; None of a Newtonian fluid between walls of given velocities.

    At a stress-controlled wall a Newtonian fluid, too, has one: its stress there is what is given.
    """
    if rheology.carries_stress:
        return ViscoelasticModel(rheology, channel.kinematic_viscosity)
    if rheology.type == "newtonian" and channel.driven_side is None:
        return None
    return InelasticModel(rheology.law(channel.kinematic_viscosity, channel.density), channel.kinematic_viscosity)


def conformation_excess(state):
    """Return A - 1 of one mode: components xx, xy, yy and, where the law has it, zz."""
    first, xy, *others = state
    return (first + xy * xy / (1.0 + others[0]), xy, *others)


def _rate(law, state, shear_rate):
    """Return dC/dt of one mode in simple shear."""
    xx, xy, *others = law.relaxation(conformation_excess(state))
    tilt = state[1] / (1.0 + state[2])
    return (xx + tilt * (tilt * others[0] - 2.0 * xy), shear_rate * (1.0 + state[2]) + xy, *others)


def _shear_stress(law, state):
    return law.stress(conformation_excess(state))[1]


def _derivative(law, state, direction):
    """Return the derivative of S_xy in a direction."""
    return np.imag(_shear_stress(law, state + 1j * SMALL * direction)) / SMALL
