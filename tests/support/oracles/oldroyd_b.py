"""Start-up flow of an Oldroyd-B fluid between two walls: plane Couette, plane Poiseuille, and both at once.

Equations for 0 < y < H, with the polymer stress S, S_yy = 0, and g = -(dp/dx)/density:

    density du/dt = density g + solvent_viscosity d2u/dy2 + dS_xy/dy,    u(0, t) = bottom, u(H, t) = top
    relaxation_time dS_xy/dt + S_xy = polymer_viscosity du/dy
    relaxation_time dS_xx/dt + S_xx = 2 relaxation_time du/dy S_xy

The total shear stress is solvent_viscosity * shear_rate + shear_stress; the first normal stress difference is S_xx.
All start from rest without stress at t = 0, or, with ``before``, from the developed flow of other wall velocities and
drive: velocity and shear stress obey linear equations, so they are that flow plus the start-up of the difference.

Sources: N. D. Waters and M. J. King, Rheol. Acta 9 (1970) 345-355; J. G. Oldroyd, Proc. R. Soc. Lond. A 200 (1950)
523-541 (the fluid); the forms that are summed, and their sources, are in ``_oldroyd_start`` and ``_oldroyd_normal``.

Accuracy for solvent fractions from 0.01 on, relative to the largest value in the gap up to that time: velocity, shear
rate and shear stress 1e-11 at all times, at the walls too; normal stress 3e-9 once the solvent layer at a wall that
jumps has solvent_viscosity t/(density gap^2) > 1e-5 (1e-4 at 1e-7, where the layer is too thin for the interpolation).
Without polymer the result is that of ``couette`` and ``poiseuille``.

Shapes and units: ``y`` and ``t`` broadcast against each other and the result has the broadcast shape; any
self-consistent units, viscosities in mass/(length time), stresses in mass/(length time^2). Equal times are computed
together: many heights at one time are cheap, as many times as heights are not.
"""

from dataclasses import dataclass

import numpy as np

from oracles._oldroyd_normal import normal_stress_at
from oracles._oldroyd_start import Problem, Steady, profiles
from tisph.exact.couette import dimensionless


@dataclass(frozen=True)
class Fluid:
    """Density, dynamic viscosities of solvent (> 0) and polymer (>= 0), relaxation time; else ValueError.

    A solvent viscosity of 0 is the upper-convected Maxwell fluid, whose start-up has jumps inside the fluid.
    """

    density: float
    solvent_viscosity: float
    polymer_viscosity: float
    relaxation_time: float

    def __post_init__(self):
        for name in ("density", "solvent_viscosity", "relaxation_time"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be above 0, not {getattr(self, name)}")
        if not self.polymer_viscosity >= 0:
            raise ValueError(f"polymer_viscosity must not be below 0, but is {self.polymer_viscosity}")


@dataclass(frozen=True)
class Flow:
    """What drives the fluid: velocities of the walls y = 0 and y = gap, and acceleration g along them."""

    gap: float
    bottom: float = 0.0
    top: float = 0.0
    acceleration: float = 0.0


def velocity(y, t, *, fluid, flow, before=None):
    """Velocity u(y, t) along the walls, ``t >= 0``; ``fluid`` is a ``Fluid``, ``flow`` and ``before`` are ``Flow``.

    At t = 0 walls already have the velocity in ``flow``, the fluid still flows as ``before``. Raises ValueError
    for a negative time, and where ``before`` has another gap.
    """
    problem = _problem(fluid, flow, before)
    return _by_time(lambda eta, time: profiles(problem, eta, time)[0], y, t, fluid, flow)


def shear_rate(y, t, *, fluid, flow, before=None):
    """Velocity gradient du/dy (1/time); arguments as ``velocity``. Infinite at t = 0 on a wall that jumps."""
    problem = _problem(fluid, flow, before)
    return _by_time(lambda eta, time: profiles(problem, eta, time)[1], y, t, fluid, flow) / flow.gap


def shear_stress(y, t, *, fluid, flow, before=None):
    """Polymer shear stress S_xy; arguments as ``velocity``."""
    problem = _problem(fluid, flow, before)
    scale = _total_viscosity(fluid) / flow.gap
    return scale * _by_time(lambda eta, time: profiles(problem, eta, time)[2], y, t, fluid, flow)


def normal_stress(y, t, *, fluid, flow, before=None):
    """Polymer normal stress S_xx, which is the first normal stress difference; arguments as ``velocity``."""
    problem = _problem(fluid, flow, before)
    return fluid.density * _by_time(lambda eta, time: normal_stress_at(problem, eta, time), y, t, fluid, flow)


def _total_viscosity(fluid):
    return fluid.solvent_viscosity + fluid.polymer_viscosity


def _steady(fluid, flow):
    drive = flow.acceleration * flow.gap**2 * fluid.density / _total_viscosity(fluid)
    return Steady(float(flow.bottom), float(flow.top), float(drive))


def _problem(fluid, flow, before):
    """The dimensionless problem: the developed flow ``before``, or rest, and the change from it to ``flow``."""
    before = Flow(flow.gap) if before is None else before
    if before.gap != flow.gap:
        raise ValueError(f"the flow before has a gap of {before.gap}, the flow one of {flow.gap}")
    total = _total_viscosity(fluid)
    old, new = _steady(fluid, before), _steady(fluid, flow)
    return Problem(
        solvent_fraction=fluid.solvent_viscosity / total,
        elasticity=fluid.relaxation_time * total / fluid.density / flow.gap**2,
        before=old,
        change=Steady(new.bottom - old.bottom, new.top - old.top, new.drive - old.drive),
    )


def _by_time(profile, y, t, fluid, flow):
    """Values of ``profile(heights, time)``, called once for each different time; a scalar for scalar arguments."""
    eta, times = dimensionless(y, t, flow.gap, _total_viscosity(fluid) / fluid.density)
    result = np.empty(eta.size)
    order = np.argsort(times, axis=None, kind="stable")
    changes = np.flatnonzero(np.diff(times.ravel()[order])) + 1
    for group in np.split(order, changes) if order.size else ():
        result[group] = profile(eta.ravel()[group], float(times.ravel()[group[0]]))
    return result.reshape(eta.shape)[()]
