"""Viscometers around an axis: Couette, falling ball, capillary, read at the end of a run.

* Couette: the stress at the inner cylinder is its torque over 2 pi R1^2 L, the rate there 2 W R2^2/(R2^2 - R1^2) with
  the difference W of the angular velocities. Assumed: laminar flow, and a constant viscosity.
* Falling ball: force = 6 pi mu a U K. Assumed: no inertia, a constant viscosity, a tube closed far away and so long
  that the period does not count. K of a ratio x = a/R by T. Bohlin, Trans. R. Inst. Technol. Stockholm 155 (1960), for
  x <= 0.6; it is 0.4 % below the exact 5.9474 at x = 0.5.
* Capillary: the stress at the wall is the force on it over its area, the apparent rate 4 Q/(pi R^3), which is the rate
  at the wall if the viscosity is constant. For other fluids ``rabinowitsch`` takes several runs: L. B. Rabinowitsch,
  Z. phys. Chem. A 145 (1929) 1-26.
"""

import numpy as np

from tisph.errors import ConfigError
from tisph.exact.taylor_vortices import coefficients
from tisph.geometry.circle import Circle
from tisph.measures._reading import Axes, Reading

VISCOMETERS = ("taylor_couette", "pipe", "sphere_in_tube")
"""Scenes that are read here."""

STEADY = 1e-3
"""Change of what is read over the last tenth of the time above which it is called unsteady."""

NEAR = 0.1
"""Part of the viscosity at the end by which others that a picture shows may be off it."""

LAMINAR = 1e-6
"""Kinetic energy along radii over that around the axis above which vortices are said to carry a part of the torque."""

LARGEST_RATIO = 0.6


def wall_factor(ratio):
    """K of a sphere of a ``ratio`` of the tube's radius: Bohlin's."""
    powers = {1: -2.10443, 3: 2.08877, 5: -0.94813, 6: -1.372, 8: 3.87, 10: -4.19}
    return 1.0 / (1.0 + sum(factor * ratio**power for power, factor in powers.items()))


def read_viscometer(scene_name, scene, table, last):
    """``Reading`` of a run of the scene; ``table``: columns of its history, ``last``: its last sample.

    ConfigError where it is no such instrument.
    """
    if last is None:
        raise ConfigError("it has no sample: it has not ended")
    read = {"taylor_couette": _couette, "pipe": _capillary, "sphere_in_tube": _falling_ball}[scene_name]
    return read(scene, {name: values[1:] for name, values in table.items()}, last)


def rabinowitsch(readings):
    """Lines of stress, rate and viscosity at the wall of capillaries with one fluid; none of fewer than three.

    The rate is (3 + n)/4 of the apparent one, n being the slope of its logarithm over that of the stress.
    """
    pairs = [(each.numbers["wall_stress"], each.numbers["apparent_rate"]) for each in readings]
    if len(pairs) < 3:
        return []
    stress, apparent = np.abs(np.array(pairs)).T
    order = np.argsort(stress)
    stress, apparent = stress[order], apparent[order]
    slope = np.gradient(np.log(apparent), np.log(stress))
    rate = apparent * (3.0 + slope) / 4.0
    rows = zip(stress, rate, stress / rate, strict=True)
    title = "Rabinowitsch: stress, rate and viscosity at the wall"
    return [title, *("  " + "  ".join(f"{value:.6g}" for value in row) for row in rows)]


def _couette(scene, table, last):
    if not scene.periodic[0]:
        raise ConfigError("a Couette viscometer has no end plates here: the torque at them has no limit")
    outer, inner = (float(body.spin.velocity(table["t"][-1])) for body in reversed(scene.bodies))
    if any(body.spin.oscillates for body in scene.bodies) or inner == outer:
        raise ConfigError("a Couette viscometer has cylinders of different, constant angular velocities")
    square = scene.inner_radius**2
    rate = 2.0 * coefficients((scene.inner_radius, scene.outer_radius), (inner, outer))[1] / square
    stress = -table["torque_inner"] / (2.0 * np.pi * square * scene.length)
    numbers = {"wall_stress": float(stress[-1]), "rate": rate}
    lines = [f"at the inner cylinder: shear stress {stress[-1]:.6g}, nominal rate {rate:.6g}"]
    if table["kinetic_energy_radial"][-1] > LAMINAR * table["kinetic_energy_azimuthal"][-1]:
        lines.append("vortices carry a part of the torque: this is no viscosity of the fluid")
    return _reading("Couette viscometer", scene, table["t"], stress / rate, lines, numbers)


