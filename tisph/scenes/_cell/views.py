"""What is looked at in a cell with bodies: centre lines, forces over time, the movie, and in words what the flow is."""

import numpy as np

from tisph.bodies import _clearance
from tisph.measures import resolution
from tisph.scenes import _two_dimensional
from tisph.scenes._cell import diagnostics
from tisph.scenes._views import TimeSeries

VELOCITY = "superficial_velocity"
UNITS = {"drag": "force", "lift": "force", "torque": "torque"}


def profiles(cell):
    """Both components of the velocity along the vertical centre line."""
    return [_two_dimensional.velocity_profile(cell, field, "y") for field in "uv"]


def time_series(cell):
    """Forces and torques on the bodies in the fluid, or on its walls where there are none, and the mean velocity."""
    chosen = slice(cell.count or None)
    pairs = zip(cell.names[chosen], cell.bodies[chosen], strict=True)
    followed = [(kind, name) for name, body in pairs for kind in diagnostics.kinds(body)]
    columns = [f"{kind}{name}" for kind, name in followed]
    force, speed = cell.force_scale, cell.reference_velocity
    sizes = {"drag": force, "lift": force, "torque": force * cell.reference_length}
    of = "body" if cell.count else "wall"
    alone = len(cell.bodies) == cell.count == 1 and not cell.fastest_body  # it carries all that drives the fluid
    drive = cell.density * cell.acceleration * cell.region.area

    def measure(snapshot):
        found = diagnostics.loads(cell, snapshot)
        values = [np.nan if found[column] is None else found[column] for column in columns]
        return np.array([*values, diagnostics.velocities(cell, snapshot)[VELOCITY]])

    return TimeSeries(
        content="forces and torques of the fluid on bodies, and the mean velocity, over time t",
        name="force per length",
        unit="force",
        scale=force,
        columns=[*columns, VELOCITY],
        labels=[*((f"{of} {name.lstrip('_')}".rstrip(), None) for _, name in followed), ("mean over the cell", None)],
        exact_columns=[],
        measure=measure,
        exact=lambda times: None,
        sizes=[*(sizes[kind] for kind, _ in followed), speed],
        levels=[drive, *[np.nan] * len(columns)] if alone else (),
        panels=[*((f"{kind} per length", UNITS[kind]) for kind, _ in followed), ("superficial velocity", "velocity")],
    )


def movie_series(cell):
    """Forces on the bodies, or on the walls where there are none."""
    return time_series(cell).only(("drag", "lift"), "force per length", "force")


def parameters(cell):
    """Pairs (label, text) of what the flow is, independent of particles."""
    length, time = cell.units.length, cell.units.time
    fastest = cell.fastest_body >= cell.driven_velocity
    of = "of the fastest body or wall" if fastest else "that the acceleration causes, roughly"
    width, height = cell.size
    lines = [
        ("Reynolds number", f"{cell.reynolds:.6g}  (U d / nu)"),
        ("speed U", f"{cell.reference_velocity:.6g} {length}/{time}, {of}"),
        (
            "length d",
            f"{cell.reference_length:.6g} {length}, the height of {'the largest body' if cell.count else 'all'}",
        ),
        ("kinematic viscosity nu", f"{cell.kinematic_viscosity:.6g} {length}^2/{time}"),
        ("cell", f"{width:.6g} x {height:.6g} {length}, {cell.region.area / (width * height):.4g} of it fluid"),
    ]
    lines += _narrowest(cell)
    if cell.acceleration:
        lines.append(("drive", f"{cell.acceleration:.6g} {length}/{time}^2 along x"))
    return lines


def _narrowest(cell):
    """What is smallest about bodies and walls, in particle spacings, and how many there should be."""
    radius, gap = (size for size, _ in cell.narrowest(cell.start_time))
    least = f"at least {_clearance.LEAST_RADIUS:g}, a circle {0.5 * _clearance.LEAST_WIDTH:g}"
    found = [("smallest radius", radius, least, resolution.LEAST_RADIUS)]
    found += [("narrowest gap", gap, f"at least {_clearance.LEAST_GAP:g}", resolution.LEAST_GAP)]
    for name, size, least, enough in found:
        if np.isfinite(size):
            spacings = f"{size / cell.spacing:.3g} spacings ({least}; resolved from {enough:g} on)"
            yield name, f"{size:.4g} {cell.units.length}, {spacings}"
