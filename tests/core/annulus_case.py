import numpy as np
from dataclasses import dataclass

from tisph import runtime
from tisph.schemes._splitting._flow import BoundedFlow, box_around
from tisph.schemes._splitting._scheme import COURANT, TOLERANCE, Scheme
from tisph.schemes._splitting._walls import Walls
import types


class Cylinder:
    def __init__(self, radius, inside, omega):
        self.radius, self.sign, self.omega = radius, -1.0 if inside else 1.0, omega

    def nearest(self, p, t):
        r = np.linalg.norm(p, axis=1)
        n = p / r[:, None]
        return types.SimpleNamespace(
            point=self.radius * n, normal=self.sign * n, distance=self.sign * (r - self.radius)
        )

    def boundary_points(self, dx, t):
        m = round(2 * np.pi * self.radius / dx)
        a = (np.arange(m) + 0.5) * 2 * np.pi / m + self.omega * t
        n = np.stack([np.cos(a), np.sin(a)], 1)
        return types.SimpleNamespace(
            point=self.radius * n, normal=self.sign * n, length=np.full(m, 2 * np.pi * self.radius / m)
        )

    def velocity(self, p, t):
        return self.omega * np.stack([-p[:, 1], p[:, 0]], 1)

    def acceleration(self, p, t):
        return -(self.omega**2) * p


def fill(r1, r2, dx, jitter, seed=0):
    # rings, then jitter
    n = int(round((r2 - r1) / dx))
    rng = np.random.default_rng(seed)
    out = []
    for k in range(n):
        r = r1 + (k + 0.5) * (r2 - r1) / n
        m = round(2 * np.pi * r / dx)
        a = (np.arange(m) + rng.uniform()) * 2 * np.pi / m
        out.append(np.stack([r * np.cos(a), r * np.sin(a)], 1))
    p = np.concatenate(out)
    p += rng.uniform(-jitter, jitter, p.shape) * dx
    return p


def make(
    across,
    omega=(1.0, 0.0),
    nu=0.02,
    jitter=0.2,
    targets=(1.0,),
    threads=1,
    courant=COURANT,
    tolerance=TOLERANCE,
    r=(1.0, 2.0),
    start=0.0,
):
    runtime.start("f64", threads)
    dx = (r[1] - r[0]) / across
    place = fill(*r, dx, jitter)
    origin, columns, rows = box_around([[-r[1]] * 2, [r[1]] * 2], dx, (False, False), 0.3 * 2 * r[1])
    bodies = [Cylinder(r[0], False, omega[0]), Cylinder(r[1], True, omega[1])]
    walls = Walls(bodies, dx, origin, start)
    flow = BoundedFlow(
        liquid=len(place),
        walls=walls,
        columns=columns,
        rows=rows,
        spacing=dx,
        density=1.0,
        kinematic_viscosity=nu,
        reference_velocity=max(abs(omega[0]) * r[0], abs(omega[1]) * r[1]),
        origin=origin,
        start_time=start,
    )
    scheme = Scheme(flow, targets, threads == 1, tolerance, courant)
    return scheme, place
