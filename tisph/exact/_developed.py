"""Developed flow of a Newtonian fluid between two walls: steady in closed form, periodic by one linear system."""

import numpy as np

REFINEMENTS = 3
"""Solutions for the residual of a periodic flow: the first one alone loses digits to round-off, 1e-8 in places."""


def steady_newtonian(start_up):
    """Velocity (nodes,) of the steady flow of a ``StartUp``: Poiseuille and Couette flow.

    Between cylinders the angular velocity w = a + b/r^2.
    """
    flow, y, viscosity = start_up.flow, start_up.elements.node_positions, start_up.fluid.total_viscosity
    bottom, top = flow.bottom.speed, flow.top.speed
    if flow.inner_radius is None:
        parabola = flow.acceleration * y * (flow.gap - y) / (2 * viscosity)
        return bottom * (1 - y / flow.gap) + top * y / flow.gap + parabola
    inner, outer, between = (start_up.elements.radius(place) ** -2.0 for place in (0.0, flow.gap, y))
    return bottom + (top - bottom) * (between - inner) / (outer - inner)


def periodic(equations, node, wall):
    """Complex amplitude x (nodes,) of the flow Re[x e^(iwt)] of a ``wall`` that oscillates, at a ``node``.

    With the complex amplitude a of the wall's velocity (iw - J) x = i w a at the wall, 0 elsewhere.
    """
    frequency = wall.angular_frequency
    forcing, x = np.zeros((2, 1, equations.size), dtype=complex)
    forcing[0, node] = 1j * frequency * (wall.cosine - 1j * wall.sine)
    # not at t = 0, when the layer of a jump is infinitely thin
    solve = equations.jacobian(x[0].real, 1 / frequency).solver(np.array([1j * frequency]))
    for _ in range(REFINEMENTS):
        rates = equations.rates(np.concatenate([x.real, x.imag]), (0.0, 0.0))
        x = x + solve(forcing - 1j * frequency * x + rates[0] + 1j * rates[1])
    return x[0]
