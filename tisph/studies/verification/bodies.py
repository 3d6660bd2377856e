"""Bodies in the verification suite: slow flow past cylinders, against what others and finite elements found.

Every flow starts from rest and has a density of 1 and a kinematic viscosity of 10. Lengths and velocities are about 1,
so that the Reynolds number of a cylinder is at most 0.05. The particles start up to a fifth of a spacing off an even
arrangement.
"""

import math

import numpy as np

from tisph.studies.flows import across, at_times, merged, walls
from tisph.studies.verification.criteria import ends_at, of_whole_runs

VISCOSITY = 10.0

SLOW = {"fluid": {"density": 1.0, "kinematic_viscosity": VISCOSITY}, "initial": {"jitter": 0.2, "seed": 0}}

RESISTANCES = {0.05: 15.56, 0.2: 51.53, 0.4: 217.89}
"""Driving force of a cell over dynamic viscosity and superficial velocity, by solid fraction of a square array:
A. S. Sangani and A. Acrivos, Int. J. Multiphase Flow 8 (1982) 193-206, table 1."""

MORRIS_RESISTANCE, MORRIS_VELOCITY = 106.812, 0.122902
"""Drag of a cylinder in a channel over dynamic viscosity and superficial velocity, and that velocity over
acceleration * radius^2 / kinematic viscosity: the cell of J. P. Morris et al., J. Comput. Phys. 136 (1997) 214-226, who
have 106.77, by finite elements on three meshes."""

HELD_TORQUE, HELD_STRESS, FREE_ROTATION, FREE_STRESS = -0.063876, 1.096644, -0.490785, 1.065294
"""Of a cylinder in the middle of Couette flow, by finite elements, to 1e-6: torque over dynamic viscosity, shear rate
and gap^2, and shear stress of the walls over dynamic viscosity and shear rate, if it is held; angular velocity over
shear rate with which it would rotate freely, and the stress then."""

CELL = {"geometry": {"length": 1.0, "height": 1.0}}


def _cylinder(x, y, radius, motion="fixed"):
    return {"bodies": [{"type": "circle", "centre": [x, y], "radius": radius, "motion": motion}]}


def _array(fraction, number, end, centre=0.5):
    """A square array of cylinders, driven to a superficial velocity of 1, ``number`` particles to a period of 1."""
    radius = round(math.sqrt(fraction / math.pi), 8)
    drive = {"drive": {"acceleration": VISCOSITY * RESISTANCES[fraction]}}
    shape = merged(_cylinder(centre, centre, radius), drive, across(number))
    return merged(SLOW, {"scene": "lattice"}, CELL, shape, at_times([end]))


def _in_shear(number, motion):
    """A cylinder of radius 0.1 in the middle of Couette flow of shear rate 1, one in each gap of length."""
    cell = {"scene": "channel", "geometry": {"gap": 1.0, "length": 1.0}, **_cylinder(0.5, 0.5, 0.1, motion)}
    return merged(SLOW, cell, walls(-0.5, 0.5), across(number), at_times([0.03]))


def _ever_longer(start, end, count):
    """Ends and middles of ``count`` intervals that grow in proportion to the time."""
    ends = np.geomspace(start, end, count + 1)
    return np.sort([*ends, *(0.5 * (ends[1:] + ends[:-1]))])


MORRIS = merged(
    SLOW,
    {"scene": "channel", "geometry": {"gap": 0.8, "length": 1.2}, "walls": {}, "drive": {"acceleration": 2000.0}},
    _cylinder(0.6, 0.4, 0.2),
    across(40),
    at_times([0.05]),
)

RESOLVED = 4.7 / (VISCOSITY * 40**2)
"""Time after which the layer at a cylinder of the array is two spacings deep, and more."""

QUICK = {
    "array_0.4": _array(0.4, 28, 0.03),
    "shear_held": _in_shear(50, "fixed"),
}

