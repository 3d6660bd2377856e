"""Bodies that the flow carries: at rest, released, driven, turned by shear, against exact values and finite elements.

What a released body starts with is the acceleration (rho_s - rho) g/(rho_s + C rho). The added mass coefficient C of a
square array of solid fraction phi is (1 - phi - s)/phi: of fluid that was at rest and is pushed by what moves with a
velocity U in it, the momentum is that of potential flow, and s is the conductivity of a medium with insulating
cylinders (Lord Rayleigh, Phil. Mag. 34 (1892) 481-502; the terms here: W. T. Perrins, D. R. McKenzie, R. C. McPhedran,
Proc. R. Soc. Lond. A 369 (1979) 207-225).

The momentum of a body is what the fluid's force and its load bring about, and that of fluid and bodies together stays 0
where loads are opposite. A step conserves neither by its construction: it has velocities at particles, and forces by
values at walls. So the bounds are above what the runs here give, 1e-5 to 3e-5 and 3e-4.
"""

import math
from itertools import pairwise

import numpy as np
from scipy.integrate import simpson

from tisph.studies.verification import free_bodies_cases as cases
from tisph.studies.verification.bodies import HELD_STRESS, HELD_TORQUE, RESISTANCES
from tisph.studies.verification.criteria import ends_as, ends_at, of_whole_runs, order_of
from tisph.studies.verification.free_bodies_cases import VISCOSITY


def runs(quick):
    """Configs by run name, as plain dicts."""
    return cases.QUICK if quick else cases.FULL


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    shortest = [*_rest(), *_release(0.1), *_shear("free_shear")]
    if quick:
        return shortest
    return [
        *shortest,
        *(row for density in cases.DENSITIES if density != 0.1 for row in _release(density)),
        *(_resistance(fraction) for fraction in RESISTANCES),
        *(row for name in ("free_shear_long", "free_shear_large") for row in _shear(name)),
        _order("free_shear_large_25", "free_shear_large"),
        *_held(),
        *(row for name in cases.SETTLING for row in _settling(name)),
        *_pair(),
        *(_ellipse(degrees) for degrees in cases.ANGLES),
        *(row for density in cases.DRAWN for row in _momentum(density)),
        *(_refined(reynolds) for reynolds in cases.REYNOLDS),
        *(_slower(*pair) for pair in pairwise(cases.REYNOLDS)),
    ]


def added_mass(fraction):
    """Coefficient of the added mass of a square array of circles of a solid ``fraction``; 1 of one on its own."""
    inner = 0.305827 * fraction**4 / (1.0 - 1.402958 * fraction**8) + 0.013362 * fraction**8
    conductivity = 1.0 - 2.0 * fraction / (1.0 + fraction - inner)
    return (1.0 - fraction - conductivity) / fraction


def angular_velocity(run):
    """That of the first body at the end."""
    return run.bodies("angular_velocity")[-1][0]


def stress_ends(name, config, expected, bound):
    """The mean stress of the walls over dynamic viscosity and shear rate is ``expected``, within ``bound`` of it."""
    return ends_at(name, "stress of the walls", expected, bound, lambda run: wall_stress(run, config))


def wall_stress(run, config):
    """Shear stress of the walls at the end, mean of both, over dynamic viscosity and a shear rate of 1."""
    force = 0.5 * (run.last["drag_bottom"] - run.last["drag_top"])
    return force / (config["geometry"]["length"] * config["fluid"]["kinematic_viscosity"])


def _rest():
    scale = math.sqrt(0.2)

    def off(u):
        def largest(run):
            arrays = run.arrays()
            fluid = [arrays["sample_001/u"] - u, arrays["sample_001/v"]]
            body = [run.bodies("velocity")[-1] - [u, 0.0], run.bodies("angular_velocity")[-1]]
            return max(np.abs(each).max() for each in (*fluid, *body)) / scale

        return largest

    return [
        of_whole_runs("free_at_rest", "velocities over sqrt(g R)", 1e-12, off(0.0)),
        of_whole_runs("free_falling", "velocities off g t, over sqrt(g R)", 1e-8, off(1.0)),
        of_whole_runs("free_uniform", "velocities off those of the walls, over sqrt(g R)", 1e-8, off(1.0)),
    ]


def _release(density):
    """The first acceleration, and that while no layer is resolved: what that adds is of first order in the spacing."""
    expected = -(density - 1.0) / (density + added_mass(math.pi / 16))
    return [
        of_whole_runs(
            f"released_{density:g}",
            f"mean acceleration to {time:g} off {expected:.6f}",
            bound,
            lambda run, time=time, index=index: abs(run.bodies("velocity")[index, 0, 1] / time / expected - 1),
        )
        for index, (time, bound) in enumerate(((cases.FIRST, 1e-4), (cases.EARLY, 5e-3)))
    ]


def _resistance(fraction):
    """Force over viscosity and velocity, that against fluid and bodies on the whole."""
    expected = RESISTANCES[fraction]

    def resistance(run):
        velocity = run.bodies("velocity")[-1, 0, 0] - run.last["superficial_velocity"]
        return expected / velocity  # the force is what a velocity of 1 asks for

    return ends_at(f"driven_{fraction:g}", "force over viscosity and velocity", expected, 3e-3, resistance)


