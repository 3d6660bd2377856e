"""Limits of the steps of two-dimensional flow: the Courant number, and a viscous number between walls."""

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

from tisph.measures.flow import FlowInBox
from tisph.schemes._step_control import SHARE, StepControl
from tisph.schemes.implicit.planar.problem import Problem

FlowScales: TypeAlias = FlowInBox | Problem
"""A flow, or the problem made of it: both have scales, fluid and bodies."""

TOLERANCE = 2e-6
"""Error of a step over the velocity."""

SPACING_ERROR = 9.0
"""Error of the spacing in the velocities over the root mean square of the divergence times the spacing: between
cylinders, 28 across (``taylor_couette`` of ``tisph verify manufactured``), 9.9e-6 over 1.1e-6."""

TIME_ERROR, TIME_POWER = 0.25, 0.75
"""Error of all steps of a run over this power of their tolerance. The number of steps of a method of order p goes as
tolerance^(-1/(p+1)), so the sum of their errors as tolerance^(p/(p+1)), p = 3. The factor is measured in the same flow,
with tolerances of 1e-6 and 2e-6."""

LEAST_PART = 0.1
"""Part of ``TOLERANCE``, or of a smaller tolerance, below which balanced tolerances do not fall: where the flow is
parallel, or at rest, the divergence says nothing of the error of the spacing. Steps are then 0.56 times as long."""

SMALLEST_SPEED, SMALLEST_SCALE = 0.5, 0.1
"""Parts of the reference velocity below which the Courant number of steps, and their errors, refer to them instead of
the present velocities. The second is the smaller one, so that errors of a flow that decays stay relative for longer."""

RUNAWAY = 1e3
"""Largest velocity over the reference velocity. Bodies that close a gap press some tens of times theirs out of it."""

LEAST_GRADIENT = 100 * TOLERANCE
"""Difference of velocities within a spacing, over the largest velocity, that a divergence is compared with at least.
One that counts as resolved (1 % of that) then alters them by less than the error of a step."""

FIRST = 0.02
"""The first step, which is of first order, over the longest one of the Courant number, or of the splitting."""

PRESSURE_RESIDUAL, VELOCITY_RESIDUAL = (1.0, 1e-6), (5e-4, 1e-10)
"""Residuals of the linear systems: over the tolerance of a step, and the least one. Residuals of the velocities add up
from step to step; with 5 times the residual of the pressure, forces on bodies have errors of 1e-4. With the least ones
always, 25 across between cylinders, velocities differ by 3 % of their errors (accuracy ``balanced``) and 0.1 %
(``fast``)."""

RESIDUAL_WITH_ENDS = 1e-5
"""Largest residual of the pressure between open ends. With 3e-4 (accuracy ``fast``) in a constriction at Re = 100, 16
across, corrections of the flow rate have no effect that the pressure equation sees."""

TOGETHER = 0.03
"""The same, of velocities and pressure that are solved for together: errors of the velocities."""

SHARE_TOGETHER = 0.3
"""``_step_control.SHARE`` where velocity and pressure are solved for together: velocities then follow the places of the
particles at once, and scatter by the error of the spacing. With 0.02
an Oldroyd-B fluid reaches the steady flow past a sphere in 688 steps, 100 more of them in vain, in place of 155; the
pressure gradients are 690.526 and 690.504."""

ROUNDING = 30.0
"""The least residual that is asked for, in units of the rounding error."""

DECAY = 0.3, 10.0
"""Where steps are short divergence decays at the rate 0.3 nu/spacing^2 + 10 U/spacing. A larger second number moves
errors from the velocities to the pressure, a smaller one the other way: in the vortex at Re = 100, 50 x 50, a Courant
number of 0.15 and t = 1 they are 2.7e-5 and 7.0e-5 with 4, 1.9e-5 and 8.5e-5 with 10. With 12 the noise of a divergence
that has to vanish at once makes coarse runs take shorter steps."""

DECAY_WITH_ENDS = 0.3, 3.0
"""The same numbers between open ends, where pressures answer noise of the divergence along the whole channel. In front
of a blunt inlet, 28 across and with a Courant number of 0.3, the pressure drop scatters by 1.8 % with 10, 0.8 % with 3
and 0.6 % with 1; past the cylinder of case 2D-1, 41 across, the divergence over the gradient is 1.7e-3 with 10 and 3,
and 4e-3 with 1."""

DECAY_WITH_ENDS_GRADED = 0.3, 0.5
"""The same numbers between open ends where the spacing varies. Steps of the Courant number of each particle are longer
there against the coarse spacing, and with 3 all divergence decayed within a step. Past a cylinder of 17 spacings, 28
across the channel, drag and lift scatter from step to step by 6e-3 and 6e-3 with 3, by 2.1e-3 and 1.3e-3 with 0.5, and
by 1.6e-3 and 0.8e-3 with 0.25; against 3 the mean drag changes by 3e-4 of its value with 0.5, and by 8e-4 with 0.25."""

MOST_VISCOUS = 5.0
"""Viscous number nu h/spacing^2 of the longest step between walls. Up to 6 divergence decays at the rate above whatever
the step, beyond it the divergence that there is grows with the step: every change of the step would change velocities
by more than the tolerance, and be refused. Steps are stable to 400 and more; flow rates of cylinders in slow flow, 20
spacings across, have errors of 3e-4 with 10 and of 1e-3 with 400."""

