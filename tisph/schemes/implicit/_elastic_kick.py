"""What a wall that starts at once does to a liquid with memory: ``_kick.py`` with the stress beside the velocity.

With y the velocities, the states of the particles, and those at the walls (``_elastic_walls.py``), the discrete
equations are y' = M y + B_1 U' + B_2 U'' + ...: a velocity that jumps by J changes y by (B_1 + M B_2) J, an
acceleration relative to the drive that jumps by J_1 by B_2 J_1. All is linearised about the liquid at the wall.

Those are the first terms of a series in s = modulus * spacing^2/nu_s^2. Where the polymer's is larger than that of the
solvent they say nothing, and move liquid faster than the wall. What the wall asks of the solvent alone passes to the
whole liquid in the time lambda nu_s/nu, which is nu_p/(nu_s s) of what a layer takes to be a spacing deep: the wall
gives the impulse of a liquid without memory then, (B_1 + M B_2) J with the total viscosity, on which it does not depend
(``_kick.py``), and the polymer is still at rest.
"""

import numpy as np


def kick(stages, flow, velocity_jumps, acceleration_jumps):
    """Change the velocities and states of ``flow``, which ``stages`` advance, and those at the walls.

    Returns the velocity gained from the (bottom, top) wall, summed over the particles.
    """
    gains, places = [0.0, 0.0], stages.near_walls(flow)
    for side, (jump, rate) in enumerate(zip(velocity_jumps, acceleration_jumps, strict=True)):
        if jump != 0.0 or rate != 0.0:
            gained, strain, relaxed = _changes(stages, side, jump, rate, places[side])
            flow.velocity += gained
            stages.memory.strain(flow.state, strain)
            flow.state += relaxed
            gains[side] = float(gained.sum(dtype=float))
    return gains


def _changes(stages, side, jump, rate, liquid):
    """Return those of the velocities, the strain, and what relaxes meanwhile of the states; change the walls'."""
    operators, nu = stages.operators, stages.viscosity
    decay, pull, stress, _ = stages.memory.slopes(liquid[:-1], liquid[-1])
    modulus = float(stress @ pull)

    def spread(name, *series):
        both = [[0.0] * 3, [0.0] * 3]
        both[side] = series
        return operators.given(name, both)

    fourth = 0.0, 0.0, 1.0 / (12.0 * nu**2)  # of the series, for U'' = 1
    # for U' = 1, of the solvent, and with the stress that pulls back, by its own and its slope's part
    alone, direct = (0.0, 1.0 / nu, 0.0), (0.0, 1.0 / nu, -modulus / (6.0 * nu**3))
    velocity_2, sheared_2, third_2 = nu * spread("laplacian", *fourth), spread("d_dy", *fourth), pull / nu**2
    plain, velocity = (
        nu * (spread("laplacian", *series) + operators.laplacian(velocity_2)) for series in (alone, direct)
    )
    velocity += operators.slopes(modulus * sheared_2, 1.0) + operators.images(side, 0.0, stress @ third_2)
    if jump != 0.0 and np.abs(velocity - plain).max() > np.abs(plain).max():
        total = nu - stress @ np.linalg.solve(decay, pull)
        return jump * plain + rate * nu / total * velocity_2, 0.0, 0.0
    sheared = spread("d_dy", *direct) + operators.slopes(velocity_2, -1.0)
    stages.walls.first[side] += jump * pull / nu
    falling = (decay - np.outer(pull, stress) / nu) @ third_2 - modulus / nu * third_2
    stages.walls.third[side] += jump * falling + rate * third_2
    relaxed = np.multiply.outer(decay @ pull, jump * sheared_2)
    return jump * velocity + rate * velocity_2, jump * sheared + rate * sheared_2, relaxed
