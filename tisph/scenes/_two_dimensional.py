"""What scenes of turning fluid look at: profiles, kinetic energy, vorticity, spread of particles."""

import numpy as np

from tisph.measures.fits import max_void_radius, min_distance, velocity_gradients, vorticity
from tisph.scenes._views import Line, Profile, TimeSeries


def centre_line(scene, along):
    """The line ``along`` x or y through the middle of the box, with the particles half a spacing around it."""
    axis = "xy".index(along)
    ends = [(low, low + size) for low, size in zip(scene.origin, scene.extent, strict=True)]
    return Line(along, ends[axis], 0.5 * sum(ends[1 - axis]), half_width=0.5 * scene.spacing)


def kinetic_energy(snapshot):
    """Return the mean over the particles of (u^2 + v^2)/2."""
    return 0.5 * np.mean(np.square(snapshot.u) + np.square(snapshot.v))


def velocity_errors(scene, snapshot, u, v):
    """Return ``l2``, ``rms`` and ``linf`` of ``sample_metrics`` against ``u``, ``v`` of a steady flow (particles,)."""
    squares, speed = (snapshot.u - u) ** 2 + (snapshot.v - v) ** 2, scene.reference_velocity
    return {
        "l2": np.sqrt(np.sum(squares) / np.sum(u**2 + v**2)),
        "rms": np.sqrt(np.mean(squares)) / speed,
        "linf": np.sqrt(np.max(squares)) / speed,
    }


def velocity_profile(scene, field, along, **reference):
    """Return the Profile of u or v, the ``field``, on the centre line ``along`` x or y; ``reference`` is as there."""
    line = centre_line(scene, along)
    return Profile(field, "velocity", line, of=lambda snapshot: getattr(snapshot, field), **reference)


def pressure_profile(scene, line):
    """Return the Profile of the pressure on a ``line``, less the mean of what it differs by from the exact one."""

    def exact(x, y, t):
        return scene.exact("pressure", x, y, t)

    def of(snapshot):
        return snapshot.pressure - np.mean(snapshot.pressure - exact(snapshot.x, snapshot.y, snapshot.t))

    scale = (scene.density * scene.reference_velocity**2, "density U²")
    return Profile(name="p", unit="stress", line=line, of=of, exact=exact, scale=scale)


def vorticity_profile(scene, line):
    """Return the Profile of the vorticity on a ``line``."""
    exact = scene.exact_vorticity
    return Profile("vorticity", "rate", line, of=lambda snapshot: vorticity(scene, snapshot, degree=2), exact=exact)


def followed_energy(scene):
    """Return the ``TimeSeries`` of the kinetic energy, without a reference."""
    return TimeSeries(
        content="mean kinetic energy per mass over time t",
        name="kinetic energy per mass",
        unit="energy",
        scale=0.5 * scene.reference_velocity**2,
        columns=["kinetic_energy"],
        labels=[("mean over the particles", None)],
        measure=lambda snapshot: np.array([kinetic_energy(snapshot)]),
    )


def diagnostics(scene, snapshot):
    """Return the mean square of the vorticity, and the numbers of a sample that need no reference.

    ``divergence_over_gradient``: largest |div u| over the largest velocity gradient (Frobenius norm), None at rest;
    ``min_distance`` and ``max_void_radius``, see ``measures/fits.py``; ``density_variation`` = max
    |density/density_0 - 1|. Gradients are those of ``measures/fits.py``, whose own errors are about 1e-4
    of the largest at 50 particles a wave, and fall with the fourth power of the spacing.
    """
    slopes = velocity_gradients(scene, snapshot)
    largest = np.max(np.linalg.norm(slopes, axis=0))
    distance, radius = min_distance(scene, snapshot), max_void_radius(scene, snapshot)
    return np.mean(np.square(slopes[2] - slopes[1])), {
        "divergence_over_gradient": np.max(np.abs(slopes[0] + slopes[3])) / largest if largest else None,
        "min_distance": distance,
        "max_void_radius": radius,
        "nearest_two": distance,  # the old names of both
        "largest_hole": radius,
        "density_variation": np.max(np.abs(snapshot.density / scene.density - 1)),
    }
