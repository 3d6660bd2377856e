"""Open ends of a config: places, profiles and courses of inlets, their errors, and the limits of a resolved flow.

An inlet has the profile of the fluid's own developed flow, a parabola, a uniform velocity, or a table.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
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
from tisph.geometry.ends import Course, Inlet, InletProfile, Outlet
from tisph.geometry.line import Line
from tisph.geometry.motion import Schedule, WallMotion
from tisph.snapshot import Snapshot

JITTER = 0.3
"""Least random displacement of the particles at first, in spacings: columns of a lattice would leave all at once, and
leave a void at the outlet."""

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


def ends_of(config: Config) -> dict[str, Any]:
    """Return the ``Inlet`` and the ``Outlet`` of a ``config``, in this order, by their sides.

    Without an inlet the two ends with given pressures, the higher one first.
    """
    places, around = end_lines(config), config.axisymmetric
    if not config.ends.inlet:
        pressures = {side: getattr(config.ends, side).pressure or 0.0 for side in ("left", "right")}
        sides = sorted(pressures, key=lambda side: -pressures[side])
        return {side: Outlet(shape=places[side], pressure=pressures[side]) for side in sides}
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
    """Return the velocity of developed flow beside ``profile`` times the mean velocity.

    None where the mean velocity is constant, and without inertia: there is no other.
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
    return config.ends.inlet.profile == "developed" and not config.fluid.linear


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
    side = config.ends.inlet_side
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


def stream_problems(config: Config, walls: dict[str, Body]) -> Iterator[Problem]:
    """Yield the errors in a ``config`` with open ends around an axis, between ``walls`` by their keys."""
    given = config.ends.inlet
    if given is None:
        yield "ends", "must be an inlet and an outlet: around an axis no pressures drive a flow yet"
        return
    for key, wall in walls.items():
        if wall.motion.x.largest_speed:
            yield key, "must not move along the axis: with open ends walls may only turn"
        if wall.spin.oscillates or wall.spin.jump_times:
            yield key, "must turn at a constant rate: with open ends the fluid enters with the swirl of the walls"
    if config.fluid.polymer:
        yield (
            "fluid.rheology.type",
            f"must have no polymer with open ends around an axis, as {config.fluid.rheology.type} has",
        )
    if depends_on_flow_rate(config) and config.geometry.inner_radius:
        text = "must be parabolic, uniform or a table between two walls"
        yield f"ends.{config.ends.inlet_side}.profile", f"{text}: no other developed flow is built in"
        return
    yield from end_problems(config)


def unresolved(snapshot: Snapshot, speed: float, width: float) -> tuple[str, str] | None:
    """Return a short text and the reason if fluid flows back in, or if flow rates differ, else None.

    ``speed``: reference velocity of the flow; ``width`` of the inlet.
    """
    if snapshot.backflow is not None and snapshot.backflow > LARGEST_BACKFLOW * speed:
        found = snapshot.backflow / speed
        text = f"fluid flows in through the outlet, with up to {found:.2g} of the reference velocity"
        return f"backflow {found:.2g}", f"{text}; resolved up to {LARGEST_BACKFLOW:g}: move the outlet away"
    if snapshot.flow_rates is not None:
        found = abs(snapshot.flow_rates.sum()) / (speed * width)
        if found > LARGEST_IMBALANCE:
            text = f"flow rates through inlet and outlet differ by {found:.2g} of that of the reference velocity"
            return f"flow rates differ by {found:.2g}", f"{text}; resolved up to {LARGEST_IMBALANCE:g}"
    return None
