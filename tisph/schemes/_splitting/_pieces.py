"""Points, operators and extra stress of a problem: planar or of revolution, with walls or a polymer or without."""

from tisph.least_squares import SKIN
from tisph.least_squares.axisymmetric import AxisymmetricOperators
from tisph.least_squares.operators import LeastSquaresOperators
from tisph.neighbours.point_cloud import PointCloud
from tisph.periodic import PeriodicDomain
from tisph.runtime import real, ti
from tisph.schemes._splitting._generalised_newtonian_stress import (
    GeneralisedNewtonianStress,
    GeneralisedNewtonianStressOfRevolution,
)
from tisph.schemes._splitting._viscoelastic_stress import ViscoelasticStress
from tisph.schemes._splitting._viscoelastic_stress_of_revolution import (
    ViscoelasticStressOfRevolution,
    ViscoelasticStressWithSwirl,
)
from tisph.schemes._splitting._wall_points import MAX_WALLS, POINT_SUPPORT, WALL_SUPPORT
from tisph.solvers.auxiliary_grid import PeriodicGrid
from tisph.solvers.walled_grid import WalledGrid

SUPPORT = 2.9
"""Support radius of the operators in particle spacings. Below it a lattice that the flow stretches makes them singular
before it has broken up; above it the pressure has larger errors."""

SMALLEST_PIVOT = 1e-3
"""Of the operators: those of order 2, which would take over, are worse than any of order 4 that can be solved for."""

SMALLEST_PIVOT_AT_AXIS = 3e-3
"""The same where the fluid reaches an axis: those of even functions take over. Points on a sphere had 1.8e-3 and 2.6e-3
when their equations of the pressure became singular, and runs with a polymer diverged; others have 3.1e-3 and more."""


def points(problem, serial):
    """Return the ``PointCloud``, whose points near walls have wider supports; ``serial``: without threads."""
    cutoff = (SUPPORT + SKIN) * problem.spacing
    if problem.walls is not None:
        cutoff = cutoff, cutoff + (MAX_WALLS * WALL_SUPPORT + POINT_SUPPORT) * problem.spacing
    return PointCloud(problem, PeriodicDomain(problem.length, problem.height), cutoff, 0, serial)


def grid(problem, points):
    """Return the grid of the linear solvers."""
    return PeriodicGrid(points, problem, problem.height) if problem.walls is None else WalledGrid(points, problem)


def operators(problem, points):
    """Return the operators of ``points`` (``PointCloud``)."""
    bounded = problem.walls is not None
    # in polar coordinates points lie in layers: near walls operators then have 70 times the rounding errors
    curved = bounded and problem.walls.curved and real() == ti.f64
    pivot = SMALLEST_PIVOT_AT_AXIS if problem.axisymmetric and not problem.annular else SMALLEST_PIVOT
    chosen = points, SUPPORT * problem.spacing, 4, pivot, bounded, curved
    if problem.axisymmetric:
        return AxisymmetricOperators(*chosen, lowest_radius=problem.origin[1], annular=problem.annular)
    return LeastSquaresOperators(*chosen)


def polymer(problem, levels):
    """Return the stress that ``levels`` (``TimeLevels``) carry along, None without one."""
    if not problem.carries_stress:
        return None
    if problem.swirls:
        return ViscoelasticStressWithSwirl(levels, problem)
    return (ViscoelasticStressOfRevolution if problem.axisymmetric else ViscoelasticStress)(levels, problem)


def stress_of_viscosity(problem, levels):
    """Return the stress of a viscosity that varies, None without one."""
    if not problem.rheology or problem.carries_stress:
        return None
    kind = GeneralisedNewtonianStressOfRevolution if problem.axisymmetric else GeneralisedNewtonianStress
    return kind(levels, problem)