LONGER = 5.0
"""Steps of the Courant number over the longest ones of the splitting from which on it is not used. A step without it
costs 1.5 to 3 times as much; start-up in pipes, where they are 4, took 1.6 and 2.4 times as long without it."""

LEADING = 11 / 6
"""Factor gamma_0 of the newest value in backward differences of third order over steps of one length."""


def courant_speed(fastest: float, case: FlowScales) -> float:
    """Return the velocity that the Courant number refers to where the ``fastest`` one of a flow or scene is that."""
    part = SMALLEST_SCALE if case.axisymmetric else SMALLEST_SPEED  # a velocity around the axis moves no particle
    return max(fastest, part * case.reference_velocity)


def error_speed(fastest: float, case: FlowScales) -> float:
    """Return the velocity that errors of steps are divided by."""
    return max(fastest, SMALLEST_SCALE * case.reference_velocity)


def decay_rates(viscosity: float, speed: float, problem: Problem) -> tuple[float, float]:
    """Return the two terms of the rate r at which divergence decays, equation (4) of docs/theory/two-dimensional.md.

    They hold for the largest spacing, and vary as its inverse square and its inverse.
    """
    graded = DECAY_WITH_ENDS_GRADED if problem.wanted_spacing.varies else DECAY_WITH_ENDS
    viscous, convective = graded if problem.open_ends else DECAY
    return viscous * viscosity / problem.spacing**2, convective * speed / problem.spacing


def residuals(tolerance: float, least: float, open_ended: bool) -> list[float]:
    """Return the residuals of pressure and velocities for the ``tolerance`` of a step.

    Rounding allows the ``least`` one.
    """
    parts = PRESSURE_RESIDUAL, VELOCITY_RESIDUAL
    pressure, velocity = (max(part * tolerance, lowest, least) for part, lowest in parts)
    return [max(min(pressure, RESIDUAL_WITH_ENDS), least) if open_ended else pressure, velocity]


def balanced_tolerance(most: float, error_ratio: float) -> Callable[[float], float]:
    """Return a function that returns the tolerance with which all steps have ``error_ratio`` times the spatial error.

    The argument of that function is the root mean square of the divergence times the spacing, over the velocity.
    ``most``: the largest tolerance.
    """
    least = LEAST_PART * min(most, TOLERANCE)
    return lambda unresolved: min(
        most, max(least, (error_ratio * SPACING_ERROR * unresolved / TIME_ERROR) ** (1.0 / TIME_POWER))
    )


def step_control(
    case: FlowScales,
    targets: Sequence[float],
    tolerance: float | None,
    courant: float,
    error_ratio: float | None = None,
) -> StepControl:
    """Return the ``StepControl`` of a run of a flow or scene, the ``case``, to the last of the ``targets``.

    ``tolerance``: error of a step over the velocity, None where the Courant number alone decides. ``error_ratio``:
    error of all steps over the error of the spacing, see ``balanced_tolerance``; it has no effect in slow flow. The
    limit depends on the largest velocity.
    """
    slow = is_slow(case, courant)
    viscous, share = (math.inf, SHARE_TOGETHER) if slow else (viscous_step(case), SHARE)
    limit = lambda speed: min(courant * case.spacing / speed, viscous)  # noqa: E731
    balanced = None if tolerance is None or error_ratio is None or slow else balanced_tolerance(tolerance, error_ratio)
    control = StepControl(
        tolerance,
        limit,
        fixed=tolerance is None,
        multistep=True,
        jump_times=case.jump_times,
        share=share,
        balanced=balanced,
    )
    control.set_targets(targets, case.start_time)
    return control


def is_slow(case: FlowScales, courant: float) -> bool:
    """Return whether velocity and pressure are solved for together, for steps of this Courant number.

    So they are between walls where that step is ``LONGER`` than the splitting's longest one, and where fluid slips.
    Given velocities are not solved for.
    """
    if case.kinematics:
        return False
    longest = courant * case.spacing / case.reference_velocity
    slips = any(body.slip_length for body in case.bodies)
    return not case.inertia or slips or (bool(case.bodies) and longest > LONGER * viscous_step(case))


def first_step(longest: float, case: FlowScales) -> float:
    """Return the first step, or the first one after a jump, where the ``longest`` one is known.

    The layer beside a wall that starts to move is thin at first, whatever is allowed later.
    """
    return FIRST * (min(longest, viscous_step(case)) if case.inertia else longest)


def viscous_step(case: FlowScales) -> float:
    """Return the step at which ``MOST_VISCOUS`` is reached by the smallest spacing.

    It is infinite in a box without walls of a Newtonian fluid, with one spacing.

    Of a polymer's viscosity the part counts that responds within the step h: h times the moduli per unit density, over
    ``LEADING``. The step is infinite for given velocities as well.
    """
    if case.kinematics or not (case.bodies or case.rheology or case.wanted_spacing.varies):
        return math.inf
    most, viscosity = MOST_VISCOUS * case.wanted_spacing.smallest**2, case.kinematic_viscosity
    if case.rheology is None or not case.rheology.carries_stress:
        return most / viscosity
    stiffness = sum(law.modulus for law in case.rheology.laws(viscosity)) / LEADING
    solvent = case.rheology.solvent_fraction * viscosity
    return 2.0 * most / (solvent + math.sqrt(solvent**2 + 4.0 * stiffness * most))