FULL = {
    **QUICK,
    "array_0.2": merged(_array(0.2, 40, 0.03), at_times(_ever_longer(RESOLVED, 0.03, 12))),
    "array_0.05": _array(0.05, 80, 0.05),
    "array_0.2_corners": _array(0.2, 40, 0.03, centre=0.0),
    "morris": MORRIS,
    "shear_turned": _in_shear(50, {"angular_velocity": FREE_ROTATION}),
    "shear_held_fine": _in_shear(100, "fixed"),
}


def runs(quick):
    """Configs by run name, as plain dicts."""
    return QUICK if quick else FULL


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    found = [
        _resistance("array_0.4", 0.4),
        *_shear("shear_held", HELD_STRESS),
        _torque("shear_held", 5e-3),
    ]
    if quick:
        return found
    return [
        *found,
        _resistance("array_0.2", 0.2),
        _momentum("array_0.2", 1e-3),
        _resistance("array_0.05", 0.05),
        _resistance("array_0.2_corners", 0.2),
        *_morris(),
        *_shear("shear_turned", FREE_STRESS),
        *_shear("shear_held_fine", HELD_STRESS),
        _torque("shear_held_fine", 5e-3),
    ]


def _resistance(name, fraction):
    """The velocity that the drive brings about, and with it what the body and the falling pressure take up."""
    drive, area = FULL[name]["drive"]["acceleration"], _solid(name)

    def resistance(run):
        return (run.last["drag"] + drive * area) / (VISCOSITY * run.last["superficial_velocity"])

    return ends_at(name, "drag over viscosity and velocity", RESISTANCES[fraction], 3e-3, resistance)


def _morris():
    drive = MORRIS["drive"]["acceleration"]
    velocity = MORRIS_VELOCITY * drive * 0.2**2 / VISCOSITY
    force = drive * (0.8 * 1.2 - _solid("morris"))
    return [
        ends_at("morris", "drag over viscosity and velocity", MORRIS_RESISTANCE, 5e-3, _drag_over_velocity),
        ends_at("morris", "flow rate", 0.8 * velocity, 3e-3, lambda run: run.last["flow_rate"]),
        ends_at("morris", "drag on all", force, 1e-3, _drag_on_all),
    ]


def _drag_over_velocity(run):
    return run.last["drag"] / (VISCOSITY * run.last["superficial_velocity"])


def _drag_on_all(run):
    return sum(run.last[f"drag{part}"] for part in ("", "_bottom", "_top"))


def _shear(name, stress):
    for side, way in (("bottom", 1.0), ("top", -1.0)):
        value = lambda run, side=side, way=way: way * run.last[f"drag_{side}"] / VISCOSITY  # noqa: E731
        yield ends_at(name, f"stress of the {side} wall", stress, 5e-3, value)


def _torque(name, bound):
    return ends_at(name, "torque", HELD_TORQUE, bound, lambda run: run.last["torque"] / VISCOSITY)


def _momentum(name, bound):
    """What drives the fluid less the force on the body is what it gains, between any two of the times in turn."""
    solid = _solid(name)
    drive = FULL[name]["drive"]["acceleration"] * (1.0 - solid)

    def unbalanced(result):
        kinds = ("t", "superficial_velocity", "drag")
        t, momentum, drag = np.array([[sample[kind] for kind in kinds] for sample in result.summary["samples"]]).T
        net = drive - drag  # over each interval, whose middle is a sample too, by Simpson
        impulse = (t[2::2] - t[:-2:2]) / 6 * (net[:-2:2] + 4 * net[1::2] + net[2::2])
        rest = (momentum[2::2] - momentum[:-2:2] - impulse) / (t[2::2] - t[:-2:2])
        return np.abs(rest).max() / max(drive, np.abs(drag).max())

    return of_whole_runs(name, "momentum not accounted for, at most", bound, unbalanced)


def _solid(name):
    return math.pi * FULL[name]["bodies"][0]["radius"] ** 2
