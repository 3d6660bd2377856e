"""Axisymmetric flow with swirl: pipes, spin-up, Taylor's vortices, a sphere in a tube.

Exact are the Bessel series of pipes and turning cylinders, and the growth rates of ``exact/taylor_vortices.py``. The
torque of saturated vortices was computed for this project by a Chebyshev-Galerkin method, and agrees with finite
elements to 3e-6; the drag of the sphere by finite elements and a spectral method, which agree to 5e-9.
"""

import math

import numpy as np

from tisph.exact.taylor_vortices import critical_reynolds
from tisph.studies.flows import at_times, digits, merged, oldroyd_b
from tisph.studies.verification.axisymmetric_balance import momentum_closes
from tisph.studies.verification.criteria import at_most, ends_as, ends_at, of_whole_runs, order, order_of

FLUID = {"density": 1.0, "kinematic_viscosity": 1.0}

EARLY, LATER = 2e-4, 5e-5
"""Largest L2 of velocities at nu t/R^2 = 0.05, and later."""

STEADY = 1e-6
"""The same of the steady parabola."""

WAVES = {0.5: 3.16248, 5 / 7: 3.13780, 0.883: 3.12928}
"""Critical wavenumbers over 1/gap by the ratio of the radii: computed for this project, agreeing with S. Chandrasekhar,
Hydrodynamic and Hydromagnetic Stability (1961)."""

AROUND = (0.95, 1.0, 1.05)
"""Reynolds numbers over the critical one from whose growth rates that is interpolated."""

LINEAR = 1e-3, 30.0
"""Disturbance and end of those runs: by then others have faded, and errors of disorder, 1e-6, are far below."""

MARCUS = 74.924, 3.161, 0.035636
"""Reynolds number, wavenumber, and growth rate over the inner angular velocity at ratio 0.5: P. S. Marcus, J. Fluid
Mech. 146 (1984) 45-64."""

SATURATED = {75.0049: (1.084709, 0.07666), 88.6421: (1.217751, 0.13177), 109.098: (1.364378, 0.17709)}
"""Torque over that of laminar flow, and largest radial velocity over the inner speed, by Reynolds number; ratio 0.5."""

DRAGS = {"no_flux": 5.947377, "periodic_pressure": 2.334005}
"""Over 6 pi mu a U, of a sphere of half the tube's radius in a period of four of these."""

CAN = 12.918017
"""Torque at nu t/R^2 = 0.05 over density nu R^3 W on a closed cylinder of radius R and length 2 R that began to turn
slowly at W: the rate of change of the angular momentum, by a series (tests/core/test_regions_of_revolution.py)."""


def _pipe(number, samples, **sections):
    return {
        "scene": "pipe",
        "fluid": FLUID,
        "geometry": {"radius": 1.0, "length": 1.0, **sections.pop("geometry", {})},
        "initial": {"jitter": 0.2, **sections.pop("initial", {})},
        "discretisation": {"particles_across": number},
        **at_times(samples),
        **sections,
    }


def _vortices(number, ratio, reynolds, wavenumber, disturbance, samples):
    """Cylinders with a gap of 1, of which the inner one has the speed 1."""
    inner = ratio / (1.0 - ratio)
    return {
        "scene": "taylor_couette",
        "fluid": {"density": 1.0, "kinematic_viscosity": 1.0 / reynolds},
        "geometry": {"inner_radius": inner, "outer_radius": inner + 1.0, "length": 2.0 * math.pi / wavenumber},
        "walls": {"inner": {"angular_velocity": 1.0 / inner}},
        "initial": {"state": "developed", "disturbance": disturbance, "jitter": 0.2},
        "discretisation": {"particles_across": number},
        **at_times(samples),
    }


def _can(number):
    corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]
    return {
        "scene": "region",
        "coordinates": "axisymmetric",
        "fluid": FLUID,
        "walls": {"around": {"type": "polygon", "corners": corners}},
        "turning": [{"wall": "around", "angular_velocity": 1e-3}],
        "initial": {"jitter": 0.2},
        "discretisation": {"particles_across": number},
        **at_times([0.05]),
    }


def _sphere(number, closure):
    return {
        "scene": "sphere_in_tube",
        "fluid": {"density": 1.0, "kinematic_viscosity": 100.0},
        "geometry": {"tube_radius": 1.0, "sphere_radius": 0.5, "length": 4.0},
        "sphere": {"velocity": 1.0},
        "closure": closure,
        "discretisation": {"particles_across": number},
        **at_times([0.01]),
    }


