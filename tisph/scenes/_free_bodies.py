"""What is followed of the bodies that the flow carries: where each is and how it moves, or means of many."""

import numpy as np

from tisph.scenes._views import TimeSeries

MOST = 6
"""Bodies that are followed one by one; of more, which no table or picture can show, means are."""

PLACES = ("x", "y", "angle")
MOTIONS = ("u", "v", "angular_velocity")
MEANS = ("bodies_mean_u", "bodies_mean_v", "bodies_mean_angular_speed")
SHOWN = 3
"""Bodies in a movie's panel."""

UNITS = {"x": "length", "y": "length", "angle": "angle", "u": "velocity", "v": "velocity", "angular_velocity": "rate"}
UNITS |= {"bodies_mean_u": "velocity", "bodies_mean_v": "velocity", "bodies_mean_angular_speed": "rate"}


def numbers(cell):
    """Those of the free bodies among all (free,)."""
    return [index for index, body in enumerate(cell.bodies) if body.free]


def are_many(cell):
    """Whether there are more than are followed one by one."""
    return len(numbers(cell)) > MOST


def columns(cell):
    """Pairs of a kind, a key of ``UNITS``, and the name of its body, as in ``drag_0``; of means that of none."""
    if are_many(cell):
        return [(kind, "") for kind in MEANS]
    return [(kind, cell.names[index]) for index in numbers(cell) for kind in (*PLACES, *MOTIONS)]


def states(cell, snapshot):
    """Values of the ``columns`` by name: places [length], not wrapped by periods, angles [radians], velocities."""
    chosen, bodies = numbers(cell), snapshot.bodies
    if not chosen:
        return {}
    if are_many(cell):
        mean = bodies.velocity[chosen].mean(axis=0)
        values = [*mean, np.abs(bodies.angular_velocity[chosen]).mean()]
    else:
        parts = bodies.centre, bodies.angle[:, None], bodies.velocity, bodies.angular_velocity[:, None]
        values = np.hstack([part[chosen] for part in parts]).ravel()
    return {f"{kind}{name}": float(value) for (kind, name), value in zip(columns(cell), values, strict=True)}


def sizes(cell):
    """Size of each kind, for axes and for what counts as a change."""
    length, speed = cell.reference_length, cell.reference_velocity
    by_unit = {"length": length, "angle": 1.0, "velocity": speed, "rate": speed / length}
    return {kind: by_unit[unit] for kind, unit in UNITS.items()}


def panels(cell):
    """Axes of the picture by kind, a name and a unit: places of few bodies, velocities of many."""
    kinds = MEANS if are_many(cell) else PLACES
    words = {"bodies_mean_u": "mean velocity of bodies", "bodies_mean_v": "mean velocity of bodies"}
    words |= {"bodies_mean_angular_speed": "mean angular speed of bodies"}
    return {kind: (words.get(kind, kind), UNITS[kind]) for kind in kinds}


def words(kind, name):
    """What a number is called in a legend."""
    if kind in MEANS:
        return {"u": "along x", "v": "along y", "d": "all bodies"}[kind[-1]]
    return f"body {name.lstrip('_')}".rstrip()


def movie_series(cell):
    """Heights of the first few bodies, of many their mean velocities."""
    kinds = MEANS[:2] if are_many(cell) else ("y",)
    found = [(kind, name) for kind, name in columns(cell) if kind in kinds][:SHOWN]
    chosen = [f"{kind}{name}" for kind, name in found]
    name, unit = panels(cell)[kinds[0]]

    def measure(snapshot):
        values = states(cell, snapshot)
        return np.array([values[column] for column in chosen])

    return TimeSeries(
        content="places or velocities of bodies over time t",
        name=name,
        unit=unit,
        scale=sizes(cell)[kinds[0]],
        columns=chosen,
        labels=[(words(*each), None) for each in found],
        measure=measure,
    )
