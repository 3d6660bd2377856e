"""Axisymmetric flows of the stability matrix: what their names say, as whole configs.

Along pipes and around their axis, beside exact solutions, numbers being the ratio of the radii; Taylor's vortices and
a sphere that moves along a tube, beside twice the particles. The gap, and the radius of the tube, is 1.
"""

import math

from tisph.studies.flows import digits, merged

ACROSS = 16
"""Spacings in which the radius of a sphere counts, and its gap to the tube."""

RATIOS, OTHER_RATIOS = (0.0, 0.1, 0.2, 0.5, 0.9), (0.0, 0.2, 0.5)
"""Inner over outer radius, without an inner wall where fluid reaches the axis; of helical flow and other fluids."""

DISTURBANCE = 0.05
"""Radial velocity of the vortices at the start, over that of the inner wall."""

FLUIDS = {
    "": {"type": "newtonian"},
    "_thinning": {"type": "power_law", "index": 0.5, "reference_rate": 1.0, "least_rate": 0.01},
    "_polymer": {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.1},
}
"""By the ends of names; Weissenberg numbers are 1."""


def beside_exact():
    """Yield names, and functions of the viscosity that return configs, of flows with an exact solution."""
    for end, fluid in FLUIDS.items():
        for ratio in OTHER_RATIOS if end else RATIOS:
            yield f"pipe{ratio:g}{end}", _flow("pipe", fluid, _pipe(ratio, 0.0), 8.0 if ratio else 4.0)
            yield f"swirl{ratio:g}{end}", _flow("pipe", fluid, _pipe(ratio, 1.0))
    for ratio in OTHER_RATIOS:
        yield f"helix{ratio:g}", _flow("pipe", FLUIDS[""], _pipe(ratio, 1.0), 8.0 if ratio else 4.0)


def beside_finer():
    """The same of flows without one."""
    for end, fluid in FLUIDS.items():
        for ratio in OTHER_RATIOS[2:] if end else RATIOS[1:]:
            yield f"vortices{ratio:g}{end}", _flow("taylor_couette", fluid, _vortices(ratio, not end))
        yield from ((f"sphere{size:g}{end}", _sphere(size / ACROSS, fluid)) for size in (3.0, 8.0))
        for gap in (4.0,) if end else (2.0, 3.0, 4.0, 6.0):
            yield f"near{gap:g}{end}", _sphere(1.0 - gap / ACROSS, fluid)
    yield "turning8", _sphere(8.0 / ACROSS, FLUIDS[""], sphere={"angular_velocity": 1.0})
    yield "open8", _sphere(8.0 / ACROSS, FLUIDS[""], closure="periodic_pressure")


def _flow(scene, fluid, given, drive=0.0):
    """``drive``: an acceleration over the viscosity, for a velocity of 1."""

    def config(nu):
        own = {"drive": {"acceleration": digits(drive * nu)}} if drive else {}
        return merged({"scene": scene, "fluid": {"kinematic_viscosity": digits(nu), "rheology": fluid}}, given, own)

    return config


def _pipe(ratio, speed):
    """The inner wall turns, or the only one."""
    inner, outer = digits(ratio / (1.0 - ratio)), digits(1.0 / (1.0 - ratio))
    walls = {"inner" if inner else "outer": {"angular_velocity": digits(speed / (inner or outer))}}
    return {"geometry": {"radius": outer, "inner_radius": inner, "length": 1.5}, "walls": walls}


def _vortices(ratio, developed):
    inner, outer = digits(ratio / (1.0 - ratio)), digits(1.0 / (1.0 - ratio))
    return {
        "geometry": {"inner_radius": inner, "outer_radius": outer, "length": 2.0},
        "walls": {"inner": {"angular_velocity": digits(1.0 / inner)}},
        "initial": {"state": "developed" if developed else "rest", "disturbance": DISTURBANCE},
    }


def _sphere(radius, fluid, **changes):
    geometry = {"tube_radius": 1.0, "sphere_radius": digits(radius), "length": 2.0 * math.ceil(radius + 0.5)}
    return _flow("sphere_in_tube", fluid, merged({"geometry": geometry, "sphere": {"velocity": 1.0}}, changes))
