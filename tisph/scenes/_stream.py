"""A channel with open ends: fluid enters at one of them and leaves at the other, past bodies and steps of the walls.

``Stream`` is the scene of a channel with ``ends``. It records forces on the bodies, inflow and outflow, and
the pressures of both ends.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from tisph.config.base import Problem
from tisph.config.ends import Table
from tisph.config.schema import Config
from tisph.exact._fluids import fluid_of
from tisph.exact.flow_rate import ChangingProfile
from tisph.exact.uniform_shear import UniformShear
from tisph.geometry.body import Body
from tisph.geometry.ends import LEAST_DISTANCE, Course, Inlet, InletProfile, OpenEnd, Outlet
from tisph.geometry.line import Line
from tisph.geometry.motion import Schedule, WallMotion
from tisph.geometry.packing import pack
from tisph.geometry.region import Region
from tisph.measures.fits import BAND, interpolated, local_fits, periodic_tree, with_walls
from tisph.scenes._cell import Cell, DevelopedFlow, bodies_of, planes, walls_along
from tisph.scenes._cell_flow import LOADS, PLACES, VELOCITY
from tisph.scenes._scene import BodyScene
from tisph.scenes._views import Profile, TimeSeries, planar_diagnostics
from tisph.snapshot import Snapshot

JITTER = 0.3
"""Least random displacement of the particles at first, in spacings: columns of a lattice would leave all at once, and
leave a void at the outlet."""

BEYOND = 4, 40
"""Degree and number of particles of fits that extrapolate a pressure to walls and ends."""


LARGEST_BACKFLOW = 0.01
"""Largest velocity into the fluid at an outlet in a resolved sample, over the reference velocity: that fluid has an
unknown past, and an outlet without stress may become unstable with it."""

LARGEST_IMBALANCE = 0.01
"""Largest difference of the flow rates through inlet and outlet in a resolved sample, over the reference velocity times
the width of the inlet: velocities behind a body or a step have at least this error."""


def course_of(given: Any) -> Any:
    """Return the mean velocity over time of an inlet of a config."""
    if given.velocities:
        return Schedule(given.times, given.velocities)
    wave = WallMotion(0.0)
    if given.amplitude is not None:
        cosine, sine = (given.amplitude, 0.0) if given.phase == "cos" else (0.0, given.amplitude)
        wave = WallMotion(cosine, sine, given.angular_frequency)
    return Course(given.velocity or 0.0, wave)


def heights_at(config: Config, side: str) -> tuple[float, float]:
    """Return the heights of the bottom and the top wall at the end ``side`` (left, right) of the channel.

    Around an axis these are the radii of the inner and the outer wall.
    """
    end, lowest = 0 if side == "left" else -1, config.geometry.inner_radius if config.axisymmetric else 0.0
    walls = (getattr(config.walls, name, None) for name in ("bottom", "top"))
    low, high = (wall.outline[end][1] if wall and getattr(wall, "outline", None) else None for wall in walls)
    return lowest if low is None else low, lowest + config.extent[1] if high is None else high


def end_lines(config: Config) -> dict[str, Line]:
    """Return the lines of the ``left`` and ``right`` end of a channel, whose normals are into the fluid."""
    (left_low, left_high), (low, high) = (heights_at(config, side) for side in ("left", "right"))
    return {
        "left": Line((0.0, left_high), (0.0, -1.0), left_high - left_low),
        "right": Line((config.extent[0], low), (0.0, 1.0), high - low),
    }


def inlet_and_outlet(config: Config) -> dict[str, Any]:
    """Return the ``Inlet`` and the ``Outlet`` of a ``config``, in this order, by their sides."""
    places, around = end_lines(config), config.axisymmetric
    sides = sorted(places, key=lambda side: getattr(config.ends, side).type)
    heights = heights_at(config, sides[0])
    profile = profile_of(config, *heights)
    inlet = Inlet(
        shape=places[sides[0]],
        axisymmetric=around,
        profile=profile,
        course=course_of(config.ends.inlet),
        changing=changing_profile(config, profile, *heights),
    )
    return {sides[0]: inlet, sides[1]: Outlet(shape=places[sides[1]], axisymmetric=around)}


@dataclass(frozen=True)
class InletFlow:
    """The flow of an ``inlet`` everywhere."""

    inlet: Inlet

    def __call__(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the velocities (2, ...) along x and y at t = 0; with the swirl (3, ...) around an axis."""
        places = np.stack([np.ravel(x), np.ravel(y)], axis=1)
        found = self.inlet.velocity(places).T
        if self.inlet.axisymmetric:
            found = np.append(found, [places[:, 1] * self.inlet.turning(places[:, 1])], axis=0)
        return found.reshape(len(found), *np.shape(x))


