"""What a cell with bodies is measured by: forces on the bodies, and mean velocities."""

import numpy as np

from tisph.measures.fits import cell_mean
from tisph.scenes import _two_dimensional
from tisph.scenes._cell import free_bodies, shear_stress

LOADS = ("drag", "lift", "torque")
"""Of the fluid on a body: force along x and along y, torque around its centre, per length across the plane."""


def diagnostics(cell, snapshot, series):
    """Numbers of a snapshot: of free bodies, ``loads``, ``velocities`` and ``_two_dimensional.diagnostics``."""
    found = {**of_free_bodies(cell, snapshot), **loads(cell, snapshot), **velocities(cell, snapshot)}
    return {**found, **_two_dimensional.diagnostics(cell, snapshot)[1]}


def of_free_bodies(cell, snapshot):
    """Where they are and how they move, and the mean shear stress between walls that shear them."""
    return free_bodies.states(cell, snapshot) | shear_stress.stresses(cell, snapshot)


def kinds(body):
    """Those of ``LOADS`` that a body has: a straight wall, which goes on for ever, has no torque."""
    return LOADS if body.shape.area else LOADS[:2]


def loads(cell, snapshot):
    """``LOADS`` of each body and, with ``_pressure`` after them, the pressure's part of them; None without forces."""
    found = {}
    for index, (name, body) in enumerate(zip(cell.names, cell.bodies, strict=True)):
        for part, values in zip(("", "_pressure"), _loads(snapshot.bodies, index), strict=True):
            found |= {f"{kind}{part}{name}": value for kind, value in zip(kinds(body), values, strict=False)}
    return found


def _loads(bodies, index):
    """Return all loads of a body, and those of the pressure."""
    if bodies is None:
        return (None,) * 3, (None,) * 3
    pressure = (*bodies.pressure_force[index], bodies.pressure_torque[index])
    return (*bodies.force[index], bodies.torque[index]), pressure


def velocities(cell, snapshot):
    """Mean velocities along x: ``superficial_velocity`` over the cell with the bodies, ``mean_velocity`` of the fluid.

    ``flow_rate``: the superficial velocity times the height of the cell, per length across the plane.
    """
    superficial = cell_mean(cell, snapshot)[0]
    seen = cell.seen(snapshot).bodies[: cell.count]
    solid = sum(body.shape.area * body.motion.x.velocity(snapshot.t) for body in seen)
    area = float(np.prod(cell.size))
    return {
        "superficial_velocity": superficial,
        "mean_velocity": (superficial * area - solid) / cell.region.area,
        "flow_rate": superficial * cell.size[1],
    }
