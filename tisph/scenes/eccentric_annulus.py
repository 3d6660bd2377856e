"""Journal bearing: fluid between two cylinders with different axes, which turn as in an annulus.

The outer axis is at the origin, the inner one at (eccentricity * (R2 - R1), 0). Particles fill the gap evenly, at rest
or in the Stokes flow of the cylinders' motion before t = 0. The reference is the steady Stokes flow: see
``tisph/exact/eccentric_cylinders.py``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from tisph.bodies import _clearance, circle
from tisph.config.base import Problem
from tisph.exact.eccentric_cylinders import EccentricCylinders
from tisph.measures import resolution
from tisph.measures.flow import Size
from tisph.measures.metrics import relative_difference
from tisph.measures.steadiness import followed, steadiness
from tisph.scenes import annulus
from tisph.scenes._scene import Reference, bodies_in
from tisph.scenes._spacing import with_sources
from tisph.scenes._views import (
    Profile,
    TimeSeries,
    kinetic_energy,
    planar_diagnostics,
    velocity_errors,
    velocity_profile,
)
from tisph.scenes.annulus import BetweenCylinders
from tisph.snapshot import Snapshot

CREEPING = 0.1
"""Reynolds number up to which Stokes flow is the reference. Inertia then changes velocities by at most 1.4e-4 (L2),
torques by 2e-5, and the force by 1e-3 to 7e-3 (docs/evidence/verification.md)."""

LOADS = ("torque_inner", "torque_outer", "force_x", "force_y")
"""Loads of the fluid per length of the axes: torques on the cylinders around their own axes, force on the inner one."""

EXACT_LOADS = tuple(f"{name}_exact" for name in LOADS)


class Geometry(annulus.Radii):
    """Radii of the cylinders [length], and the distance of their axes over the difference of the radii."""

    eccentricity: Annotated[float, Field(ge=0, lt=1)]

    centre: ClassVar[tuple[float, float]] = (0.0, 0.0)

    @property
    def offset(self) -> float:
        """Distance of the axes [length]."""
        return self.eccentricity * (self.outer_radius - self.inner_radius)


class Config(annulus.Config):
    """A whole run of a journal bearing."""

    geometry: Geometry  # type: ignore[assignment]  # other keys than in an annulus

    across_name = "the mean gap between the cylinders"
    has_exact_velocity = False  # only the steady flow is known

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        yield from super().problems()
        if self.scheme.type == "wcsph":
            yield "scheme.type", "wcsph cannot serve eccentric cylinders yet; take auto or implicit"
        swinging = self.walls.inner.amplitude or self.walls.outer.amplitude
        known = self.initial.state == "developed" and self.fluid.newtonian and not swinging
        if not (known or self.initial.state == "rest"):
            text = "must be rest, or developed for a Newtonian fluid between cylinders that do not oscillate"
            yield "initial.state", f"{text}: no other flow is known"
        elif self.initial.state != "rest" and (self.walls.inner.slip_length or self.walls.outer.slip_length):
            yield "initial.state", "must be rest where the fluid slips: no developed flow is known"
        flow = with_sources(Scene.from_config(self), self)
        inner, outer = flow.bodies
        for problem in _clearance.size_problems([("", circle.Parameters, inner)], flow.wanted_spacing, self.across):
            yield "geometry.inner_radius", problem[1]
        for problem in _clearance.problems([inner], {"walls.outer": outer}, flow.wanted_spacing):
            yield "geometry.eccentricity", problem[1]


@dataclass(frozen=True, kw_only=True)
class Scene(BetweenCylinders):
    """Two cylinders with different axes. Only slow and steady flow has a reference."""

    flow_quantities = ("torque_inner", "torque_outer", "force_y")

    @property
    def reference(self) -> Reference:
        """See ``Scene.reference``: with inertia Stokes flow is known to be the steady state alone."""
        assumptions = {"a Newtonian fluid": self.rheology is None}
        assumptions["cylinders without slip"] = not any(self.slip_lengths)
        if self.inertia:
            reynolds = self.velocity_scale * self.reference_length / self.kinematic_viscosity
            assumptions[f"a Reynolds number up to {CREEPING:g}, or no inertia"] = reynolds <= CREEPING
            steady = not (self.inner.oscillates or self.outer.oscillates)
            assumptions["cylinders that do not oscillate, or no inertia"] = steady
            assumptions["the steady state"] = True
        return self.reference_for("Stokes flow", assumptions)

    @property
    def named_loads(self) -> dict[str, tuple[int, int]]:
        """See ``Scene.named_loads``: the torques, and the force on the inner cylinder."""
        return {**super().named_loads, "force_x": (0, 0), "force_y": (0, 1)}

    def stokes(self, inner: Any, outer: Any) -> EccentricCylinders:
        """Return the Stokes flow of cylinders with the angular velocities ``inner`` and ``outer``."""
        return EccentricCylinders(self.inner_radius, self.outer_radius, self.offset, inner, outer)

    def narrowest(self, t: float) -> tuple[Size, Size]:
        """See ``Scene.narrowest``."""
        radius = self.inner_radius, "the radius of the inner cylinder", self.wall_spacings[0]
        inner, outer = self.bodies
        between = self.wanted_spacing.between(inner, outer, t)
        return radius, (self.reference_length - self.offset, "the gap between the cylinders", between)

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields at rest, or in the Stokes flow of the cylinders' motion before t = 0."""
        if self.initial_state == "rest":
            return super().initial(x, y)
        before = self.stokes(self.before(self.inner), self.before(self.outer))
        return dict(zip("uv", before.velocity(x, y), strict=True))

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return ``LOADS``, each also ``_exact``, and errors of velocity and pressure.

        Errors and exact values are None unless the flow is without inertia, or is steady (``measures/steadiness.py``)
        and slow (``CREEPING``).
        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), the mean of p - p_exact being subtracted. Further
        ``kinetic_energy`` per mass, and ``planar_diagnostics``.
        """
        steady = steadiness(self, snapshot.t, followed(series)).steady
        errors: dict[str, Any] = dict.fromkeys(("l2_pressure", *EXACT_LOADS))
        if self.reference.applies and (steady or not self.inertia):
            flow = self.stokes(self.inner.velocity(snapshot.t), self.outer.velocity(snapshot.t))
            pressure = flow.pressure(snapshot.x, snapshot.y, dynamic_viscosity=self.dynamic_viscosity)
            shifted = snapshot.pressure - np.mean(snapshot.weight * (snapshot.pressure - pressure))
            errors = {
                **velocity_errors(self, snapshot, *flow.velocity(snapshot.x, snapshot.y)),
                "l2_pressure": relative_difference(shifted, pressure, snapshot.weight),
                **dict(zip(EXACT_LOADS, self._exact_loads(flow), strict=True)),
            }
        return {
            **dict(zip(LOADS, _loads(snapshot), strict=True)),
            **errors,
            "kinetic_energy": kinetic_energy(self, snapshot),
            **planar_diagnostics(self, snapshot)[1],
        }

    def _exact_loads(self, flow: EccentricCylinders) -> tuple[float, ...]:
        """Return the ``LOADS`` of a Stokes flow."""
        viscosity = self.dynamic_viscosity
        return *flow.torque(dynamic_viscosity=viscosity), *flow.force(dynamic_viscosity=viscosity)

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        gap, _, *there = self.narrowest(self.start_time)[1]
        least = f"at least {_clearance.LEAST_GAP:g}; resolved from {resolution.LEAST_GAP:g} on"
        return [
            *super().parameters(),
            ("narrowest gap", f"{gap:.4g} {self.units.length}, {gap / there[0]:.3g} spacings ({least})"),
            ("reference", str(self.reference)),
        ]

    def profiles(self) -> list[Profile]:
        """Return the velocity across the line of centres."""
        scale = self.reference_velocity, self.velocity_name("speed of the fastest wall")
        stokes = {"exact": self._across, "scale": scale, "reference": "Stokes flow", "steady": self.inertia}
        return [velocity_profile(self, "v", "x", **(stokes if self.reference.applies else {}))]

    def _across(self, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the velocity along y of Stokes flow, and of the inner cylinder inside it."""
        away, turning = x - self.offset, self.inner.velocity(t)
        within = np.abs(away) < self.inner_radius
        fluid = self.stokes(turning, self.outer.velocity(t)).velocity(np.where(within, self.outer_radius, x), y)[1]
        return np.where(within, turning * away, fluid)

    def time_series(self) -> TimeSeries:
        """Return kinetic energy, torques, and the force on the inner cylinder."""
        speed, columns = self.reference_velocity, ["kinetic_energy", *LOADS]
        of = ("mean over the fluid", "inner cylinder", "outer cylinder", "inner, along x", "inner, along y")
        loads = [*2 * [("torque per length", "torque")], *2 * [("force per length", "force")]]
        force = self.dynamic_viscosity * speed * self.inner_radius / self.reference_length
        return TimeSeries(
            content="mean kinetic energy per mass, torques of the fluid on the cylinders and force on the inner one",
            name="kinetic energy per mass",
            unit="energy",
            scale=0.5 * speed**2,
            columns=columns,
            labels=[(name, None) for name in of],
            measure=lambda snapshot: np.array([kinetic_energy(self, snapshot), *_loads(snapshot)]),
            angular_frequency=max(self.inner.angular_frequency, self.outer.angular_frequency),
            sizes=[0.5 * speed**2, *2 * [force * self.inner_radius], force, force],
            panels=[("kinetic energy per mass", "energy"), *loads],
            levels=self._stokes_levels,
        )

    @property
    def _stokes_levels(self) -> tuple[float, ...]:
        """Steady values of the ``time_series``; empty where the flow does not end as a Stokes flow."""
        if not self.reference.applies or self.jump_times or self.inner.oscillates or self.outer.oscillates:
            return ()
        return np.nan, *self._exact_loads(self.stokes(self.inner.velocity(0.0), self.outer.velocity(0.0)))

    def movie_series(self) -> TimeSeries:
        """Return the torques on the cylinders."""
        return self.time_series().only("torque", "torque per length", "torque")


def _loads(snapshot: Snapshot) -> tuple[float, ...]:
    """Return ``LOADS`` of a snapshot."""
    bodies = bodies_in(snapshot)
    return *bodies.torque, *bodies.force[0]
