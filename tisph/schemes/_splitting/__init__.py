"""The implicit scheme where the flow turns: pressure, motion and viscosity of third order in a periodic box."""

import numpy as np

from tisph.geometry.box import box_around
from tisph.schemes._forecast import Forecast
from tisph.schemes._splitting._control import FIRST, LARGEST_FACTOR, viscous_step
from tisph.schemes._splitting._flow import BoundedFlow, PeriodicFlow
from tisph.schemes._splitting._scheme import SMALLEST_SPEED, TOLERANCE, Scheme
from tisph.schemes._splitting._walls import Walls

COST, OVERHEAD = 3.5e-6, 2e-3
"""Rough cost of one particle and step on two threads, and of a step whatever the number of particles [s]."""

BETWEEN_WALLS = 2.2
"""By how much a particle costs more there: operators reach farther, and the pressure is solved for twice a step. In
slow flow and in quick start-up it was 2.9, in developed flow 1.6."""

WITH_POLYMER = 1.7
"""By how much a polymer makes it more."""

MARGIN = 0.2
"""Room beyond walls over the larger side of the box, for the lattice of the linear solvers, which is periodic."""

LEAST_MARGIN, LEAST_BOX = 3.0, 18.0
"""The same, and sides of the box with it, in spacings: half of how far operators reach, and three times that."""

MOMENTS = 61
"""Times at which the speed of the reference flow is looked at."""


def scheme(config, scene, targets, serial):
    """Return the Scheme for a scene."""
    tolerance, courant = _steps(config)
    return Scheme(_flow(scene), targets, serial, tolerance, courant)


def _flow(scene):
    """Box and liquid of a scene, and its walls."""
    liquid = {
        "density": scene.density,
        "kinematic_viscosity": scene.kinematic_viscosity,
        "reference_velocity": scene.reference_velocity,
        "start_time": scene.start_time,
        "rheology": scene.rheology,
        "initial_deviations": scene.initial_deviations,
        "changes": scene.changes,
    }
    if not scene.bodies:
        return PeriodicFlow(columns=scene.columns, rows=scene.rows, spacing=scene.spacing, **liquid)
    corners = scene.origin, np.add(scene.origin, scene.extent)
    least = 0.5 * (LEAST_BOX * scene.spacing - min(scene.extent))
    margin = max(MARGIN * max(scene.extent), LEAST_MARGIN * scene.spacing, least)
    box = box_around(corners, scene.spacing, scene.periodic, margin)
    walls = Walls(scene.bodies, scene.spacing, box.origin)
    driven = {"acceleration": (scene.acceleration, 0.0), "corners": scene.corners}
    return BoundedFlow(liquid=scene.particles, walls=walls, **driven, **vars(box), **liquid)


def _steps(config):
    """Tolerance of a step, None where the Courant number alone sets it, and the largest Courant number."""
    if config.time.cfl != "auto":
        return None, config.time.cfl
    if config.singular:
        return None, config.scheme.largest_courant
    tolerance = TOLERANCE if config.time.tolerance == "auto" else config.time.tolerance
    return tolerance, config.scheme.largest_courant


def estimates(config, scene):
    """Return what ``tisph check`` says of a run: steps by their longest, no estimate of the errors."""
    courant = _steps(config)[1]
    times = np.linspace(scene.start_time, config.time.end, MOMENTS)
    rates, limit = _speeds(scene, times) / (courant * scene.spacing), "cfl"
    slowest = viscous_step(scene.spacing, scene.kinematic_viscosity, scene.rheology)
    viscous = 1.0 / slowest if scene.bodies else 0.0
    if viscous > rates.min():
        rates, limit = np.maximum(rates, viscous), "viscous"
    gone = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(times))])
    begin = np.log(1 / FIRST) / np.log(LARGEST_FACTOR) - 1 / (
        1 - 1 / LARGEST_FACTOR
    )  # steps that grow, less their time
    ends = [*config.time.samples, config.time.end]
    begun = [1 + sum(change < t for change in scene.changes) for t in ends]
    counts = [max(1, round(n * begin + np.interp(t, times, gone))) for n, t in zip(begun, ends, strict=True)]
    cost = COST * (BETWEEN_WALLS if scene.bodies else 1.0) * (WITH_POLYMER if scene.rheology else 1.0)
    return {
        "mach": 0.0,
        "sound_speed": None,
        "time_step": float(1 / rates.min()),
        "binding_limit": limit,
        "steps": counts[-1],
        "run_time": counts[-1] * (OVERHEAD + scene.particles * cost),
        "lost": False,
        "samples": [Forecast(t, count, None, None) for t, count in zip(config.time.samples, counts, strict=False)],
    }


def _speeds(scene, times):
    """Speed at each of the ``times`` that counts for the steps; without a reference that at the start."""
    if scene.bodies:
        return np.full(len(times), scene.peak_velocity)
    x, y = scene.lattice()
    initial = scene.initial(x, y)
    fastest = np.full(len(times), np.hypot(initial["u"], initial["v"]).max())
    if "u" in scene.fields:
        fastest = np.array([np.hypot(scene.exact("u", x, y, t), scene.exact("v", x, y, t)).max() for t in times])
    return np.maximum(fastest, SMALLEST_SPEED * scene.reference_velocity)
