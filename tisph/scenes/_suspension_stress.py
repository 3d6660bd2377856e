"""Mean shear stress of a suspension between walls that shear it: from the forces on the walls, and from the bodies.

The balance of momentum times the height y over the middle of the gap, over the fluid in a cell of area A, gives the
mean stress on both walls. In the mean over a long time, or in slow flow at any time, it is

    tau = mu G + (sum over bodies of S + S_c + T/2 - y F - M u' v') / A - rho <u' v'>,

with the rate G = (U_top - U_bottom)/H, the stresslets S of the fluid's tractions and S_c of near contact on each body,
and from outside the force F along x and the torque T on it; M is the mass of a body that is free along x, u' and v' are
velocities less those of a linear profile, and the last mean is that over the fluid times its part of the cell. Of a
polymer its stress is added there (G. K. Batchelor, J. Fluid Mech. 41 (1970) 545-570, eqs. 3.4 to 3.8; for y F and T his
forces and couples from outside). Both ways are of the same flow, but of different numbers in it.
"""

import numpy as np

WALLS, BODIES, CONTACTS = "shear_stress_walls", "shear_stress_bodies", "shear_stress_contacts"

WORDS = {WALLS: "on the walls", BODIES: "by the bodies", CONTACTS: "contacts in that"}
"""What each is called in a legend."""


def columns(cell):
    """Names of what ``stresses`` returns; none without free bodies, or without walls that shear the fluid.

    By the bodies it is not known where the viscosity varies.
    """
    sheared = cell.has_free_bodies and any(wall.largest_speed for _, wall in cell.planes) and not cell.acceleration
    if not sheared:
        return ()
    return (WALLS,) if cell.rheology and not cell.polymer else (WALLS, BODIES, CONTACTS)


def size(cell):
    """What stresses are compared with: the viscosity times the speed of the faster wall over the gap."""
    speed = max((wall.largest_speed for _, wall in cell.planes), default=0.0)
    return cell.dynamic_viscosity * speed / cell.size[1]


def stresses(cell, snapshot):
    """Values [stress] of the ``columns`` by name: ``CONTACTS`` is the part of near contact in that by the bodies."""
    chosen = columns(cell)
    if not chosen:
        return {}
    drag = {side: snapshot.bodies.force[cell.names.index(f"_{side}"), 0] for side in ("bottom", "top")}
    found = {WALLS: 0.5 * (drag["bottom"] - drag["top"]) / cell.size[0]}
    if BODIES in chosen:
        area = float(np.prod(cell.size))
        found[CONTACTS] = snapshot.bodies.contact_stresslet[: cell.count].sum() / area
        found[BODIES] = _of_fluid(cell, snapshot) + _of_bodies(cell, snapshot) / area
    return {name: float(found[name]) for name in chosen}


def _linear(cell, time):
    """Return the rate of shear at ``time``, and a function of y with the velocities of the linear profile."""
    speed = {side: float(wall.velocity(time)) for side, wall in cell.planes}
    rate = (speed["top"] - speed["bottom"]) / cell.size[1]
    return rate, lambda y: speed["bottom"] + rate * y


def _of_fluid(cell, snapshot):
    """Return the stress of the fluid, and the momentum that it carries across: means over the cell."""
    rate, profile = _linear(cell, snapshot.t)
    carried = -cell.density * (snapshot.u - profile(snapshot.y)) * snapshot.v
    if cell.polymer:
        carried = carried + snapshot.stress_xy
    part = cell.region.area / float(np.prod(cell.size))
    return cell.density * cell.solvent_viscosity * rate + part * float(np.mean(carried, dtype=float))


def _of_bodies(cell, snapshot):
    """Return the sum over the bodies, an area times a stress."""
    bodies, rate_profile, total = snapshot.bodies, _linear(cell, snapshot.t)[1], 0.0
    for index, body in enumerate(cell.bodies[: cell.count]):
        force = -(bodies.force[index, 0] + bodies.contact_force[index, 0])  # holds one that is not free
        torque = -(bodies.torque[index] + bodies.contact_torque[index])
        carried, (height, (u, v)) = 0.0, (bodies.centre[index, 1], bodies.velocity[index])
        if body.free:
            inertia = body.motion.inertia
            force, torque = (
                outside if held else load
                for outside, load, held in zip((force, torque), inertia.load[::2], inertia.held[::2], strict=True)
            )
            if not inertia.held[0]:
                carried = inertia.mass[0] * (u - rate_profile(height)) * v
        total += bodies.stresslet[index] + bodies.contact_stresslet[index]
        total += 0.5 * torque - (height - 0.5 * cell.size[1]) * force - carried
    return total
