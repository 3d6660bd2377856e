"""What a rheometer reads of a channel, in time: stress at the walls, their velocities, normal stress, strain."""

import numpy as np

from tisph.measures.channel import integral, wall_shear, wall_velocity
from tisph.scenes._views import ExtraSeries

SIDES = ("bottom", "top")


def extra_series(channel):
    """Return the ``ExtraSeries`` of a ``channel``.

    None of a Newtonian fluid between walls of which none is stress-controlled or follows a schedule.
    """
    plain = channel.polymer is None and channel.rheology is None
    if plain and not any(wall.stress_controlled or wall.jump_times for wall in (channel.bottom, channel.top)):
        return None
    columns = [f"{name}_{side}" for name in ("wall_shear", "wall_velocity") for side in SIDES]
    return ExtraSeries(
        columns=[*columns, "n1_mean"] if channel.polymer else columns,
        measure=lambda snapshot: _measure(channel, snapshot),
        final_columns=["strain", *(f"{name}_exact" for name in columns)],
        final=lambda times, values: _final(channel, times, values),
    )


def _measure(channel, snapshot):
    """Shear stress and velocity of both walls, and N1 = S_xx - S_yy of the polymer, mean over the fluid."""
    velocities = [
        wall_velocity(channel, side, snapshot) if wall.stress_controlled else float(wall.velocity(snapshot.t))
        for side, wall in enumerate((channel.bottom, channel.top))
    ]
    normal = [np.mean(snapshot.stress_xx - snapshot.stress_yy)] if channel.polymer else []
    return np.array([*wall_shear(channel, snapshot), *velocities, *normal])


def _final(channel, times, values):
    """Strain, the way of the upper wall less that of the lower one over the gap; exact stresses and velocities.

    That of a stress-controlled wall is the integral of the velocities that the particles show.
    """
    ways = [
        integral(times, values[:, 2 + side]) if wall.stress_controlled else wall.displacement(times)
        for side, wall in enumerate((channel.bottom, channel.top))
    ]
    walls = [wall for _, wall in reversed(channel.walls)]
    exact = [*channel.exact_wall_shear(times), *(wall.velocity(times) for wall in walls)]
    strain = (ways[1] - ways[0]) / channel.gap
    return np.column_stack([strain, *(np.where(np.isfinite(one), one, np.nan) for one in exact)])
