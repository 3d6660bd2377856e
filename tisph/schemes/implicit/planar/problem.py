"""The problem of two-dimensional flow: a box, a fluid, scales, and the walls in the box. It does not change."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.ends import OpenEnd
from tisph.geometry.region import Box, box_around
from tisph.geometry.wanted_spacing import GROWTH, InGaps, Source, WantedSpacing
from tisph.measures.fits import section_weights
from tisph.measures.flow import FlowInBox
from tisph.measures.substance import Substance
from tisph.schemes.implicit.planar.wall_points import WallPoints, WallsOfRevolution

CROWDING = 1.6
"""How many more neighbours a particle may have than near walls: in gaps that bodies close, points of both walls."""

CROWDING_IN_GAPS = 2.0
"""The same where the spacing is a share of a gap: it grows by up to half of the distance. Of ten circles, 30 % of the
area, one had 1.02 times as many neighbours as there is room for without."""

CROWDING_AT_ENDS = 1.4
"""The same near open ends, where supports are wider."""

MARGIN = 0.2
"""Margin beyond walls over the larger side of the box, for the grid of the linear solvers, which is periodic."""

LEAST_MARGIN, LEAST_BOX = 3.0, 18.0
"""The same, and sides of the box with it, in spacings: half the largest support, and three times that."""


@dataclass(frozen=True, kw_only=True)
class Problem(Box):
    """``n_fluid`` particles of a fluid in a box, between ``walls`` or periodic, in any consistent units.

    * ``kinematic_viscosity`` of solvent and polymer together. ``rheology``: parameters of a fluid that is not
      Newtonian, else None. ``initial_conformation_excess``: function of x, y that returns the conformation tensors
      minus 1 of its modes; None for a start from rest.
    * ``substances``: temperature and dissolved substances. ``mean``: function that returns the mean over the fluid of
      values at particles with x, y and weight (``FlowInBox.mean``); None for the mean of the particles.
    * ``spacing_sources``, ``growth``: of the spacing that is wanted at each place, at most ``spacing``.
    * ``reference_velocity``: velocity that errors and steps refer to, in the frame of the mean flow.
    * ``walls``: None without any; the box extends beyond walls by more than the support of operators. ``corners``
      (``exact/sliding_corner.py``): corners in which the velocities of two walls differ. ``contact``: distance and
      pressure of ``Contact``, where there are free bodies.
    * ``acceleration`` (2,) of a uniform body force. ``kept_mean_velocity``: mean velocity along x that a pressure
      gradient keeps, else None; ``section_weights``: function of positions and time with the weights of that mean.
    * ``initial_velocity``: function of x, y that returns the velocities (components, ...) before bodies start; None for
      a fluid at rest. ``has_own_start``: whether they may have a divergence, which is removed.
    * ``body_force``, ``conformation_source``, ``kinematics``, ``kinematics_gradient``: functions of places and time,
      see ``FlowDefaults``.
    * ``axisymmetric``: whether y is the distance from an axis; ``annular``: whether an inner wall keeps the fluid away
      from the axis; ``swirls``: whether the fluid may turn around it.
    * ``all_bodies``: those among ``walls``, and free ones that have not entered yet or have left.
    * ``inertia``: whether fluid and bodies have inertia; without it the flow is Stokes flow at every time.
    * ``jump_times``: times at which the velocity of a wall, or its acceleration, jumps.
    """

    n_fluid: int
    density: float
    kinematic_viscosity: float
    reference_velocity: float
    start_time: float = 0.0
    inertia: bool = True
    spacing_sources: Sequence[Source] = ()
    growth: float = GROWTH
    walls: WallPoints | None = None
    all_bodies: Sequence[Body] = ()
    acceleration: tuple[float, float] = (0.0, 0.0)
    corners: tuple = ()
    rheology: Any = None
    substances: tuple[Substance, ...] = ()
    mean: Callable[..., float] | None = None
    initial_conformation_excess: Callable[..., Any] | None = None
    initial_velocity: Callable[..., Any] | None = None
    has_own_start: bool = False
    body_force: Callable[..., Any] | None = None
    conformation_source: Callable[..., Any] | None = None
    kinematics: Callable[..., Any] | None = None
    kinematics_gradient: Callable[..., Any] | None = None
    swirls: bool = False
    contact: tuple[float, float] | None = None
    jump_times: tuple[float, ...] = ()
    axisymmetric: bool = False
    annular: bool = False
    kept_mean_velocity: float | None = None
    section_weights: Callable[..., np.ndarray] | None = None

    @property
    def reaches_axis(self) -> bool:
        """Whether the fluid reaches an axis of symmetry, y = 0."""
        return self.axisymmetric and not self.annular

    @cached_property
    def wanted_spacing(self) -> WantedSpacing:
        """The particle spacing that is wanted at each place."""
        return WantedSpacing(self.spacing, self.spacing_sources, self.growth)

    @cached_property
    def bodies(self) -> Sequence[Body]:
        """The bodies whose walls there are."""
        return self.walls.bodies if self.walls else ()

    def restarted(
        self, walls: WallPoints, n_fluid: int, time: float, place: np.ndarray, velocity: np.ndarray
    ) -> "Problem":
        """Return the problem from ``time`` on, with other ``walls`` and another number of particles.

        Before the start the fluid has the ``velocity`` (count, components) at the points on walls, which are at
        ``place`` (count, 2).
        """
        from scipy.interpolate import NearestNDInterpolator

        at = NearestNDInterpolator(place, velocity)

        def before(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            return at(x, y).T

        changes: Any = {"initial_velocity": before, "has_own_start": True}
        return replace(self, walls=walls, n_fluid=n_fluid, start_time=time, **changes)

    @cached_property
    def particles(self) -> int:
        """Number of points that have operators: fluid particles and points on walls."""
        return self.n_fluid + (self.walls.count if self.walls else 0)

    @cached_property
    def crowding(self) -> float:
        """Factor of the largest number of neighbours."""
        in_gaps = CROWDING_IN_GAPS if any(isinstance(source, InGaps) for source in self.spacing_sources) else 1.0
        return in_gaps * (CROWDING if self.contact else CROWDING_AT_ENDS if self.open_ends else 1.0)

    @cached_property
    def open_ends(self) -> tuple[float, ...]:
        """Places x of the open ends, in the box."""
        return tuple(
            float(body.shape.extent[0, 0]) - self.origin[0] for body in self.bodies if isinstance(body, OpenEnd)
        )

    @cached_property
    def solvent_viscosity(self) -> float:
        """Constant kinematic viscosity: of the solvent, or of the whole fluid if it is Newtonian; 0 if it varies."""
        if self.rheology is None:
            return 0.0 if self.varies_with_temperature else self.kinematic_viscosity
        return self.kinematic_viscosity * self.rheology.solvent_fraction if self.carries_stress else 0.0

    @cached_property
    def varies_with_temperature(self) -> bool:
        """Whether the viscosity depends on the temperature."""
        return any(each.law for each in self.substances)

    @cached_property
    def carries_stress(self) -> bool:
        """Whether the fluid has a polymer."""
        return self.rheology is not None and self.rheology.carries_stress

    def circumferences(self, y: np.ndarray) -> np.ndarray:
        """Return the lengths (n,) around the axis of rings at ``y`` (n,) in the box; 1 in planar flow."""
        return 2.0 * np.pi * (y + self.origin[1]) if self.axisymmetric else np.ones_like(y)

    def unknowns(self, velocity: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the unknowns of the scheme for ``velocity`` (n, components) at y (n,)."""
        return velocity / _factors(y) if self.axisymmetric else velocity

    def velocities(self, unknowns: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the velocities (n, components) for the ``unknowns`` of the scheme at y (n,)."""
        return unknowns * _factors(y) if self.axisymmetric else unknowns

    def unknowns_given(self, function: Callable[..., Any], x: np.ndarray, y: np.ndarray, *time: float) -> np.ndarray:
        """Return the unknowns (n, components) for the values of a ``function`` of places and time at x, y (n,)."""
        return self.unknowns(np.stack(function(x, y, *time), axis=1), y)


def _factors(radius: np.ndarray) -> np.ndarray:
    return np.stack([np.ones_like(radius), radius, radius], axis=1)


def problem_of(scene: FlowInBox) -> Problem:
    """Return the box and the fluid of a scene, and its walls."""
    box, walls = Box(columns=scene.columns, rows=scene.rows, spacing=scene.spacing), None
    if scene.bodies:
        corners = scene.origin, np.add(scene.origin, scene.extent)
        least = 0.5 * (LEAST_BOX * scene.spacing - min(scene.extent))
        margin = max(MARGIN * max(scene.extent), LEAST_MARGIN * scene.spacing, least)
        box = box_around(corners, scene.spacing, scene.periodic, margin, scene.axisymmetric)
        present = [body for body in scene.bodies if body.enters <= scene.start_time]
        kind = WallsOfRevolution if scene.axisymmetric else WallPoints
        periods = [size if periodic else np.inf for size, periodic in zip(scene.extent, scene.periodic, strict=True)]
        walls = kind(present, scene.spacing, box.origin, periods, scene.wanted_spacing, scene.start_time)
    return Problem(
        **{each.name: getattr(box, each.name) for each in fields(box)},
        n_fluid=scene.particles,
        density=scene.density,
        kinematic_viscosity=scene.kinematic_viscosity,
        reference_velocity=scene.reference_velocity,
        spacing_sources=scene.spacing_sources,
        growth=scene.growth,
        start_time=scene.start_time,
        inertia=scene.inertia or scene.kinematics is not None,
        walls=walls,
        all_bodies=scene.bodies,
        acceleration=(scene.acceleration if scene.bodies else 0.0, 0.0),
        corners=scene.corners,
        rheology=scene.rheology,
        substances=scene.substances,
        mean=scene.mean,
        initial_conformation_excess=scene.initial_conformation_excess,
        initial_velocity=scene.initial_velocity,
        has_own_start=scene.has_own_start,
        body_force=scene.body_force,
        conformation_source=scene.conformation_source,
        kinematics=scene.kinematics,
        kinematics_gradient=scene.kinematics_gradient,
        swirls=scene.swirls,
        contact=scene.contact,
        jump_times=scene.jump_times,
        axisymmetric=scene.axisymmetric,
        annular=scene.axisymmetric and scene.origin[1] > 0.0,
        kept_mean_velocity=scene.kept_mean_velocity,
        section_weights=partial(section_weights, scene),
    )