def _sphere_in_polymer(number, deborah, solvent_fraction):
    """Oldroyd-B, De = lambda U/a: six relaxation times from the start."""
    polymer, fluid = oldroyd_b(digits(0.5 * deborah), solvent_fraction), {"fluid": {"kinematic_viscosity": 5.0}}
    return merged(_sphere(number, "no_flux"), polymer, fluid, at_times([3.0 * deborah]))


START = [0.05, 0.2, 0.5]
DRIVEN, TURNING = {"acceleration": 4.0}, {"outer": {"angular_velocity": 1.0}}
PULSES = 0.0872665, 0.349066
"""Half a period and two periods after the start."""
PULSE = {"amplitude": 36.0, "angular_frequency": 36.0}
ANNULAR = {"geometry": {"inner_radius": 0.5}, "drive": DRIVEN}
INNER = {"geometry": {"inner_radius": 0.5}, "walls": {"inner": {"angular_velocity": 2.0}}}
HIGH = {"type": "auto", "accuracy": "high"}
"""Of what oscillates, and of polymers: by the usual accuracy its time steps have errors of 6e-5."""
FINE = (14, 20, 28)
LONGER = {"geometry": {"length": 1.3}}
"""18 spacings at 14 across, the least."""
EXACT = {"time": {"tolerance": 1e-9}}
"""By the usual tolerance linear systems leave 1e-7, and time steps 4e-4 of a torque that decays."""
POLYMER = {**FLUID, "rheology": {"type": "oldroyd_b", "relaxation_time": 0.5, "solvent_fraction": 0.1}}
DEVELOPED = {"initial": {"state": "developed"}}
SPHERES = {
    "sphere_polymer": (0.3, 0.5, 28, 36),
    "sphere_elastic": (0.6, 0.5, 28, 36),
    "sphere_ucm": (0.3, 1 / 9, 36, 48),
}
"""Deborah number, solvent fraction, and particles across of spheres in polymers, by name."""

QUICK = {
    "pipe_20": _pipe(20, [*START, 2.0], drive=DRIVEN),
    "spin_up_20": _pipe(20, START, walls=TURNING),
    "vortex_20": _vortices(20, 0.5, *MARCUS[:2], 1e-4, [80.0]),
    "sphere_16": _sphere(16, "periodic_pressure"),
    "sphere_24": _sphere(24, "periodic_pressure"),
}
FULL = QUICK | {
    "pipe_steady": _pipe(20, [1.0], drive=DRIVEN, **DEVELOPED),
    "womersley_20": _pipe(20, PULSES, drive=PULSE, scheme=HIGH, **DEVELOPED),
    "annular_20": _pipe(20, [0.0125, 0.1], **ANNULAR),
    "swirl_20": _pipe(20, [0.0125, 0.1], **INNER),
    "sphere_closed": _sphere(24, "no_flux"),
    **{f"pipe_high_{number}": _pipe(number, [0.05], drive=DRIVEN, scheme=HIGH, **LONGER) for number in FINE},
    "spin_up_fine": merged(_pipe(20, [0.2], walls=TURNING), EXACT),
    "pipe_polymer": _pipe(20, [1.0], drive=DRIVEN, fluid=POLYMER, scheme=HIGH),
    "spin_up_polymer": _pipe(20, [1.0], walls=TURNING, fluid=POLYMER, scheme=HIGH),
    "pipe_uniform": merged(_pipe(20, [0.5], walls={"outer": {"velocity": 1.0}}, **DEVELOPED), EXACT),
    **{
        f"{name}_{number}": _sphere_in_polymer(number, *fluid)
        for name, (*fluid, coarse, fine) in SPHERES.items()
        for number in (coarse, fine)
    },
    "can_20": _can(20),
    "momentum_28": _vortices(28, 0.5, 109.098, WAVES[0.5], 0.1, [5.0, 20.0]),
}


def _critical_runs():
    """Runs below, at and above the critical Reynolds number, by name."""
    found = {}
    for ratio, wave in WAVES.items():
        critical = digits(critical_reynolds(ratio, wave))  # the last ones differ between processors
        for part in AROUND:
            disturbance, end = LINEAR
            found[_name(ratio, part)] = _vortices(20, ratio, part * critical, wave, disturbance, [end])
    return found


def _name(ratio, part):
    return f"critical_{ratio:.3g}_{part:g}"


