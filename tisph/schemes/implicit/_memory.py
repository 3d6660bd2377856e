"""The stress with memory that particles carry, and how it answers to a shear rate over an implicit stage.

Of a conformation tensor A a particle carries w - 1, A_xy, A_yy - 1 and, where the law has it, A_zz - 1, with

    w = A_xx - t^2 A_yy,    t = A_xy / A_yy,    w' = (1, -t) R (1, -t)^T,    R the relaxation's part of dA/dt:

a shear does not change w, and A is positive definite as long as w and A_yy are positive, however large A_xx is; carried
as it stands A_xx would have to be right to 1 in A_xy^2 for that (the square root of A by Cholesky, N. Vaithianathan and
L. R. Collins, J. Comput. Phys. 187 (2003) 1-21, without the root). In a parallel flow these states C follow
dC/dt = F(C, u_y), point by point. A stage of the time integration asks for C = K + g F(C, u_y) with known K: Newton's
method finds C for a given u_y, and with it dS_xy/du_y, by which the momentum equation sees the stress of a velocity
that is still sought.
"""

import numpy as np

from tisph.schemes._pointwise import SMALL, Modes, eliminate, matrix, solve


class Memory(Modes):
    """Laws of a liquid's modes; states C are arrays (numbers of all modes, ...); stresses are over the density."""

    def __init__(self, rheology, kinematic_viscosity):
        super().__init__(rheology, kinematic_viscosity, deviation)

    def start(self, channel, heights):
        """Return C at ``heights`` of a channel when the run starts."""
        return np.concatenate([_carried(*mode) for mode in channel.initial_deviations(heights)])

    def shear_stress(self, state, shear_rate):
        """Return S_xy, which does not depend on the ``shear_rate`` of the moment."""
        return sum(_shear_stress(law, state[part]) for law, part in self)

    def strain(self, state, strain):
        """Shear the states at once by ``strain``, A to F A F^T."""
        for part in self.parts:
            state[part][1] += strain * (1.0 + state[part][2])

    def rate(self, state, shear_rate):
        """Return dC/dt of particles in simple shear."""
        each = [_rate(law, state[part], shear_rate) for law, part in self]
        return np.concatenate([np.stack(rate) for rate in each])

    def respond(self, known, duration, shear_rate, guess):
        """Solve C = ``known`` + ``duration`` F(C, ``shear_rate``) from a ``guess``; return C and dS_xy/d shear_rate."""
        state, slope = np.empty_like(known), 0.0
        for law, part in self:
            state[part], along = _respond(law, known[part], duration, shear_rate, guess[part])
            slope = slope + _along(law, state[part], along)
        return state, slope

    def linear(self, state, duration, shear_rate, defect):
        """Return dS_xy/dC . (1 - duration F_C)^-1 ``defect``, linearised about ``state``."""
        total = 0.0
        for law, part in self:
            slopes = matrix(lambda c, law=law: _rate(law, c, shear_rate), state[part], duration)
            change = eliminate(slopes, defect[part])
            total = total + _along(law, state[part], change)
        return total

    def slopes(self, state, shear_rate):
        """Return F_C (components, components), F_u' and dS_xy/dC (components) of the liquid at one place.

        And the derivative of S_xy by the shear rate of the moment, 0.
        """
        size = self.components
        decay, pull, stress = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        for law, part in self:
            unity = np.eye(part.stop - part.start)
            ahead = state[part][:, None] + 1j * SMALL * unity
            decay[part, part] = np.imag(np.stack(_rate(law, ahead, shear_rate))) / SMALL
            stress[part] = np.imag(_shear_stress(law, ahead)) / SMALL
            pull[part][1] = 1.0 + state[part][2]
        return decay, pull, stress, 0.0

    def lost(self, state):
        """Return which particles (n,) have a conformation tensor that is not positive definite."""
        lost = np.zeros(state.shape[1], dtype=bool)
        for part in self.parts:
            first, _, *others = state[part]
            lost |= ~(np.min([first, *others], axis=0) > -1.0)
        return np.flatnonzero(lost)


def deviation(state):
    """Return A - 1 of one mode: components xx, xy, yy and, where the law has it, zz."""
    first, xy, *others = state
    return (first + xy * xy / (1.0 + others[0]), xy, *others)


def _carried(xx, xy, *others):
    """Return the state of one mode whose A - 1 is given, the inverse of ``deviation``."""
    return np.stack([xx - xy * xy / (1.0 + others[0]), xy, *others])


def _rate(law, state, shear_rate):
    """Return dC/dt of one mode in simple shear."""
    xx, xy, *others = law.relaxation(deviation(state))
    tilt = state[1] / (1.0 + state[2])
    return (xx + tilt * (tilt * others[0] - 2.0 * xy), shear_rate * (1.0 + state[2]) + xy, *others)


def _shear_stress(law, state):
    return law.stress(deviation(state))[1]


def _along(law, state, direction):
    """Return the derivative of S_xy along a direction."""
    return np.imag(_shear_stress(law, state + 1j * SMALL * direction)) / SMALL


def _respond(law, known, duration, shear_rate, guess):
    """``Memory.respond`` of one mode; the second result is dC/d shear_rate."""
    state, slopes = solve(lambda c: _rate(law, c, shear_rate), known, duration, guess)
    pull = np.zeros_like(state)
    pull[1] = 1.0 + state[2]
    return state, eliminate(slopes, duration * pull)
