"""Regions of revolution: fluid around an axis, between walls and bodies that may turn, closed, periodic or in a stream.

In a ``StreamOfRevolution`` the fluid enters with the profile of the inlet, and turns with the walls that the inlet
touches, as between two long cylinders.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.config.schema import Config
from tisph.geometry.body import Body, gap
from tisph.geometry.line import Line
from tisph.measures.fits import section_mean
from tisph.measures.flow import Size
from tisph.scenes import _axisymmetric
from tisph.scenes._axisymmetric import AxisymmetricScene, layer_at_plates
from tisph.scenes._ends import InletFlow, ends_of
from tisph.scenes._scene import open_place
from tisph.scenes._stream import OpenEnded
from tisph.scenes._views import Profile, TimeSeries
from tisph.snapshot import Snapshot

POINTS = 100
"""Points on each wall for the gaps between walls."""


def swirl_between(walls: dict[str, Body], radii: Sequence[float]) -> tuple[float, float]:
    """Return A and B of the swirl A r + B/r between ``walls``, the inner one first, at these ``radii``.

    It is circular Couette flow; without an inner wall the fluid turns with the outer one.
    """
    spins = [float(wall.spin.velocity(1.0)) for wall in walls.values()]
    if len(spins) < 2:
        return spins[0], 0.0
    inner, outer = (radius**2 for radius in radii)
    vortex = (spins[0] - spins[1]) * inner * outer / (outer - inner)
    return spins[1] - vortex / outer, vortex


@dataclass(frozen=True, kw_only=True)
class RegionOfRevolution(AxisymmetricScene):
    """A fluid at rest at first; the first ``count`` of the ``bodies`` are in the fluid, the others are walls around it.

    ``singular``: whether walls with different angular velocities meet.
    """

    count: int
    acceleration: float
    singular: bool

    @classmethod
    def around(cls, config: Config, bodies: dict[str, Body], walls: dict[str, Body]) -> "RegionOfRevolution":
        """Return the scene of a validated ``config`` with ``bodies`` in the fluid and ``walls`` around it, by name."""
        (left, low), (right, high) = config.box.tolist()
        return cls(
            **cls.fluid_of(config),
            length=right - left,
            left=left,
            inner_radius=low,
            outer_radius=high,
            periodic=config.periodic,
            names=(*bodies, *walls),
            bodies=(*bodies.values(), *walls.values()),
            count=len(bodies),
            acceleration=config.drive.acceleration,
            singular=config.singular,
        )

    @property
    def velocity_scale(self) -> float:
        """Speed of the fastest wall or body, or a rough estimate of the speed that the acceleration drives.

        In a pipe the viscosity bounds it, past bodies the inertia as well.
        """
        drive, width = abs(self.acceleration), self.reference_length
        driven = drive * width**2 / (4.0 * self.kinematic_viscosity)
        if self.count:
            driven = min(driven, math.sqrt(drive * width))
        return max(super().velocity_scale, driven)

    @property
    def flow_quantities(self) -> tuple[str, ...]:
        """Loads on bodies and walls; no torques if walls with different angular velocities meet: they diverge."""
        return tuple(name for name in self._columns if not (self.singular and name.startswith("torque")))

    def narrowest(self, t: float) -> tuple[Size, Size]:
        """See ``Scene.narrowest``: the gap is the smallest one between a body and another body or wall."""
        wanted = self.wanted_spacing
        pairs = [(body, other) for i, body in enumerate(self.bodies[: self.count]) for other in self.bodies[i + 1 :]]
        radii = [(body.shape.convex_radius, "the smallest radius", wanted.along(body)) for body in self.bodies]
        gaps = [(gap(*pair, t, POINTS), "the gap at a body", wanted.between(*pair, t)) for pair in pairs]
        none = math.inf, "", 1.0
        radius, narrow = (min(each, key=lambda size: size[0] / size[2], default=none) for each in (radii, gaps))
        return radius, narrow

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: the layer at walls that started at t = 0, or turn."""
        started = self.layer_depth(t), "the layer at walls"
        between_cylinders = self.periodic[0] and all(isinstance(body.shape, Line) for body in self.bodies)
        return started if between_cylinders else min(started, layer_at_plates(self))

    def flow_rate(self, snapshot: Snapshot) -> dict[str, float]:
        """Return the volume per time ``flow_rate`` through a cross-section without bodies, if there is one."""
        place = open_place(self.bodies[: self.count], self.length, snapshot.t) if self.periodic[0] else None
        if place is None:
            return {}
        low, height = self.section(np.array([place % self.length]))
        area = float(np.pi * np.squeeze(height * (2.0 * low + height)))
        return {"flow_rate": area * section_mean(self, snapshot, place)}

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return forces along the axis and torques around it on bodies and walls, kinetic energies and flow rate."""
        energies = dict(zip(_axisymmetric.ENERGIES, self.kinetic_energies(snapshot), strict=True))
        return {**self.loads(snapshot), **energies, **self.flow_rate(snapshot), **self.spread(snapshot)}

    def profiles(self) -> list[Profile]:
        """Return the velocities over the radius in the middle of the length."""
        line = self.radial_line(self.left + 0.5 * self.length)
        return [self.radial_profile(name, line) for name in "w" * self.swirls + "uv"]

    @property
    def _columns(self) -> tuple[str, ...]:
        kinds = ("torque", "force") if self.swirls else ("force",)
        return tuple(f"{kind}_{name}" for kind in kinds for name in self.names)

    def time_series(self) -> TimeSeries:
        """Return torques around the axis, if something turns, and forces along it."""
        return self.loads_series(self._columns)


@dataclass(frozen=True, kw_only=True)
class StreamOfRevolution(OpenEnded, RegionOfRevolution):
    """Flow around an axis from an inlet to an outlet: the last two ``bodies``, in this order."""

    initial_velocity: Callable[..., Any] | None = None

    @classmethod
    def around(cls, config: Config, bodies: dict[str, Body], walls: dict[str, Body]) -> "StreamOfRevolution":
        """Return the scene of a validated ``config`` with ``bodies`` in the fluid between ``walls``, by their names."""
        low, across = config.geometry.inner_radius, config.extent[1]
        first, last = ends_of(config).values()
        inlet = replace(first, swirl=swirl_between(walls, first.shape.extent[:, 1]))
        return cls(
            **cls.fluid_of(config),
            length=config.extent[0],
            inner_radius=low,
            outer_radius=low + across,
            periodic=(False, False),
            names=(*bodies, *walls),
            bodies=(*bodies.values(), *walls.values(), inlet, last),
            count=len(bodies),
            acceleration=0.0,
            singular=config.singular,
            initial_velocity=InletFlow(inlet) if getattr(config.initial, "state", "rest") == "developed" else None,
        )

    @property
    def velocity_scale(self) -> float:
        """Speed of the fastest wall or body, or the largest mean velocity through the inlet."""
        return max(self.fastest_wall, self._through)

    @property
    def flow_quantities(self) -> tuple[str, ...]:
        """Loads on bodies and walls, and the pressure drop, where they are finite."""
        return tuple(name for name in (*self._columns, "pressure_drop") if name in self._finite)

    @property
    def _finite(self) -> tuple[str, ...]:
        """Names of the loads, and of the pressure drop, that a jump of the velocity at the inlet leaves finite."""
        if not self._jumps:
            return (*self._columns, "pressure_drop")
        return tuple(name for name in self._columns if name.endswith(tuple(self.names[: self.count])) and self.count)

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: none in a flow that is developed from the start."""
        return super().thinnest_layer(t) if self.count or not self.initial_velocity else (math.inf, "")

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields at rest, or with ``initial_velocity``."""
        fields = super().initial(x, y)
        if self.initial_velocity:
            fields |= dict(zip("uvw", self.initial_velocity(x, y), strict=True))
        return fields

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return forces and torques on bodies and walls, flow rates, pressure drop and kinetic energies.

        ``mass_imbalance``: inflow minus outflow over the flow rate of the reference velocity. ``backflow``: largest
        velocity into the fluid at the outlet over the reference velocity. ``pressure_drop_mean`` and
        ``pressure_drop_scatter``: over the last quarter of the time so far.
        """
        flows = self.velocities(snapshot)
        found = {**super().diagnostics(snapshot, series), **flows}
        infinite = {name: None for name in self._columns if name not in self._finite}
        return {**found, **infinite, **self.balance(snapshot, flows), **self.drop_in_time(snapshot.t, series)}

    def profiles(self) -> list[Profile]:
        """Return the velocities over the radius in the middle; u with the inlet's profile where it is developed."""
        *swirl, u, v = super().profiles()
        flow = self.initial_velocity
        if flow and self._constant and self.isothermal and not self.count and not self._jumps:
            u = replace(u, exact=lambda x, y, t: flow(x + 0.0 * y * t, y + 0.0 * x * t)[0])
        return [u, v, *swirl]

    def time_series(self) -> TimeSeries:
        """Return the loads on bodies, or walls without bodies, flow rates and the pressure drop, if they are finite."""
        chosen = [name for name in self._columns if name in self._finite]
        if self.count:
            chosen = [name for name in chosen if name.endswith(tuple(self.names[: self.count]))]
        rate = self.reference_velocity * self.inlet.area
        flows = {"inflow": (rate, "flow rate", "flow_rate"), "outflow": (rate, "flow rate", "flow_rate")}
        if not self._jumps:
            flows["pressure_drop"] = self.density * self.reference_velocity**2, "pressure drop", "stress"
        series = self.loads_series(chosen)

        def measure(snapshot: Snapshot) -> np.ndarray:
            found = self.velocities(snapshot)
            return np.append(series.measure(snapshot), [found[name] for name in flows])

        return replace(
            series,
            content="loads of the fluid on bodies or walls, flow rates and the pressure drop, over time t",
            columns=[*series.columns, *flows],
            labels=[*series.labels, *((name.replace("_", " "), None) for name in flows)],
            measure=measure,
            sizes=[*series.sizes, *(size for size, _, _ in flows.values())],
            panels=[*series.panels, *((name, unit) for _, name, unit in flows.values())],
        )

    def movie_series(self) -> TimeSeries:
        """Return loads on the bodies, without bodies the flow rates."""
        series = self.time_series()
        return super().movie_series() if self.count else series.only(("inflow", "outflow"), "flow rate", "flow_rate")

    @cached_property
    def reference_length(self) -> float:
        """Difference of the radii at the inlet."""
        return self.inlet.shape.length

    def parameters(self, *words: Any) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        length, speed = self.units.length, f"{self.units.length}/{self.units.time}"
        text = f"mean velocity up to {self._through:.6g} {speed}, area {self.inlet.area:.6g} {length}^2"
        cause = "the mean velocity through the inlet" if self.reference_velocity == self._through else None
        return [*super().parameters(None, cause), ("inlet", text)]
