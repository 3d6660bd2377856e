"""The discrete Laplacian of scheme ``wcsph`` next to a wall, by wall treatment: no time steps.

An exact profile u(y) is given to the particles, the treatment makes the wall particles, and the scheme evaluates the
acceleration nu lap u + g once, without shifting. The error is the root mean square of lap u - u_yy over the particles
within a spacing of a wall, or beyond the reach of the walls, over the largest |u_yy|. A profile of constant u_yy shows
the error of order 0: in the rows next to a wall it is that of the treatment, elsewhere that of the second moments.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tisph import runtime, scenes, schemes
from tisph.config.loader import loaded
from tisph.measures.metrics import fitted_order, root_mean_square
from tisph.runtime import view
from tisph.studies import flows
from tisph.studies.flows import across, treatment

JITTER = 0.2
ARRANGEMENTS = ("lattice", "rows slid", "jitter 0.2")
"""``rows slid``: each row of the lattice is displaced along x at random, as shear flow does."""

COLUMNS = 30
"""Particles along the channel: room for three supports of 2.5 smoothing lengths twice as long as a spacing."""

PROFILES = {
    "bent": (
        flows.POISEUILLE.at(flows.drive(0.08), flows.state("developed")),
        lambda y: 4.0 * y * (1.0 - y),
        lambda y: -8.0 + 0.0 * y,
    ),
    "straight": (
        flows.COUETTE.at(flows.walls(0.0, 1.0), flows.state("developed")),
        lambda y: y + np.sin(2.0 * np.pi * y) / (2.0 * np.pi),
        lambda y: -2.0 * np.pi * np.sin(2.0 * np.pi * y),
    ),
}
"""Configs, u and u_yy of a driven flow, bent at the walls, and of a sheared one, whose u_yy vanishes there."""

KERNELS = {"quintic_spline": (1.2, 1.5, 2.0), "wendland_c2": (1.3, 1.5, 2.0, 2.5)}
"""Kernels and ratios of smoothing length to spacing, beside the usual ones, the quintic spline and 1."""

ROUND_OFF = 1e-11
"""Error of an exact Laplacian: that of a velocity over a time step."""


@dataclass(frozen=True)
class Laplacian:
    """Errors (next to the walls, inside) by particles across, and the orders of both."""

    treatment: str
    profile: str
    arrangement: str
    kernel: str
    ratio: float
    errors: dict[int, tuple[float, float]]

    @property
    def orders(self) -> list[float]:
        """Powers of the spacing with which both errors fall; NaN where an error is round-off."""
        columns = zip(*self.errors.values(), strict=True)
        return [fitted_order(self.errors.keys(), each) if min(each) > ROUND_OFF else math.nan for each in columns]


def laplacians(treatments, resolutions) -> Iterator[Laplacian]:
    """Yield those of each treatment with the usual kernel, then of the consistent images with each kernel and ratio."""
    for name in treatments:
        for profile in PROFILES:
            yield from measured(name, profile, resolutions)
    for kernel, ratios in KERNELS.items():
        for ratio in ratios:
            for profile in PROFILES:
                yield from measured("consistent_image", profile, resolutions[-3:][:2], kernel, ratio)


def measured(name, profile, resolutions, kernel="quintic_spline", ratio=1.0) -> list[Laplacian]:
    """Return the ``Laplacian`` of each arrangement."""
    runtime.start("f64", 1)
    changes = treatment(name), {"discretisation": {"kernel": kernel, "smoothing_ratio": ratio}}
    errors = {number: _errors(profile, number, *changes) for number in resolutions}
    return [
        Laplacian(name, profile, each, kernel, ratio, {number: errors[number][each] for number in resolutions})
        for each in ARRANGEMENTS
    ]


def _errors(profile, number, *changes):
    """Return the errors (next to the walls, inside) by arrangement."""
    base, velocity, curvature = PROFILES[profile]
    length = {"geometry": {"length": flows.digits(COLUMNS / number)}}
    config = loaded(flows.merged(base, across(number), length, *changes), {})
    scene = scenes.of(config).in_flow_frame()
    scheme = schemes.build(config, scene, [config.time.end], serial=True)
    view(scheme.operators.shift_speed)[...] = 0.0
    x, y = scene.lattice()
    slid = scene.spacing * np.random.default_rng(0).uniform(size=number)[(y / scene.spacing).astype(int)]
    places = (x, y), ((x + slid) % scene.extent[0], y), scene.jittered(0, JITTER)
    return {each: _error(scheme, velocity, curvature, *pair) for each, pair in zip(ARRANGEMENTS, places, strict=True)}


def _error(scheme, velocity, curvature, x, y):
    scene, particles = scheme.scene, scheme.particles
    scheme.length = 0.0  # no step is pending
    scheme.start(np.stack([x, y], 1), np.stack([velocity(y), 0.0 * y], 1))
    # the middle of the first step has the velocity u + dt/2 (nu lap u + g)
    fluid = np.s_[scheme.now, : particles.fluid]
    gained = view(particles.mid_velocity)[fluid][:, 0] - view(particles.velocity)[fluid][:, 0]
    height = view(particles.position)[fluid][:, 1]
    laplacian = (2.0 * gained / scheme.length - scene.acceleration) / scene.kinematic_viscosity
    error = (laplacian - curvature(height)) / np.abs(curvature(np.linspace(0.0, 1.0, 401))).max()
    depth = np.minimum(height, scene.gap - height)
    parts = error[depth < scene.spacing], error[depth > scheme.lists.cutoff]
    return tuple(float(root_mean_square(part)) if part.size else math.nan for part in parts)
