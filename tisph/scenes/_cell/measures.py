"""What a cell with bodies is measured by: forces on the bodies, and mean velocities."""

import numpy as np

from tisph.scenes import _turning
from tisph.verification.mean_velocity import cell_mean

LOADS = ("drag", "lift", "torque")
"""Of the liquid on a body: force along x and along y, torque around its centre, per length across the plane."""


def measures(cell, snapshot):
    """Numbers of a snapshot: those of ``loads``, ``velocities`` and ``_turning.measures``."""
    return {**loads(cell, snapshot), **velocities(cell, snapshot), **_turning.measures(cell, snapshot)[1]}


def loads(cell, snapshot):
    """``LOADS`` of each body and, with ``_pressure`` after them, what the pressure has of them; None without forces."""
    found = {}
    for index, name in enumerate(cell.names):
        values = (None,) * 6 if snapshot.bodies is None else _loads(snapshot.bodies, index)
        found |= dict(
            zip(
                [*(f"{kind}{name}" for kind in LOADS), *(f"{kind}_pressure{name}" for kind in LOADS)],
                values,
                strict=True,
            )
        )
    return found


def _loads(bodies, index):
    total, pressure = (*bodies.force[index], bodies.torque[index]), bodies.pressure_force[index]
    return (*total, *pressure, bodies.pressure_torque[index])


def velocities(cell, snapshot):
    """Mean velocities along x: ``superficial_velocity`` over the cell, bodies included, ``mean_velocity`` of the liquid.

    ``flow_rate``: the superficial velocity times the height of the cell, per length across the plane.
    """
    superficial = cell_mean(cell, snapshot)[0]
    solid = sum(body.shape.area * body.motion.x.velocity(snapshot.t) for body in cell.bodies[: cell.count])
    area = float(np.prod(cell.size))
    return {
        "superficial_velocity": superficial,
        "mean_velocity": (superficial * area - solid) / cell.region.area,
        "flow_rate": superficial * cell.size[1],
    }
