"""A channel with open ends: fluid enters at one of them and leaves at the other, past bodies and steps of the walls.

``Stream`` is the scene of a channel with ``ends``. It records forces on the bodies, inflow and outflow, and
the pressures of both ends.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.config.schema import Config
from tisph.geometry.body import Body
from tisph.geometry.ends import LEAST_DISTANCE, Course, Inlet, OpenEnd
from tisph.geometry.line import Line
from tisph.geometry.packing import number_of_particles, pack
from tisph.geometry.region import Region
from tisph.measures.fits import BAND, interpolated, local_fits, periodic_tree, with_walls
from tisph.measures.flow import Size
from tisph.measures.resolution import CUBIC_NEIGHBOURS, scatter_in_time
from tisph.scenes._cell import Cell, DevelopedFlow, bodies_of, planes, walls_along
from tisph.scenes._cell_flow import LOADS, PLACES, VELOCITY
from tisph.scenes._ends import JITTER, InletFlow, ends_of, unresolved
from tisph.scenes._scene import BodyScene
from tisph.scenes._views import Profile, TimeSeries, planar_diagnostics
from tisph.snapshot import Snapshot

LAST_QUARTER = 0.25
"""Part of the time so far over which a mean is computed."""

BEYOND = 4, 40
"""Degree and number of particles of fits that extrapolate a pressure to walls and ends."""


class OpenEnded(BodyScene):
    """Members of scenes whose last two ``bodies`` are an inlet and an outlet, or two outlets."""

    @cached_property
    def _filled(self) -> Region:
        """The part of the region in which there are particles: the ends are moved into it, by their least spacing."""
        moved = [
            replace(body, centre=tuple(self._clear(body) * body.shape.normal)) if isinstance(body, OpenEnd) else body
            for body in self.region.bodies
        ]
        return replace(self.region, bodies=tuple(moved))

    def _clear(self, end: Body) -> float:
        """Return the distance of the first particles from an open ``end`` at the start."""
        points = end.boundary_points(self.wanted_spacing.smallest).point
        return LEAST_DISTANCE * self.wanted_spacing.at(points, self.start_time).min()

    @cached_property
    def particles(self) -> int:
        """Number of fluid particles at the start."""
        if self.wanted_spacing.varies:
            return number_of_particles(self._filled, self.wanted_spacing, self.start_time)
        clear = LEAST_DISTANCE * self.spacing * sum(end.shape.length for end in self.bodies[-2:])
        return round((self.region.area - clear) / self.spacing**2)

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return x, y (particles,) of particles that fill the region."""
        jitter = max(jitter, JITTER)
        x, y = pack(self._filled, self.wanted_spacing, jitter, seed, self.particles, self.start_time).T
        return x, y

    @property
    def inlet(self) -> Inlet:
        """The inlet."""
        return self.bodies[-2]  # type: ignore[return-value]

    @property
    def _through(self) -> float:
        """Largest mean velocity through the inlet."""
        return self.inlet.course.largest_speed

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times at which the acceleration of the inflow jumps, or a body enters."""
        return tuple(sorted({*self.inlet.course.jump_times, *self._entry_times}))

    @property
    def _entry_times(self) -> set[float]:
        """Times at which bodies enter."""
        return {body.enters for body in self.bodies if body.enters > self.start_time}

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """See ``Scene.drive_shown``."""
        along = self.inlet.course.largest_speed * self.inlet.shape.normal[0]
        return "inlet", "velocity", (float(along), 0.0)

    def drive_share(self, t: float) -> float | None:
        """See ``Scene.drive_share``."""
        course = self.inlet.course
        return None if self._constant else float(course.velocity(t)) / course.largest_speed

    @property
    def _constant(self) -> bool:
        """Whether the mean velocity through the inlet is constant."""
        course = self.inlet.course
        return isinstance(course, Course) and not course.wave.amplitude

    @cached_property
    def _jumps(self) -> bool:
        """Whether the velocity of the inlet jumps at a wall: pressure and stress are then infinite at that corner."""
        walls = self.inlet.shape.extent[:, 1]
        if self.axisymmetric:
            walls = walls[walls > 0.0]
        return bool(np.abs(self.inlet.profile.value(walls)).max() > 1e-9)

    @property
    def solids(self) -> tuple[Body, ...]:
        """Bodies and walls, without the ends."""
        return self.bodies[:-2]

    def velocities(self, snapshot: Snapshot) -> dict[str, float]:
        """Return the flow rates ``inflow`` and ``outflow`` per length across the plane, and the ``pressure_drop``.

        Around an axis they are volumes per time, and pressures are means over the areas of the ends. NaN before the
        first step; the pressure drop is NaN as well where the velocity of the inlet jumps at a wall.
        """
        if snapshot.flow_rates is None:
            return dict.fromkeys(("inflow", "outflow", "pressure_drop"), math.nan)
        inflow, outflow = float(snapshot.flow_rates[0]), -float(snapshot.flow_rates[1])
        places = [body.boundary_points(self.spacing).point for body in self.bodies[-2:]]
        at_ends = [
            float(np.average(self._pressures(snapshot, each), weights=each[:, 1] if self.axisymmetric else None))
            for each in places
        ]
        drop = math.nan if self._jumps else at_ends[0] - at_ends[1]
        return {"inflow": inflow, "outflow": outflow, "pressure_drop": drop}

    def unresolved_ends(self, snapshot: Snapshot) -> tuple[str, str] | None:
        """See ``_ends.unresolved``."""
        return unresolved(snapshot, self.reference_velocity, self.inlet.shape.length)

    def balance(self, snapshot: Snapshot, flows: Mapping[str, float]) -> dict[str, float]:
        """Return ``mass_imbalance`` and ``backflow``, for the ``velocities`` of a snapshot, ``flows``."""
        imbalance = (flows["inflow"] - flows["outflow"]) / (self.reference_velocity * self.inlet.area)
        return {"mass_imbalance": imbalance, "backflow": (snapshot.backflow or 0.0) / self.reference_velocity}

    def drop_in_time(self, t: float, series: Sequence) -> dict[str, float | None]:
        """Return mean and scatter of the pressure drop over the last quarter of the history up to ``t``, if known.

        ``series``: see ``diagnostics``.
        """
        columns, found = self.time_series().columns, None
        if len(series) > 2 and "pressure_drop" in columns:
            times, values = series[2]
            last = (times <= t) & (times > t - LAST_QUARTER * (t - self.start_time))
            if np.count_nonzero(last) > len(CUBIC_NEIGHBOURS):
                times, drops = times[last], values[last, columns.index("pressure_drop")]
                found = float(drops.mean()), float(scatter_in_time(times, drops))
        return dict(zip(("pressure_drop_mean", "pressure_drop_scatter"), found or (None, None), strict=True))

    def _pressures(self, snapshot: Snapshot, points: np.ndarray) -> np.ndarray:
        """Return the pressures (n,) at ``points`` (n, 2), by fits to the particles around them; NaN if not known."""
        if not len(snapshot.pressure):
            return np.full(len(points), np.nan)
        low, high = points[:, 0].min() - BAND * self.spacing, points[:, 0].max() + BAND * self.spacing
        near = np.flatnonzero((snapshot.x >= low) & (snapshot.x <= high))
        if not len(near):  # at a body that is not in the fluid
            return np.full(len(points), np.nan)
        positions, pressure = np.stack([snapshot.x[near], snapshot.y[near]], axis=1), snapshot.pressure[near, None]
        if self.axisymmetric:  # fits are even in the radius
            positions, pressure = np.concatenate([positions, positions * [1.0, -1.0]]), np.tile(pressure, (2, 1))
        return interpolated(self, positions.astype(float), pressure.astype(float), points, BEYOND)[:, 0]


@dataclass(frozen=True, kw_only=True)
class Stream(OpenEnded, Cell):
    """Flow through a channel from an inlet to an outlet: the last two ``bodies``, in this order."""

    without_bodies = "the inlet"

    @classmethod
    def from_config(cls, config: Config) -> "Cell":
        """Return the scene that a validated config describes."""
        walls, ends = walls_along(config), ends_of(config)
        bodies = bodies_of(config, {**walls, **ends})
        developed = InletFlow(next(iter(ends.values()))) if config.initial.state == "developed" else None
        return cls.around(config, bodies, {**walls, **ends}, walls=planes(walls), initial_velocity=developed)

    @property
    def driven_wall(self) -> float:
        """Speed of the fastest body, or the largest mean velocity through the inlet."""
        return max(super().driven_wall, self._through)

    @cached_property
    def reference_length(self) -> float:
        """Height of the largest body in its initial orientation; the width of the inlet without bodies."""
        return super().reference_length if self.count else self.inlet.shape.length

    @property
    def flow_quantities(self) -> tuple[str, ...]:
        """Loads on bodies, motions of free ones, the pressure drop, where flow separates at a step and reattaches."""
        moved = [name for name in super().flow_quantities if name != VELOCITY]
        return (*moved, *(["pressure_drop"] if not self._jumps else []), *self._turning_names)

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: none in a flow that is developed from the start."""
        return super().thinnest_layer(t) if self.count or not self.initial_velocity else (math.inf, "")

    def loads(self, snapshot: Snapshot) -> dict[str, float | None]:
        """Return the loads on bodies and walls by name; None for walls at which the velocity of the inlet jumps."""
        infinite = tuple(self.names[self.count :]) if self._jumps else ()
        return {name: None if name.endswith(infinite) else load for name, load in super().loads(snapshot).items()}

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return ``free_motions``, ``loads``, their coefficients, flow rates, pressures and ``planar_diagnostics``.

        ``drag_coefficient`` and ``lift_coefficient``: 2 F/(density U^2 d) with the reference velocity U and the
        height d of the body. ``pressure_difference``: at the first point of a body along x minus at the last.
        ``mass_imbalance``: inflow minus outflow over the flow rate of the reference velocity. ``backflow``: largest
        velocity into the fluid at the outlet over the reference velocity. ``pressure_drop_mean`` and
        ``pressure_drop_scatter``: over the last quarter of the time so far. ``separation_bottom`` and
        ``reattachment_bottom``: the first and last place x, from the inlet on, where the flow along a stepped wall
        changes its direction from forwards to back, and from back to forwards.
        """
        loads, flows = self.loads(snapshot), self.velocities(snapshot)
        found: dict[str, Any] = {**self.free_motions(snapshot), **loads, **flows}
        seen: Any = self.seen(snapshot)
        for name, body in zip(self.names[: self.count], seen.bodies, strict=False):
            pressure = self.density * self.reference_velocity**2 * float(np.ptp(body.shape.extent[:, 1])) / 2.0
            for kind in LOADS[:2]:
                load = loads[f"{kind}{name}"]
                found[f"{kind}_coefficient{name}"] = None if load is None else load / pressure
            outline = body.boundary_points(0.1 * self.wanted_spacing.smallest, snapshot.t).point
            ends = outline[[np.argmin(outline[:, 0]), np.argmax(outline[:, 0])]]
            found[f"pressure_difference{name}"] = -float(np.diff(self._pressures(snapshot, ends))[0])
        found |= {**self.balance(snapshot, flows), **self.drop_in_time(snapshot.t, series)}
        turns = {name: float(place[0]) for name, place in self._turns(snapshot).items()}
        places = {name: turns.get(name) for name in self._turning_names}
        return {**found, **places, **planar_diagnostics(self, snapshot)[1]}

    @property
    def _turning_names(self) -> list[str]:
        """Names of the places where the flow along stepped walls separates and reattaches."""
        return [f"{kind}_{side}" for side in self._stepped for kind in ("separation", "reattachment")]

    @property
    def _stepped(self) -> list[str]:
        """Sides of the walls that are no planes."""
        return [name[1:] for name, body in self._walls if not isinstance(body.shape, Line)]

    @property
    def _walls(self) -> list[tuple[str, Body]]:
        return list(zip(self.names, self.bodies, strict=True))[self.count : -2]

    def _turns(self, snapshot: Snapshot, on_one_part: bool = False) -> dict[str, np.ndarray]:
        """Return the places (2,) where the flow along stepped walls separates from them, and reattaches, by names.

        Where a wall is across the flow its direction is not known: ``on_one_part`` leaves out places beside that, and
        the start, at which the flow is none yet.
        """
        found: dict[str, np.ndarray] = {}
        if not self._stepped or (on_one_part and snapshot.t <= self.start_time):
            return found
        positions, velocity = with_walls(self, snapshot)
        if not (np.isfinite(positions).all() and np.isfinite(velocity).all()):
            return found
        tree, _ = periodic_tree(self, positions)
        for name, body in self._walls:
            if name[1:] not in self._stepped:
                continue
            boundary = body.boundary_points(0.5 * self.wanted_spacing.smallest)
            order = np.argsort(self.inlet.shape.normal[0] * boundary.point[:, 0], kind="stable")  # downstream
            point, normal = boundary.point[order], boundary.normal[order]
            fits, radius = local_fits(tree, point, velocity, 4)
            slopes = fits[:, 1:3] / radius[:, :, None]  # (points, along x or y, u or v)
            across = np.einsum("pk,pkc->pc", normal, slopes)
            along = across[:, 0] * np.abs(normal[:, 1]) - across[:, 1] * normal[:, 0] * np.sign(normal[:, 1])
            flat = np.abs(normal[:, 1]) > 0.7
            place, along = point[flat], along[flat] * self.inlet.shape.normal[0]
            for kind, sign, which in (("separation", 1.0, 0), ("reattachment", -1.0, -1)):
                turns = np.flatnonzero((sign * along[:-1] > 0.0) & (sign * along[1:] <= 0.0))
                k = turns[which] if len(turns) else 0
                near = np.linalg.norm(place[k + 1] - place[k]) < self.wanted_spacing.smallest
                if len(turns) and (near or not on_one_part):
                    share = along[k] / (along[k] - along[k + 1])
                    found[f"{kind}_{name[1:]}"] = place[k] + share * (place[k + 1] - place[k])
        return found

    def movie_marks(self, snapshot: Snapshot) -> list[tuple[str, float, float]]:
        """See ``Scene.movie_marks``: where the flow along stepped walls separates, and reattaches."""
        found = self._turns(snapshot, on_one_part=True)
        return [(name.partition("_")[0], float(x), float(y)) for name, (x, y) in found.items()]

    def profiles(self) -> list[Profile]:
        """Return both components of the velocity across the middle, u with Poiseuille flow where this is exact."""
        (u, v), flow = super().profiles(), self.initial_velocity
        low, high = self.inlet.shape.extent[:, 1]
        part = np.linspace(0.1, 0.9, 5)
        parabolic = np.allclose(self.inlet.profile.value(low + part * (high - low)), 6.0 * part * (1.0 - part))
        stepped = self._stepped or not self.isothermal
        if not (flow and parabolic and self._constant) or self.count or self.rheology or stepped:
            return [u, v]
        scale = self.reference_velocity, self.velocity_name("mean velocity")
        return [replace(u, exact=lambda x, y, t: flow(x + 0.0 * y * t, y + 0.0 * x * t)[0], scale=scale), v]

    def time_series(self) -> TimeSeries:
        """Return forces on the bodies, or on the walls without bodies, flow rates and the pressure drop, if finite.

        Also places and velocities of few free bodies, or only means of many.
        """
        walls = [] if self._jumps else [name for name, _ in self._walls]
        chosen = self.names[: self.count] or walls
        forces = [] if self._means_only else [(kind, name) for name in chosen for kind in LOADS[:2]]
        followed = [*forces, *self._motion_columns]
        numbers = [f"{kind}{name}" for kind, name in followed]
        force, speed = self.force_scale, self.reference_velocity
        through = speed * self.inlet.shape.length, "flow rate per length", "planar_flow_rate"
        flows = {"inflow": through, "outflow": through}
        if not self._jumps:
            flows["pressure_drop"] = self.density * speed**2, "pressure drop", "stress"

        def measure(snapshot: Snapshot) -> np.ndarray:
            found = {**self.loads(snapshot), **self.free_motions(snapshot), **self.velocities(snapshot)}
            return np.array([np.nan if found[name] is None else found[name] for name in (*numbers, *flows)])

        sizes = {**dict.fromkeys(LOADS, force), **self._motion_sizes}
        panels = {kind: (f"{kind} per length", "force") for kind in LOADS}
        panels = self._motion_panels if self.has_free_bodies else panels

        return TimeSeries(
            content="forces of the fluid on bodies, flow rates and the pressure drop, over time t",
            name="force per length",
            unit="force",
            scale=force,
            columns=[*numbers, *flows],
            labels=[*((name.replace("_", " "), None) for name in (*numbers, *flows))],
            measure=measure,
            sizes=[*(sizes[kind] for kind, _ in followed), *(size for size, _, _ in flows.values())],
            panels=[*(panels.get(kind) for kind, _ in followed), *((name, unit) for _, name, unit in flows.values())],
            drifting=[f"{kind}{name}" for kind, name in followed if kind in PLACES],
        )

    def movie_series(self) -> TimeSeries:
        """Return forces on the bodies, or how free ones move; without bodies places of stepped walls, or flow rates.

        The places are those where the flow separates and reattaches.
        """
        flows = ("inflow", "outflow"), "flow rate per length", "planar_flow_rate"
        if self.count or not self._stepped:
            return super().movie_series() if self.count else self.time_series().only(*flows)
        names = self._turning_names

        def measure(snapshot: Snapshot) -> np.ndarray:
            found = self._turns(snapshot, on_one_part=True)
            return np.array([found[name][0] if name in found else np.nan for name in names])

        return TimeSeries(
            content="places where the flow along stepped walls separates and reattaches, over time t",
            name="place x on the wall",
            unit="length",
            scale=self.reference_length,
            columns=names,
            labels=[(name.partition("_")[0] if len(names) == 2 else name.replace("_", " "), None) for name in names],
            measure=measure,
        )

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        length, speed = self.units.length, f"{self.units.length}/{self.units.time}"
        course, width = self.inlet.course, self.inlet.shape.length
        text = f"mean velocity up to {course.largest_speed:.6g} {speed}, width {width:.6g} {length}"
        if self.inlet.changing:
            text += "; its profile is that of developed flow whose mean velocity changes so"
        elif not self._constant:
            text += "; its profile is the given one times the mean velocity, and the flow behind it develops from that"
        return [*super().parameters(), ("inlet", text)]

    def _cause(self) -> tuple[bool, str]:
        """Return whether the reference velocity is known exactly, and its cause in words."""
        if not self.given_velocity and self.velocity_scale == self.inlet.course.largest_speed:
            return True, "the mean velocity through the inlet"
        return super()._cause()


@dataclass(frozen=True, kw_only=True)
class PressureStream(Stream):
    """Flow through a channel that the pressures of its ends drive: of the last two ``bodies``, the first is higher."""

    @classmethod
    def from_config(cls, config: Config) -> "Cell":
        """Return the scene that a validated config describes."""
        length, gap = config.geometry.length, config.geometry.gap
        walls, ends = walls_along(config), ends_of(config)
        bodies = bodies_of(config, {**walls, **ends})
        curvature = config.ends.pressure_drop / length / (2.0 * config.fluid.density * config.kinematic_viscosity)
        developed = DevelopedFlow(gap, 0.0, 0.0, curvature) if config.initial.state == "developed" else None
        return cls.around(config, bodies, {**walls, **ends}, walls=planes(walls), initial_velocity=developed)

    @property
    def inlet(self) -> Any:
        """The end with the higher pressure."""
        return self.bodies[-2]

    @property
    def _pressures_given(self) -> tuple[float, float]:
        """The higher and the lower pressure of the ends."""
        high, low = (body.pressure for body in self.bodies[-2:])  # type: ignore[attr-defined]
        return high, low

    @property
    def _drop(self) -> float:
        high, low = self._pressures_given
        return high - low

    @property
    def _through(self) -> float:
        """Mean velocity of developed flow, at most that which inertia allows."""
        viscous = self._drop / self.size[0] * self.inlet.shape.length**2 / (12.0 * self.dynamic_viscosity)
        return min(viscous, math.sqrt(2.0 * self._drop / self.density))

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times at which a body enters; the pressures are constant."""
        return tuple(sorted(self._entry_times))

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """See ``Scene.drive_shown``."""
        return "pressure drop", "stress", (float(self._drop * self.inlet.shape.normal[0]), 0.0)

    def drive_share(self, t: float) -> float | None:
        """See ``Scene.drive_share``."""
        return None

    @property
    def _constant(self) -> bool:
        return True

    @property
    def _jumps(self) -> bool:
        return False

    def profiles(self) -> list[Profile]:
        """Return both components of the velocity across the middle."""
        return Cell.profiles(self)

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        (high, low), unit = self._pressures_given, f"{self.units.mass}/({self.units.length} {self.units.time}^2)"
        return [*Cell.parameters(self), ("ends", f"pressures {high:.6g} and {low:.6g} {unit}")]

    def _cause(self) -> tuple[bool, str]:
        return Cell._cause(self)
