"""Both forms of start-up Couette flow at every time: ``couette.velocity`` takes the one that converges fastest."""

import numpy as np

from tisph.exact import couette
from tisph.exact.couette import dimensionless


def fourier(y, t, *, gap, kinematic_viscosity, bottom, top):
    """Velocity by the Fourier series, for any t > 0 (else ValueError); arguments as ``couette.velocity``."""
    eta, diffusion_time = _after_start(y, t, gap, kinematic_viscosity)
    return top * couette._series_velocity(eta, diffusion_time) + bottom * couette._series_velocity(
        1 - eta, diffusion_time
    )


def images(y, t, *, gap, kinematic_viscosity, bottom, top):
    """Velocity by images, for any t > 0 (else ValueError); arguments as ``couette.velocity``."""
    eta, diffusion_time = _after_start(y, t, gap, kinematic_viscosity)
    return top * couette._image_velocity(eta, diffusion_time) + bottom * couette._image_velocity(
        1 - eta, diffusion_time
    )


def fourier_shear_rate(y, t, *, gap, kinematic_viscosity, bottom, top):
    """du/dy (1/time) by the Fourier series, for any t > 0 (else ValueError); arguments as ``couette.velocity``."""
    eta, diffusion_time = _after_start(y, t, gap, kinematic_viscosity)
    at_top, at_bottom = (couette._series_gradient(coordinate, diffusion_time) for coordinate in (eta, 1 - eta))
    return (top * at_top - bottom * at_bottom) / gap


def images_shear_rate(y, t, *, gap, kinematic_viscosity, bottom, top):
    """du/dy (1/time) by images, for any t > 0 (else ValueError); arguments as ``couette.velocity``."""
    eta, diffusion_time = _after_start(y, t, gap, kinematic_viscosity)
    at_top, at_bottom = (couette._image_gradient(coordinate, diffusion_time) for coordinate in (eta, 1 - eta))
    return (top * at_top - bottom * at_bottom) / gap


def _after_start(y, t, gap, kinematic_viscosity):
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    if np.any(diffusion_time == 0):
        raise ValueError("a single form of the solution holds for t > 0 only")
    return eta, diffusion_time
