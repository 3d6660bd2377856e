"""What a wall that starts at once does to a liquid with memory: ``_kick.py`` with the stress beside the velocity.

With y the velocities, the states of the particles, and those at the walls (``_elastic_walls.py``), the discrete
equations are y' = M y + B_1 U' + B_2 U'' + ...: a velocity that jumps by J changes y by (B_1 + M B_2) J, an
acceleration relative to the drive that jumps by J_1 by B_2 J_1. All is linearised about the liquid at the wall.

Those are the first terms of a series in modulus * spacing^2/nu_s^2. Where it is large, in liquids that relax before the
layer of the solvent is a spacing deep, they would move liquid faster than the wall, against which steps of 1e-8 of the
viscous time and less are no help: there the wall gives no impulse, and the layer is found from the next step on.
"""

import numpy as np


def kick(stages, flow, velocity_jumps, acceleration_jumps):
    """Change the velocities and states of ``flow``, which ``stages`` advance, and those at the walls.

    Returns the velocity gained from the (bottom, top) wall, summed over the particles.
    """
    gains, places = [0.0, 0.0], stages.near_walls(flow)
    for side, (jump, rate) in enumerate(zip(velocity_jumps, acceleration_jumps, strict=True)):
        if jump != 0.0 or rate != 0.0:
            changes = _changes(stages, side, jump, rate, places[side])
            if changes is None:
                continue
            gained, strain, relaxed = changes
            flow.velocity += gained
            stages.memory.strain(flow.state, strain)
            flow.state += relaxed
            gains[side] = float(gained.sum(dtype=float))
    return gains


def _changes(stages, side, jump, rate, liquid):
    """Return those of the velocities, the strain, and what relaxes meanwhile of the states; change the walls'.

    None, and no change, where the terms that there are would move liquid faster than the wall.
    """
    operators, nu = stages.operators, stages.viscosity
    decay, pull, stress, _ = stages.memory.slopes(liquid[:-1], liquid[-1])
    modulus = float(stress @ pull)

    def spread(name, *series):
        both = [[0.0] * 3, [0.0] * 3]
        both[side] = series
        return operators.given(name, both)

    fourth = 0.0, 0.0, 1.0 / (12.0 * nu**2)  # of the series, for U'' = 1
    direct = (
        0.0,
        1.0 / nu,
        -modulus / (6.0 * nu**3),
    )  # for U' = 1: the stress pulls back, by its own and its slope's part
    velocity_2, sheared_2, third_2 = nu * spread("laplacian", *fourth), spread("across", *fourth), pull / nu**2
    velocity = nu * (spread("laplacian", *direct) + operators.laplacian(velocity_2))
    velocity += operators.slopes(modulus * sheared_2, 1.0) + operators.images(side, 0.0, stress @ third_2)
    if jump != 0.0 and np.abs(velocity).max() > 1.0:
        return None
    sheared = spread("across", *direct) + operators.slopes(velocity_2, -1.0)
    stages.walls.first[side] += jump * pull / nu
    falling = (decay - np.outer(pull, stress) / nu) @ third_2 - modulus / nu * third_2
    stages.walls.third[side] += jump * falling + rate * third_2
    relaxed = np.multiply.outer(decay @ pull, jump * sheared_2)
    return jump * velocity + rate * velocity_2, jump * sheared + rate * sheared_2, relaxed