def runs(quick):
    """Configs by run name, as plain dicts."""
    if quick:
        return QUICK
    saturated = {f"saturated_{each:g}": _vortices(24, 0.5, each, WAVES[0.5], 3e-2, [240.0]) for each in SATURATED}
    return FULL | _critical_runs() | saturated


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    found = [
        *_errors("pipe_20", "force_outer"),
        at_most("pipe_20", 2.0, "l2", STEADY),
        *_errors("spin_up_20", "torque_outer"),
        _growth(),
        order_of(_drag_error, "sphere 16/24", "drag order", {"sphere_16": 16, "sphere_24": 24}, 2.5),
        _drag("sphere_24", "periodic_pressure"),
    ]
    if quick:
        return found
    return [
        *found,
        *(at_most("pipe_20", t_star, "force_outer off exact", 1e-3) for t_star in (0.05, 0.5, 2.0)),
        *(_near_axis("pipe_20", place) for place in (0, 1, 3)),
        order("pipe 14/20/28", {f"pipe_high_{number}": number for number in FINE}, 0.05, 3.5, "l2"),
        at_most("pipe_steady", 1.0, "l2", STEADY),
        at_most("pipe_uniform", 0.5, "l2", 1e-9),
        at_most("spin_up_fine", START[1], "torque_outer off exact", 1e-4),
        *(at_most(case, 1.0, "l2", LATER) for case in ("pipe_polymer", "spin_up_polymer")),
        *(at_most("womersley_20", t_star, "rms", LATER) for t_star in PULSES),
        *(
            at_most(name, *row)
            for name in ("annular_20", "swirl_20")
            for row in ((0.05, "l2", EARLY), (0.4, "l2", LATER))
        ),
        *(at_most("swirl_20", 0.4, f"torque_{side} off exact", 1e-4) for side in ("inner", "outer")),
        momentum_closes("momentum_28", 1e-3),
        ends_at("can_20", "torque", 1e-3 * CAN, 1e-3, _torque_of_can),
        _drag("sphere_closed", "no_flux"),
        *(
            ends_as(f"{name}_{coarse}", f"{name}_{fine}", "drag ratio", 1e-2, _last("drag_ratio"))
            for name, (*_, coarse, fine) in SPHERES.items()
        ),
        *(_critical(ratio) for ratio in WAVES),
        *(row for reynolds in SATURATED for row in _saturated(reynolds)),
    ]


def _errors(case, load):
    """Of a start: L2 at the three times of ``START``, and the load on the wall at the second."""
    bounds = zip(START, (EARLY, LATER, LATER), strict=True)
    rows = [at_most(case, t_star, "l2", bound) for t_star, bound in bounds]
    return [*rows, at_most(case, START[1], f"{load} off exact", 1e-3)]


def _near_axis(case, place):
    """Largest error within three spacings of the axis, where neighbours are on one side, over that elsewhere.

    Not where it is that of time steps, which has the shape of J0 and is largest on the axis: at the third of ``START``.
    """

    def ratio(result):
        sample, arrays = f"sample_{place:03d}", result.arrays()
        error = np.abs(arrays[f"{sample}/u"] - arrays[f"{sample}/u_exact"])
        near = arrays[f"{sample}/y"] < 3.0 * result.summary["numbers"]["spacing"]
        return error[near].max() / error[~near].max()

    return of_whole_runs(case, f"error near the axis over that elsewhere, sample {place}", 1.0, ratio)


def _growth():
    reynolds, _, rate = MARCUS
    words = f"growth rate off Marcus at Re {reynolds:g}"
    return of_whole_runs("vortex_20", words, 1e-2, lambda run: abs(run.last["growth_rate"] / rate - 1.0))


def _last(quantity):
    """Function of a result: a number of the sample at the end."""
    return lambda result: result.last[quantity]


def _critical(ratio):
    """Reynolds number at which the growth rate, a parabola through three of them, is 0."""
    exact = critical_reynolds(ratio, WAVES[ratio])

    def off(*results):
        rates = [result.last["growth_rate"] for result in results]
        if not np.isfinite(rates).all():
            return math.nan
        zeros = np.roots(np.polyfit(AROUND, rates, 2))
        return abs(zeros[np.argmin(np.abs(zeros - 1.0))] - 1.0)

    names = tuple(_name(ratio, part) for part in AROUND)
    return of_whole_runs(f"ratio {ratio:.3g}", f"critical Re off {exact:.6g}", 2e-3, off, names)


def _saturated(reynolds):
    torque, radial = SATURATED[reynolds]
    case = f"saturated_{reynolds:g}"
    yield ends_at(case, "torque ratio", torque, 3e-3, _last("torque_ratio"))
    yield ends_at(case, "radial velocity", radial, 1e-2, _last("radial_velocity"))


def _torque_of_can(result):
    return -sum(result.last[f"torque_around_{side}"] for side in (1, 2, 3))


def _drag(case, closure):
    return ends_at(case, "drag ratio", DRAGS[closure], 5e-3, _last("drag_ratio"))


def _drag_error(result):
    return abs(result.last["drag_ratio"] / DRAGS["periodic_pressure"] - 1.0)