def _shear(name):
    *_, rotation, stress = cases.IN_SHEAR[name]
    turns = ends_at(name, "angular velocity", rotation, 1e-3, angular_velocity)
    return [turns, stress_ends(name, cases.FULL[name], stress, 5e-4)]


def _order(*names):
    """Of the stress of the walls: its error is the one that is above the scatter by the particles' places."""
    config, stress = cases.FULL[names[0]], cases.IN_SHEAR[names[0]][-1]

    def error(run):
        return abs(wall_stress(run, config) / stress - 1)

    resolutions = {name: cases.IN_SHEAR[name][2] for name in names}
    return order_of(error, "free_shear_large 25/50", "order of the stress of the walls", resolutions, 2.5)


def _held():
    name = "held_from_turning"
    held = ends_at(name, "torque", HELD_TORQUE * VISCOSITY, 2e-3, lambda run: run.bodies("torque")[-1][0])
    return [held, stress_ends(name, cases.FULL[name], HELD_STRESS, 5e-4)]


def _settling(name):
    """Velocity, and flow rate over that which is dragged along."""
    _, velocity, flow_rate = cases.SETTLING[name]
    scale = max(each for *_, each in cases.SETTLING.values())
    words = f"flow rate off {flow_rate:g}, over {scale:g}"
    return [
        ends_at(name, "velocity", velocity, 3e-3, lambda run: run.bodies("velocity")[-1, 0, 0]),
        of_whole_runs(name, words, 2e-3, lambda run: abs(run.last["flow_rate"] - flow_rate) / scale),
    ]


def _pair():
    """Velocities, over the speed, and angular velocities of both."""

    def off(run):
        signs = np.array([[1.0], [-1.0]])
        return np.abs(run.bodies("velocity")[-1, :2] / signs - cases.PAIR_VELOCITY).max() / speed

    def rotation_off(run):
        return np.abs(run.bodies("angular_velocity")[-1, :2] / cases.PAIR_ROTATION - 1).max()

    speed = math.hypot(*cases.PAIR_VELOCITY)
    return [
        of_whole_runs("pair", "velocities off, over the speed", 1e-3, off),
        of_whole_runs("pair", f"angular velocities off {cases.PAIR_ROTATION:g}", 1e-3, rotation_off),
        stress_ends("pair", cases.FULL["pair"], cases.PAIR_STRESS, 5e-4),
    ]


def ellipse_rotation(angle):
    """Angular velocity over shear rate of the ellipse at an ``angle`` to the walls: a series in cos 2 n angle."""
    terms = (-0.487939, 0.322416, -0.002148, 0.000715)
    return sum(term * math.cos(2 * number * angle) for number, term in enumerate(terms))


def _ellipse(degrees):
    def off(run):
        return abs(angular_velocity(run) / ellipse_rotation(run.bodies("angle")[-1][0]) - 1)

    return of_whole_runs(f"ellipse_{degrees}", "angular velocity off that of its angle", 1e-2, off)


def _momentum(density):
    """Along x: of fluid and bodies together, and of each body, over the impulse of the load."""
    name = f"drawn_apart_{density:g}"
    config = cases.FULL[name]
    area, load = math.pi * 0.1**2, np.array([body["force"][0] for body in config["bodies"]])

    def total(run):
        fluid = np.array([sample["superficial_velocity"] for sample in run.summary["samples"]])
        bodies = (density - 1.0) * area * run.bodies("velocity")[..., 0].sum(axis=1)
        return np.abs(fluid + bodies).max() / (load.max() * run.last["t"])

    def unbalanced(run):
        times = [sample["t"] for sample in run.summary["samples"][LATER:]]
        impulse = simpson(run.bodies("force")[LATER:, :, 0] + load, x=times, axis=0)
        velocity = run.bodies("velocity")[LATER:, :, 0]
        return np.abs(density * area * (velocity[-1] - velocity[0]) - impulse).max() / (load.max() * np.ptp(times))

    return [
        of_whole_runs(name, "momentum of fluid and bodies, over the impulse", 1e-3, total),
        of_whole_runs(name, "momentum of a body off its impulse, over that of the load", 1e-4, unbalanced),
    ]


LATER = 20
"""Sample from which on forces are integrated: at first they fall as 1/sqrt(t)."""


def _refined(reynolds):
    """Angular velocity with a spacing, and with a smaller one."""
    names = (f"free_re_{reynolds}_{number}" for number in cases.REYNOLDS[reynolds])
    return ends_as(*names, "angular velocity", 5e-3, angular_velocity)


def _slower(reynolds, larger):
    """A body turns more slowly where it has more inertia (E. J. Ding, C. K. Aidun, J. Fluid Mech. 423 (2000) 317)."""
    names = tuple(f"free_re_{each}_48" for each in (larger, reynolds))

    def ratio(ours, other):
        return angular_velocity(ours) / angular_velocity(other)

    return of_whole_runs(names[0], f"angular velocity over {names[1]}'s", 1.0, ratio, names)
