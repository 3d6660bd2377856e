"""Fluid between two cylinders, for tests of the implicit scheme at walls of any shape."""

import math
from dataclasses import fields

import numpy as np

from tisph import runtime
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.packing import pack
from tisph.geometry.region import Region, box_around
from tisph.geometry.wanted_spacing import NearBody, WantedSpacing
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.scheme import COURANT, PlanarScheme
from tisph.schemes.implicit.planar.wall_points import WallPoints

INNER, OUTER, ACROSS = 1.0, 2.0, 12
VISCOSITY = 0.02


def make(turning=(1.0, 0.0), centre=(0.0, 0.0), angle=0.0, acceleration=(0.0, 0.0), viscosity=VISCOSITY, ratio=1.0):
    """Return cylinders around ``centre``, and places (particles, 2) of particles between them, turned by ``angle``.

    The particles are in disorder, always the same one; ``turning`` are the angular velocities from t = 0 on, numbers,
    ``WallMotion`` or ``Schedule``. At the inner cylinder the spacing is ``ratio`` times finer.
    """
    turning = [WallMotion(way) if isinstance(way, int | float) else way for way in turning]
    shapes = Circle(INNER), Circle(OUTER, fluid_side="inside")
    motions = [RigidMotion(rotation=way) for way in turning]
    bodies = [Body(shape, centre, angle, motion) for shape, motion in zip(shapes, motions, strict=True)]
    spacing, corner = (OUTER - INNER) / ACROSS, (-OUTER, -OUTER)
    still = tuple(Body(shape) for shape in shapes)
    wanted = WantedSpacing(spacing, (NearBody(bodies[0], spacing / ratio),))
    places = pack(Region(still, corner, (OUTER, OUTER)), wanted, 0.2)
    cosine, sine = math.cos(angle), math.sin(angle)
    places = places @ np.array([[cosine, sine], [-sine, cosine]]) + centre
    extent = np.add(centre, corner), np.subtract(centre, corner)
    box = box_around(extent, spacing, (False, False), 0.8)
    flow = Problem(
        n_fluid=len(places),
        walls=WallPoints(bodies, spacing, box.origin, wanted=wanted),
        spacing_sources=wanted.sources,
        density=1.0,
        kinematic_viscosity=viscosity,
        reference_velocity=max(1.0, *(way.largest_speed for way in turning)),
        acceleration=acceleration,
        jump_times=tuple(sorted({time for wall in turning for time in wall.jump_times})),
        **{each.name: getattr(box, each.name) for each in fields(box)},
    )
    return flow, places


def run(flow, places, velocity, end, steps=None, tolerance=2e-6, courant=COURANT):
    """Step until ``end``, or so many ``steps``, from a ``velocity`` (particles, 2); return the PlanarScheme."""
    runtime.start("f64", 1)
    scheme = PlanarScheme(flow, [end], True, tolerance, courant)
    scheme.start(places, velocity)
    while not scheme.finished and scheme.steps != steps:
        scheme.advance()
    return scheme


def steady(places, turning=(1.0, 0.0), centre=(0.0, 0.0)):
    """Velocity (n, 2) of the steady flow, a r + b/r around the axis."""
    away = places - centre
    square = OUTER**2 - INNER**2
    a = (turning[1] * OUTER**2 - turning[0] * INNER**2) / square
    b = (turning[0] - turning[1]) * INNER**2 * OUTER**2 / square
    rate = a + b / np.sum(away**2, axis=1)
    return rate[:, None] * np.stack([-away[:, 1], away[:, 0]], axis=1)


def error(snapshot, turning=(1.0, 0.0), centre=(0.0, 0.0)):
    """Relative L2 error of the velocities against the steady flow."""
    exact = steady(np.stack([snapshot.x, snapshot.y], 1), turning, centre)
    return np.linalg.norm(np.stack([snapshot.u, snapshot.v], 1) - exact) / np.linalg.norm(exact)
