"""The problem that the scheme solves: a box, a fluid, scales, and the walls in it."""

from dataclasses import dataclass

import numpy as np

from tisph.geometry.region import Box

CROWDING = 1.6


@dataclass(frozen=True, kw_only=True)
class _Problem(Box):
    """Fluid in a box, in any consistent units.

    ``reference_velocity`` is the velocity that errors and steps refer to, as seen from the frame of the mean flow.
    ``acceleration`` is that of the body force; ``walls`` (``WallPoints``) are None where there are none, ``corners``
    those (``exact/sliding_corner.py``) where the velocities of two of them differ. ``kinematic_viscosity`` is the total
    one, of solvent and polymer; ``rheology``: parameters of the fluid where it is not Newtonian, else None, and
    ``initial_conformation_excess`` of the conformation tensors of its modes at x, y, None where it starts from rest.
    ``initial_velocity``: function of x, y with the velocities (components, ...) before bodies start; None where the
    fluid is at rest. ``has_own_start``: whether these may have a divergence, which is removed. ``body_force``,
    ``conformation_source``: functions of places and time, see ``Scene``. ``swirls``: whether the fluid may turn around
    the axis.
    ``axisymmetric``: whether y is the distance from an axis, and not planar flow; ``annular``: whether an inner wall
    keeps the fluid from that.
    ``keeps_mean_velocity``: whether the acceleration changes from step to step.
    ``contact``: distance and pressure of ``Contact``, where there are free bodies.
    ``jump_times``: times at which the velocity of a wall, or its acceleration, jumps.
    """

    density: float
    kinematic_viscosity: float
    reference_velocity: float
    start_time: float = 0.0
    walls: object = None
    acceleration: tuple[float, float] = (0.0, 0.0)
    corners: tuple = ()
    rheology: object = None
    initial_conformation_excess: object = None
    initial_velocity: object = None
    has_own_start: bool = False
    body_force: object = None
    conformation_source: object = None
    swirls: bool = False
    contact: tuple[float, float] | None = None
    jump_times: tuple[float, ...] = ()
    axisymmetric: bool = False
    annular: bool = False
    keeps_mean_velocity: bool = False

    @property
    def bodies(self):
        """The bodies whose walls there are."""
        return self.walls.bodies if self.walls else ()

    @property
    def solvent_viscosity(self):
        """Kinematic viscosity that is constant, without what the extra stress of the fluid has."""
        if self.rheology is None:
            return self.kinematic_viscosity
        return self.kinematic_viscosity * self.rheology.solvent_fraction if self.carries_stress else 0.0

    @property
    def carries_stress(self):
        """Whether the fluid has a polymer."""
        return self.rheology is not None and self.rheology.carries_stress

    def unknowns(self, velocity, y):
        """Return the unknowns of the scheme for ``velocity`` (n, components) at y (n,), see ``_coordinates.py``."""
        return velocity / _factors(y) if self.axisymmetric else velocity

    def velocities(self, unknowns, y):
        """Return the velocities of which ``unknowns`` are those."""
        return unknowns * _factors(y) if self.axisymmetric else unknowns

    def unknowns_given(self, function, x, y, *time):
        """Return the unknowns (n, components) of what a ``function`` of places and time has at x, y (n,)."""
        return self.unknowns(np.stack(function(x, y, *time), axis=1), y)


def _factors(radius):
    return np.stack([np.ones_like(radius), radius, radius], axis=1)


@dataclass(frozen=True, kw_only=True)
class PeriodicProblem(_Problem):
    """A particle in each cell of a box without walls."""

    @property
    def n_fluid(self):
        """Number of fluid particles."""
        return self.columns * self.rows

    particles = n_fluid


@dataclass(frozen=True, kw_only=True)
class BoundedProblem(_Problem):
    """``n_fluid`` particles between ``walls``, beyond which the box extends by more than the support of operators."""

    n_fluid: int

    @property
    def crowding(self):
        """How many more neighbours a particle may have than near walls: in gaps that bodies close, points of both."""
        return CROWDING if self.contact else 1.0

    @property
    def particles(self):
        """Number of points that have operators: fluid particles and points on walls."""
        return self.n_fluid + self.walls.count
