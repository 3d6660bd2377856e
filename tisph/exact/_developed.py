"""Developed flow of a Newtonian fluid between two walls: steady in closed form, periodic by one linear system."""

import numpy as np

REFINEMENTS = 3
"""Solutions for the residual of a periodic flow: the first one alone loses digits to round-off, 1e-8 in places."""


def steady_newtonian(start_up):
    """The continuous field (nodes,) of the steady flow of a ``StartUp``, v'' + k/r v' = -g/nu (``_elements``).

    Poiseuille and Couette flow: a parabola, and y, log r or r^-2.
    """
    flow, y, viscosity = start_up.flow, start_up.elements.node_positions, start_up.fluid.total_viscosity
    power, radius = start_up.elements.power, flow.inner_radius or 0.0
    half = flow.acceleration / (2 * (power + 1) * viscosity)
    parabola = half * (flow.gap - y) * (flow.gap + y + 2 * radius)
    if radius == 0.0 and power:
        return flow.top.speed + parabola

    def grown(y):
        return y if power == 0 else np.log1p(y / radius) if power == 1 else radius**-2 - (radius + y) ** -2

    share = grown(y) / grown(flow.gap)
    # the parabola is 0 at the top only
    return flow.bottom.speed + (flow.top.speed - flow.bottom.speed) * share + parabola - parabola[0] * (1 - share)


def periodic(equations, frequency, amplitude, node=None):
    """Complex amplitude x (nodes,) of the flow Re[x e^(iwt)] under the acceleration Re[amplitude e^(iwt)].

    Or between walls of which that at ``node`` has the velocity Re[amplitude e^(iwt)]: (iw - J) x = the acceleration,
    or i w amplitude at that wall.
    """
    forcing, x = np.zeros((2, 1, equations.size), dtype=complex)
    if node is None:
        forcing[0] = amplitude * equations.share
    else:
        forcing[0, node] = 1j * frequency * amplitude
    # not at t = 0, when the layer of a jump is infinitely thin
    solve = equations.jacobian(x[0].real, 1 / frequency).solver(np.array([1j * frequency]))
    for _ in range(REFINEMENTS):
        rates = equations.rates(np.concatenate([x.real, x.imag]), (0.0, 0.0))
        x = x + solve(forcing - 1j * frequency * x + rates[0] + 1j * rates[1])
    return x[0]
