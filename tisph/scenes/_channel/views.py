"""What is looked at in a channel: profiles across it, probes, the movie, and in words what the flow is."""

import numpy as np

from tisph.measures.channel import Probes
from tisph.scenes._channel import flow
from tisph.scenes._views import Line, Profile, TimeSeries

MINUS = "\N{MINUS SIGN}"
_TIMES, _HEIGHTS = 40, 51  # at which it is looked for a flow that reverses
_WALL_TIMES = 2000  # a wall that oscillates is looked at more often: it costs nothing, and there speeds peak
_SMALL = 0.01  # of the largest speed: a flow slower than that counts as none


def profiles(channel):
    """Velocity with its error; with polymer also its shear stress and first normal stress difference N1."""
    speed = _velocity(channel)
    if channel.polymer is None:
        return [speed]
    return [speed, _shear_stress(channel), _normal_stress(channel)]


def probes(channel, count, x="centre"):
    """Velocities at ``count`` heights on a vertical line; arguments as ``Channel.probe_positions``."""
    places = channel.probe_positions(count, x)
    heights, probes = places[1], Probes(channel, *places)
    return TimeSeries(
        content="velocities u along x over time t at probes at heights y",
        name="u",
        unit="velocity",
        scale=channel.reference_velocity,
        columns=[f"u(y={y:.6g})" for y in heights],
        labels=[("y/H", y / channel.gap) for y in heights],
        exact_columns=[f"u_exact(y={y:.6g})" for y in heights],
        measure=probes.velocity,
        exact=lambda times: channel.exact_velocity(heights, times[:, None]),
        places=heights,
        angular_frequency=max(wall.angular_frequency for _, wall in channel.walls),
        probes=probes,
    )


def movie_profiles(channel):
    """The velocity, and the stresses of a polymer."""
    names = "speed", "shear_stress", "normal_stress_difference"
    return dict(zip(names, profiles(channel), strict=False))


def movie_ends(channel, name, profile, end):
    """Smallest and largest value of a ``profile`` to time ``end``, those of the walls among velocities."""
    walls = () if profile.unit == "stress" else _wall_extremes(channel, end)
    return [*profile.extremes(channel.start_time, end), *walls]


def movie_series(channel):
    """Velocities at three heights."""
    return probes(channel, 3)


def vanishing_scale(channel):
    """Tell whether the exact velocity takes both signs at any time, or decays.

    The flow itself decides, not the length of a run: the same flow has the same error measure everywhere.
    """
    if any(wall.oscillates or wall.stress_controlled for wall in (channel.bottom, channel.top)):
        return True
    slowest = max(channel.viscous_time, channel.polymer.relaxation_time if channel.polymer else 0.0)
    # The slowest mode decays as exp(-pi^2 t*): at t* = 3 nothing of a start is left.
    times = channel.start_time + 3.0 * slowest * np.linspace(0.0, 1.0, _TIMES) ** 2
    u = channel.exact_velocity(np.linspace(0.0, channel.gap, _HEIGHTS)[:, None], times[None, :])
    u -= channel.frame_velocity
    small = _SMALL * np.abs(u).max()
    return bool((u.min() < -small and u.max() > small) or np.abs(u[:, -1]).max() <= small)


def parameters(channel):
    """Pairs (label, text) of what the flow is, independent of particles."""
    length, time = channel.units.length, channel.units.time
    by_walls = channel.velocity_scale == channel.wall_speed
    linear = channel.rheology is None or channel.rheology.type == "oldroyd_b"
    driven = any(wall.stress_controlled for wall in (channel.bottom, channel.top))
    own = not channel.given_velocity and (driven or not by_walls)
    moving = f", in a frame that moves with {channel.frame_velocity:.6g} {length}/{time}"
    frame = moving if channel.frame_velocity else ""
    fluid = "" if linear or not own else ", in a Newtonian fluid of the viscosity nu"
    speed = f"{channel.reference_velocity:.6g} {length}/{time}{frame}{fluid}"
    lines = [
        ("Reynolds number", f"{channel.reynolds:.6g}  (U H / nu)"),
        (channel.velocity_name("wall speed U" if by_walls else "mean speed U"), speed),
        ("length H", f"{channel.gap:.6g} {length}, the gap"),
        ("kinematic viscosity nu", f"{channel.kinematic_viscosity:.6g} {length}^2/{time}"),
        ("viscous time H^2/nu", f"{channel.viscous_time:.6g} {time}"),
    ]
    if channel.acceleration:
        mean, text = flow.driven_mean_velocity(channel), f"{channel.acceleration:.6g} {length}/{time}^2 along x"
        if mean is not None:
            text += f", of which the developed flow has the mean speed {mean:.{6 if linear else 4}g} {length}/{time}"
        lines.append(("drive", text))
    for name, wall in reversed(channel.walls):
        if wall.angular_frequency:
            depth = wall.penetration_depth(channel.kinematic_viscosity)
            text = f"{depth:.4g} {length}, {depth / channel.spacing:.3g} spacings  (sqrt(2 nu / w), {name} wall)"
            lines.append(("penetration depth", text))
    if channel.polymer:
        lines.append(("Weissenberg number", f"{channel.weissenberg:.4g}  (relaxation time * U / H)"))
        lines.append(("elasticity number", f"{channel.elasticity:.4g}  (relaxation time * nu / H^2)"))
    return lines


def _line(channel):
    """All particles: nothing depends on x."""
    return Line("y", (0.0, channel.gap), place=0.5 * channel.length)


def _velocity(channel):
    return Profile(
        name="u",
        unit="velocity",
        line=_line(channel),
        of=lambda snapshot: snapshot.u,
        exact=lambda x, y, t: channel.exact_velocity(y, t),
        scale=(channel.reference_velocity, "reference velocity U"),
    )


def _shear_stress(channel):
    return Profile(
        name="polymer shear stress Sxy",
        unit="stress",
        line=_line(channel),
        of=lambda snapshot: snapshot.stress_xy,
        exact=lambda x, y, t: channel.exact_polymer_shear_stress(y, t),
    )


def _normal_stress(channel):
    return Profile(
        name=f"first normal stress difference N1 = Sxx {MINUS} Syy",
        unit="stress",
        line=_line(channel),
        of=lambda snapshot: snapshot.stress_xx - snapshot.stress_yy,
        exact=lambda x, y, t: channel.exact_polymer_stress(y, t)[0] - channel.exact_transverse_stress(y, t),
    )


def _wall_extremes(channel, end):
    times = np.linspace(channel.start_time, end, _WALL_TIMES)
    walls = [wall for _, wall in reversed(channel.walls)]
    velocities = np.concatenate([wall.velocity(times) for wall in walls])
    if channel.start_time == 0.0:  # the fluid still has the velocity that a wall had before
        velocities = np.append(velocities, [wall.before for wall in walls if wall.before is not None])
    return float(velocities.min()), float(velocities.max())
