"""What axisymmetric flow is measured by: forces and torques on whole walls, kinetic energies, mean velocity."""

import numpy as np

from tisph.measures.fits import max_void_radius, min_distance, section_weights, with_walls

ENERGIES = "kinetic_energy_axial", "kinetic_energy_radial", "kinetic_energy_azimuthal"
"""Names of ``kinetic_energies``."""


def loads(scene, snapshot):
    """Force along the axis and torque around it of the fluid on each wall: ``force_NAME`` and ``torque_NAME``.

    Forces on bodies have the part of the mean pressure gradient.
    """
    found, gradient = {}, scene.density * acceleration(scene, snapshot)
    for index, name in enumerate(scene.names):
        pressed = gradient * scene.volumes[index] if gradient else 0.0
        found[f"force_{name}"] = snapshot.bodies.force[index, 0] + pressed
        found[f"torque_{name}"] = snapshot.bodies.torque[index]
    return found


def acceleration(scene, snapshot):
    """That of the fluid along the axis by the mean pressure gradient."""
    return scene.acceleration if snapshot.acceleration is None else snapshot.acceleration


def volume_mean(snapshot, values):
    """Mean over the volume of ``values`` (particles,), of particles that are even in the half-plane."""
    return float(np.average(values, weights=snapshot.y))


def kinetic_energies(snapshot):
    """Mean kinetic energies per mass (3,): of what goes along the axis, along radii and around the axis."""
    return np.array([0.5 * volume_mean(snapshot, np.square(part)) for part in (snapshot.u, snapshot.v, snapshot.w)])


def mean_velocity(scene, snapshot):
    """Mean velocity along the axis over a cross-section."""
    positions, velocity = with_walls(scene, snapshot)
    return float(section_weights(scene.seen(snapshot), positions, snapshot.t) @ velocity[:, 0])


def spread(scene, snapshot):
    """Nearest two particles and largest void, in spacings, and the divergence, see ``_two_dimensional.diagnostics``."""
    return {
        "divergence_over_gradient": snapshot.divergence,
        "min_distance": min_distance(scene, snapshot),
        "max_void_radius": max_void_radius(scene, snapshot),
        "density_variation": 0.0,
    }