def changing_profile(config: Config, profile: InletProfile, low: float, high: float) -> ChangingProfile | None:
    """Return what the profile of developed flow has beside ``profile`` times the mean velocity; None for nothing.

    Developed flow has nothing else where its mean velocity is constant, and without inertia.
    """
    given, course = config.ends.inlet, course_of(config.ends.inlet)
    changes = given.velocities or given.amplitude
    if given.profile != "developed" or not changes or not config.fluid.inertia or depends_on_flow_rate(config):
        return None
    rheology = config.fluid.rheology if config.fluid.polymer else None
    fluid: Any = fluid_of(rheology, config.kinematic_viscosity, config.fluid.density)
    modes = [(law.relaxation_time, law.polymer_viscosity) for law in fluid.laws]
    return ChangingProfile(low, high, profile.value, fluid.solvent_viscosity, modes, course, config.axisymmetric)


def least_inflow(config: Config) -> tuple[float, float]:
    """Return the smallest mean velocity through the inlet of a ``config`` during its run, and its time."""
    given, course, times = config.ends.inlet, course_of(config.ends.inlet), [0.0, config.time.end]
    if given.velocities:
        times += given.times
    elif given.amplitude is not None:
        lowest = math.atan2(course.wave.sine, course.wave.cosine) + math.pi
        times.append(lowest % (2.0 * math.pi) / given.angular_frequency)
    return min((float(course.velocity(t)), t) for t in times if t <= config.time.end)


def depends_on_flow_rate(config: Config) -> bool:
    """Return whether the profile of the inlet changes with its mean velocity: developed flow of a non-linear fluid."""
    return config.ends.inlet.profile == "developed" and config.fluid.rheology.type not in ("newtonian", "oldroyd_b")


def profile_of(config: Config, low: float, high: float) -> InletProfile:
    """Return the profile of the inlet of a ``config`` between these heights, with a mean of 1."""
    from scipy.interpolate import CubicSpline

    if config.axisymmetric:
        return _profile_around_axis(config, low, high)
    given, width = config.ends.inlet.profile, high - low
    if given == "uniform" or (not depends_on_flow_rate(config) and given in ("developed", "parabolic")):
        part = Polynomial([-low, 1.0]) / width
        value = Polynomial([1.0]) if given == "uniform" else 6.0 * part * (1.0 - part)
        return InletProfile(value, value.deriv())
    if depends_on_flow_rate(config):
        fluid = fluid_of(config.fluid.rheology, config.kinematic_viscosity, config.fluid.density)
        flow = UniformShear(fluid.flux, fluid.laws)
        distances, rates = flow.developed(config.ends.inlet.velocity, width)
        heights = 0.5 * (low + high) + np.concatenate([-distances[:0:-1], distances])
        profile = CubicSpline(heights, np.concatenate([rates[:0:-1], -rates])).antiderivative()
    else:
        profile = CubicSpline(low + np.array(given.heights), given.velocities)
    profile.c *= width / profile.integrate(low, high)
    return InletProfile(profile, profile.derivative())


@dataclass(frozen=True)
class BetweenPipes:
    """Developed flow of a Newtonian fluid between radii r_1 = ``low`` and R = ``high``, with a mean velocity of 1.

    With q = r/R and k = r_1/R, u = 2 (1 - q^2 - (1 - k^2) ln q/ln k) / (1 + k^2 + (1 - k^2)/ln k), and 2 (1 - q^2) for
    k = 0. Source: R. B. Bird, W. E. Stewart, E. N. Lightfoot, Transport Phenomena (2002), section 2.4.
    """

    low: float
    high: float

    def value(self, r: np.ndarray) -> np.ndarray:
        """Return the velocity at each radius."""
        part, scale = self._parts
        return scale * (1.0 - (r / self.high) ** 2 - (part * np.log(r / self.high) if self.low else 0.0))

    def slope(self, r: np.ndarray) -> np.ndarray:
        """Return the derivative of ``value``."""
        part, scale = self._parts
        return -scale * (2.0 * r / self.high**2 + (part / r if self.low else 0.0))

    @property
    def _parts(self) -> tuple[float, float]:
        k = self.low / self.high
        part = (1.0 - k**2) / math.log(k) if self.low else 0.0
        return part, 2.0 / (1.0 + k**2 + part)


