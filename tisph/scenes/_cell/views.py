"""What is looked at in a cell with bodies: centre lines, forces over time, the movie, and in words what the flow is."""

import numpy as np

from tisph.bodies import _clearance
from tisph.measures import resolution
from tisph.scenes import _two_dimensional
from tisph.scenes._cell import diagnostics, free_bodies, shear_stress
from tisph.scenes._views import TimeSeries

VELOCITY = "superficial_velocity"
MOST_RATIOS = 3
"""Ratios of densities that are named one by one."""

UNITS = {"drag": "force", "lift": "force", "torque": "torque"} | free_bodies.UNITS


def profiles(cell):
    """Both components of the velocity along the vertical centre line."""
    return [_two_dimensional.velocity_profile(cell, field, "y") for field in "uv"]


def time_series(cell):
    """Forces and torques on the bodies in the fluid, or on its walls where there are none, and the mean velocity.

    Of bodies that the flow carries, if there are few, also places and velocities, of many means of these alone; and
    the mean shear stress between walls that shear them.
    """
    forces = _followed_forces(cell)
    stresses = shear_stress.columns(cell)
    followed = [*forces, *free_bodies.columns(cell), *((name, "") for name in stresses)]
    columns = [f"{kind}{name}" for kind, name in followed]
    force, speed, free = cell.force_scale, cell.reference_velocity, cell.has_free_bodies
    sizes = {"drag": force, "lift": force, "torque": force * cell.reference_length} | free_bodies.sizes(cell)
    sizes |= dict.fromkeys(stresses, shear_stress.size(cell))
    panels = free_bodies.panels(cell) if free else {kind: (f"{kind} per length", UNITS[kind]) for kind, _ in forces}
    panels |= dict.fromkeys(stresses, ("mean shear stress", "stress"))
    # it carries all that drives the fluid
    alone = len(cell.bodies) == cell.count == 1 and not free and not cell.fastest_body
    drive = cell.density * cell.acceleration * cell.region.area

    def measure(snapshot):
        found = diagnostics.loads(cell, snapshot) | diagnostics.of_free_bodies(cell, snapshot)
        values = [np.nan if found[column] is None else found[column] for column in columns]
        return np.array([*values, diagnostics.velocities(cell, snapshot)[VELOCITY]])

    return TimeSeries(
        content=f"{'places and velocities of bodies, ' if free else ''}forces and torques of the fluid on bodies, "
        "and the mean velocity, over time t",
        name="force per length",
        unit="force",
        scale=force,
        columns=[*columns, VELOCITY],
        labels=[*((_called(cell, *each), None) for each in followed), ("mean over the cell", None)],
        measure=measure,
        sizes=[*(sizes[kind] for kind, _ in followed), speed],
        levels=[drive, *[np.nan] * len(columns)] if alone else (),
        panels=[*(panels.get(kind) for kind, _ in followed), ("superficial velocity", "velocity")],
        drifting=[f"{kind}{name}" for kind, name in followed if kind in free_bodies.PLACES],
    )


def _followed_forces(cell):
    """Pairs of a kind of force and the name of the body, or wall, that it is on."""
    chosen, many = slice(cell.count or None), free_bodies.are_many(cell)
    pairs = zip(cell.names[chosen], cell.bodies[chosen], strict=True)
    return [(kind, name) for name, body in pairs if not (many and body.free) for kind in diagnostics.kinds(body)]


def _called(cell, kind, name):
    """What the legend calls a number."""
    if kind in shear_stress.WORDS:
        return shear_stress.WORDS[kind]
    if cell.count:
        return free_bodies.words(kind, name)
    return f"wall {name.lstrip('_')}"


def movie_series(cell):
    """Forces on the bodies, or on the walls where there are none; of bodies that the flow carries their motion."""
    if cell.has_free_bodies:
        return free_bodies.movie_series(cell)
    return time_series(cell).only(("drag", "lift"), "force per length", "force")


def parameters(cell):
    """Pairs (label, text) of what the flow is, independent of particles."""
    length, time = cell.units.length, cell.units.time
    width, height = cell.size
    known, cause = _cause(cell)
    about, digits = ("", 6) if known else ("about ", 2)
    lines = [
        ("Reynolds number", f"{about}{cell.reynolds:.{digits}g}  (U d / nu)"),
        ("speed U", f"{about}{cell.reference_velocity:.{digits}g} {length}/{time}, {cause}"),
        (
            "length d",
            f"{cell.reference_length:.6g} {length}, the height of {'the largest body' if cell.count else 'all'}",
        ),
        ("kinematic viscosity nu", f"{cell.kinematic_viscosity:.6g} {length}^2/{time}"),
        ("cell", f"{width:.6g} x {height:.6g} {length}, {cell.region.area / (width * height):.4g} of it fluid"),
    ]
    lines += [*_free(cell), *_narrowest(cell)]
    if cell.acceleration:
        lines.append(("drive", f"{cell.acceleration:.6g} {length}/{time}^2 along x"))
    return lines


def _cause(cell):
    """Whether the reference velocity is known, and in words what has it."""
    if cell.given_velocity:
        return True, "given by the config"
    if not (cell.fastest_body or cell.driven_velocity):
        return False, "a guess: nothing has a speed that is known"
    if cell.driven_velocity >= cell.fastest_body:
        return False, "an estimate: the mean velocity that the acceleration causes in a Newtonian fluid"
    if cell.driven_wall >= cell.fastest_body:
        return True, "of the fastest body or wall"
    return False, "an estimate: of a free body under its load, in slow flow or against inertia"


def _free(cell):
    """How many bodies the flow carries, and how heavy they are."""
    chosen = [cell.bodies[index] for index in free_bodies.numbers(cell)]
    if chosen:
        ratios = [body.motion.inertia.mass[0] / (cell.density * body.shape.area) for body in chosen]
        found = sorted({f"{ratio:.6g}" for ratio in ratios}, key=float)
        shown = found if len(found) <= MOST_RATIOS else [f"{found[0]} to {found[-1]}"]
        text = f"{len(chosen)} of {cell.count}, of {', '.join(shown)} times the density of the fluid"
        yield "free bodies", text


def _narrowest(cell):
    """Smallest radius and gap of bodies and walls at the start, in particle spacings, and how many there should be."""
    changes = "will change" if cell.has_free_bodies else "may change"
    moves = "" if cell.gaps_stay and not cell.has_free_bodies else f" at the start; gaps {changes} as bodies move"
    radius, gap = (size for size, _ in cell.narrowest(cell.start_time))
    least = f"at least {_clearance.LEAST_RADIUS:g}, a circle {0.5 * _clearance.LEAST_WIDTH:g}"
    found = [("smallest radius", radius, least, resolution.LEAST_RADIUS, "")]
    found += [("narrowest gap", gap, f"at least {_clearance.LEAST_GAP:g}", resolution.LEAST_GAP, moves)]
    for name, size, least, enough, more in found:
        if np.isfinite(size):
            spacings = f"{size / cell.spacing:.3g} spacings ({least}; resolved from {enough:g} on)"
            yield name, f"{size:.4g} {cell.units.length}, {spacings}{more}"