def _capillary(scene, table, last):
    moving = any(body.motion.x.largest_speed or body.spin.largest_speed for body in scene.bodies)
    if scene.inner_radius or scene.drive.oscillates or moving or not scene.drive.largest_speed:
        raise ConfigError("a capillary is one pipe at rest with a constant acceleration")
    radius = scene.outer_radius
    stress = table["force_outer"] / (2.0 * np.pi * radius * scene.length)
    flow = np.pi * radius**2 * last["mean_velocity"]
    apparent, driven = 4.0 * flow / (np.pi * radius**3), 0.5 * scene.density * scene.acceleration * radius
    lines = [
        f"shear stress at the wall {stress[-1]:.6g}, by the pressure gradient of steady flow {driven:.6g}",
        f"flow rate {flow:.6g}, apparent rate 4 Q/(pi R^3) = {apparent:.6g}",
    ]
    numbers = {"wall_stress": float(stress[-1]), "flow_rate": flow, "apparent_rate": apparent}
    return _reading("capillary", scene, table["t"], stress / apparent, lines, numbers)


def _falling_ball(scene, table, last):
    sphere, tube = scene.bodies
    if not sphere.free or not isinstance(sphere.shape, Circle) or tube.motion.x.largest_speed:
        raise ConfigError("a falling ball is a free sphere in a tube at rest")
    if scene.kept_mean_velocity != 0.0:
        raise ConfigError("a falling ball is read in a closed tube: closure no_flux, without a mean_velocity")
    radius, force = scene.reference_length, float(sphere.motion.inertia.load[0])
    ratio, speed = radius / scene.outer_radius, table["velocity"]
    if not force or ratio > LARGEST_RATIO:
        raise ConfigError(f"a falling ball has a force, and at most {LARGEST_RATIO:g} of the radius of the tube")
    factor = wall_factor(ratio)
    viscosity = force / (6.0 * np.pi * radius * factor * np.where(speed == 0.0, np.nan, speed))
    reynolds = scene.density * abs(speed[-1]) * radius / viscosity[-1]
    lines = [
        f"velocity {speed[-1]:.6g} under the force {force:.6g}, Reynolds number U a/nu {reynolds:.3g}",
        f"assumed: K = {factor:.6g} of a sphere of {ratio:.4g} of the radius of a closed tube (Bohlin), no inertia",
    ]
    numbers = {"velocity": float(speed[-1]), "wall_factor": float(factor), "reynolds": float(reynolds)}
    return _reading("falling ball", scene, table["t"], viscosity, lines, numbers)


def _reading(title, scene, t, viscosity, lines, numbers):
    """The viscosity at the end, beside that of the config where it is constant, and over time.

    What a start gives, which may be twenty times as large, would flatten the curve: it begins where it is near the end.
    """
    late = np.interp(0.9 * t[-1], t, viscosity)
    end, given = float(viscosity[-1]), scene.dynamic_viscosity
    words = f" (of the config: {given:.6g}, off by {end / given - 1.0:+.2e})" if scene.rheology is None else ""
    lines = [*lines, f"viscosity {end:.6g}{words}"]
    if not abs(late / end - 1.0) < STEADY:
        lines.append(f"unsteady: a tenth of the time earlier it was {late:.6g}")
    axis = Axes("time", "viscosity", ("time", "viscosity"))
    near = np.abs(viscosity / end - 1.0) < NEAR
    curves = [(axis, "run", t[near], viscosity[near], ".")]
    if scene.rheology is None:
        curves.append((axis, "config", t[[0, -1]], [given, given], "--"))
    return Reading(title, lines, {**numbers, "viscosity": end}, curves)