def _profile_around_axis(config: Config, low: float, high: float) -> InletProfile:
    """Return the profile over the radius from ``low`` to ``high``, with a mean of 1 over the area of the inlet."""
    from scipy.interpolate import CubicSpline

    given, area = config.ends.inlet.profile, 0.5 * (high**2 - low**2)
    if given == "uniform":
        return InletProfile(Polynomial([1.0]), Polynomial([0.0]))
    if not depends_on_flow_rate(config) and given in ("developed", "parabolic"):
        between = BetweenPipes(low, high)
        return InletProfile(between.value, between.slope)
    if depends_on_flow_rate(config):
        fluid = fluid_of(config.fluid.rheology, config.kinematic_viscosity, config.fluid.density)
        flow = UniformShear(fluid.flux, fluid.laws)
        distances, rates = flow.developed(config.ends.inlet.velocity, 2.0 * high, pipe=True)
        profile = CubicSpline(distances, -rates).antiderivative()
        profile.c[-1] -= profile(high)
    else:
        even = ((1, 0.0), "not-a-knot") if not low else "not-a-knot"
        profile = CubicSpline(low + np.array(given.heights), given.velocities, bc_type=even)
    once = profile.antiderivative()
    twice = once.antiderivative()
    profile.c *= area / (high * once(high) - low * once(low) - (twice(high) - twice(low)))  # integral of r u dr
    return InletProfile(profile, profile.derivative())


def end_problems(config: Config) -> Iterator[Problem]:
    """Yield the errors in the config of a flow through open ends."""
    if config.drive.acceleration:
        yield "drive.acceleration", "must be 0: the inlet drives the flow"
    if 0.0 < config.initial.jitter < JITTER:
        text = f"must be 0, which means {JITTER:g}, or {JITTER:g} to 0.5 with open ends"
        yield "initial.jitter", f"{text}: columns of a lattice would leave all at once"
    yield from profile_problems(config)


def profile_problems(config: Config) -> Iterator[Problem]:
    """Yield the error in the profile of the inlet of a ``config``, if there is one."""
    if not config.ends.inlet:
        return
    side = "left" if config.ends.inlet is config.ends.left else "right"
    given, (low, high) = config.ends.inlet.profile, heights_at(config, side)
    width, key = high - low, f"ends.{side}.profile"
    least, when = least_inflow(config)
    if least < -1e-9 * course_of(config.ends.inlet).largest_speed:
        text = f"lets fluid out through the inlet: its mean velocity is {least:.4g} at t = {when:.4g}"
        changing = "velocities" if config.ends.inlet.velocities else "amplitude"
        yield f"ends.{side}.{changing}", f"{text}; the inflow must not reverse"
    if depends_on_flow_rate(config) and (config.ends.inlet.velocities or config.ends.inlet.amplitude):
        text = "must be parabolic, uniform or a table where the mean velocity changes"
        yield key, f"{text}: a developed {config.fluid.rheology.type} flow has another profile at each velocity"
    if config.singular and config.fluid.polymer:
        text = f"must be 0 at walls with {config.fluid.rheology.type}: the stress would be infinite at the corners"
        yield key, f"{text}; take developed, parabolic, or a table from 0 to 0"
    if not isinstance(given, Table):
        return
    if abs(given.heights[-1] - width) > 1e-9 * width:
        yield f"{key}.heights", f"must end at the width of the inlet, {width:.12g}"
        return
    if profile_of(config, low, high).value(np.linspace(low, high, 1000)).min() < -1e-9:
        yield f"{key}.velocities", "must be more points: the cubic spline through these is negative in between"


class OpenEnded(BodyScene):
    """Members of scenes whose last two ``bodies`` are an inlet and an outlet, or two outlets."""

    @cached_property
    def _filled(self) -> Region:
        """The part of the region in which there are particles: the ends are moved into it."""
        clear = LEAST_DISTANCE * self.spacing
        moved = [
            replace(body, centre=tuple(clear * body.shape.normal)) if isinstance(body, OpenEnd) else body
            for body in self.region.bodies
        ]
        return replace(self.region, bodies=tuple(moved))

    @cached_property
    def particles(self) -> int:
        """Number of fluid particles."""
        clear = LEAST_DISTANCE * self.spacing * sum(end.shape.length for end in self.bodies[-2:])
        return round((self.region.area - clear) / self.spacing**2)

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return x, y (particles,) of particles that fill the region."""
        x, y = pack(self._filled, self.spacing, max(jitter, JITTER), seed, self.particles).T
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
        return "inlet" if self._constant else "inlet up to", "velocity", (float(along), 0.0)

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
        """Return a short text and the reason if fluid flows back in, or if flow rates differ, else None."""
        if snapshot.backflow is not None and snapshot.backflow > LARGEST_BACKFLOW * self.reference_velocity:
            found = snapshot.backflow / self.reference_velocity
            text = f"fluid flows in through the outlet, with up to {found:.2g} of the reference velocity"
            return f"backflow {found:.2g}", f"{text}; resolved up to {LARGEST_BACKFLOW:g}: move the outlet away"
        if snapshot.flow_rates is not None:
            found = abs(snapshot.flow_rates.sum()) / (self.reference_velocity * self.inlet.shape.length)
            if found > LARGEST_IMBALANCE:
                text = f"flow rates through inlet and outlet differ by {found:.2g} of that of the reference velocity"
                return f"flow rates differ by {found:.2g}", f"{text}; resolved up to {LARGEST_IMBALANCE:g}"
        return None

    def balance(self, snapshot: Snapshot, flows: Mapping[str, float]) -> dict[str, float]:
        """Return ``mass_imbalance`` and ``backflow``, for the ``velocities`` of a snapshot, ``flows``."""
        imbalance = (flows["inflow"] - flows["outflow"]) / (self.reference_velocity * self.inlet.area)
        return {"mass_imbalance": imbalance, "backflow": (snapshot.backflow or 0.0) / self.reference_velocity}

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
        walls, ends = walls_along(config), inlet_and_outlet(config)
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
        places = [f"{kind}_{side}" for side in self._stepped for kind in ("separation", "reattachment")]
        return (*moved, *(["pressure_drop"] if not self._jumps else []), *places)

    def thinnest_layer(self, t: float) -> tuple[float, str]:
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
        velocity into the fluid at the outlet over the reference velocity. ``separation_bottom`` and
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
            outline = body.boundary_points(0.1 * self.spacing, snapshot.t).point
            ends = outline[[np.argmin(outline[:, 0]), np.argmax(outline[:, 0])]]
            found[f"pressure_difference{name}"] = -float(np.diff(self._pressures(snapshot, ends))[0])
        found |= self.balance(snapshot, flows)
        return {**found, **self._turns(snapshot), **planar_diagnostics(self, snapshot)[1]}

    @property
    def _stepped(self) -> list[str]:
        """Sides of the walls that are no planes."""
        return [name[1:] for name, body in self._walls if not isinstance(body.shape, Line)]

    @property
    def _walls(self) -> list[tuple[str, Body]]:
        return list(zip(self.names, self.bodies, strict=True))[self.count : -2]

    def _turns(self, snapshot: Snapshot) -> dict[str, float | None]:
        """Return the places where the flow along stepped walls separates from them, and reattaches."""
        found: dict[str, float | None] = {}
        if not self._stepped:
            return found
        positions, velocity = with_walls(self, snapshot)
        if not (np.isfinite(positions).all() and np.isfinite(velocity).all()):
            return found
        tree, _ = periodic_tree(self, positions)
        for name, body in self._walls:
            if name[1:] not in self._stepped:
                continue
            boundary = body.boundary_points(0.5 * self.spacing)
            order = np.argsort(self.inlet.shape.normal[0] * boundary.point[:, 0], kind="stable")  # downstream
            point, normal = boundary.point[order], boundary.normal[order]
            fits, radius = local_fits(tree, point, velocity, 4)
            slopes = fits[:, 1:3] / radius[:, :, None]  # (points, along x or y, u or v)
            across = np.einsum("pk,pkc->pc", normal, slopes)
            along = across[:, 0] * np.abs(normal[:, 1]) - across[:, 1] * normal[:, 0] * np.sign(normal[:, 1])
            flat = np.abs(normal[:, 1]) > 0.7
            x, along = point[flat, 0], along[flat] * self.inlet.shape.normal[0]
            for kind, sign, which in (("separation", 1.0, 0), ("reattachment", -1.0, -1)):
                turns = np.flatnonzero((sign * along[:-1] > 0.0) & (sign * along[1:] <= 0.0))
                k = turns[which] if len(turns) else None
                place = None if k is None else float(x[k] + (x[k + 1] - x[k]) * along[k] / (along[k] - along[k + 1]))
                found[f"{kind}_{name[1:]}"] = place
        return found

    def profiles(self) -> list[Profile]:
        """Return both components of the velocity across the middle, u with Poiseuille flow where this is exact."""
        (u, v), flow = super().profiles(), self.initial_velocity
        low, high = self.inlet.shape.extent[:, 1]
        part = np.linspace(0.1, 0.9, 5)
        parabolic = np.allclose(self.inlet.profile.value(low + part * (high - low)), 6.0 * part * (1.0 - part))
        if not (flow and parabolic and self._constant) or self.count or self.rheology or self._stepped:
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
        """Return forces on the bodies, or how free ones move; without bodies the flow rates."""
        flows = ("inflow", "outflow"), "flow rate per length", "planar_flow_rate"
        return super().movie_series() if self.count else self.time_series().only(*flows)

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
        walls = walls_along(config)
        pressures = {side: getattr(config.ends, side).pressure or 0.0 for side in ("left", "right")}
        places = end_lines(config)
        ends = {
            side: Outlet(shape=places[side], pressure=pressures[side])
            for side in sorted(pressures, key=lambda side: -pressures[side])
        }
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
