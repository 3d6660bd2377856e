"""The Taylor-Green vortex in a periodic box, for tests of the scheme that has a pressure."""

import numpy as np
from kept_program import kept

from tisph import runtime
from tisph.numerics import least_squares as operators
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.scheme import COURANT, PlanarScheme
from tisph.schemes.implicit.planar.step_limits import TOLERANCE, step_control

WAVE = 2 * np.pi
VISCOSITY = 0.01


def exact(x, y, t, viscosity):
    """Velocities and pressure of the vortex of unit size and speed, density 1."""
    decay = np.exp(-2 * viscosity * WAVE**2 * t)
    u, v = -np.cos(WAVE * x) * np.sin(WAVE * y), np.sin(WAVE * x) * np.cos(WAVE * y)
    return u * decay, v * decay, -0.25 * (np.cos(2 * WAVE * x) + np.cos(2 * WAVE * y)) * decay**2


def arrangement(number, jitter, cells=1):
    """Places (particles, 2), ``number`` of them along y and in each cell along x, up to ``jitter`` spacings off."""
    centres = np.meshgrid(np.arange(cells * number) + 0.5, np.arange(number) + 0.5)
    lattice = np.stack(centres, -1).reshape(-1, 2)
    moved = np.random.default_rng(0).uniform(-jitter, jitter, lattice.shape)
    return (lattice + moved) / number % [cells, 1]


_built = {}


def make(number, *, jitter=0.2, wind=(0, 0), targets=(1.0,), threads=1, precision="f64", fresh=False, cells=1, **steps):
    """Return vortices at their start, in a wind, as a PlanarScheme; ``steps`` are its tolerance and Courant number.

    What was returned before is used again where it has as many particles, unless ``fresh``.
    """
    key = number, cells, threads, precision, operators.FEW
    scheme = _built.get(key)
    if fresh or scheme is None or scheme.built != kept.starts:
        _built.clear()
        runtime.start(precision, threads)
        scheme = _built[key] = PlanarScheme(flow(number, cells), targets, threads == 1)
        scheme.built = kept.starts
    limits = steps.get("tolerance", TOLERANCE), steps.get("courant", COURANT)
    scheme.control = step_control(scheme.problem, targets, *limits)
    scheme.reset()
    position = arrangement(number, jitter, cells)
    u, v, _ = exact(*position.T, 0.0, VISCOSITY)
    scheme.start(position, np.stack([u, v], 1) + wind)
    return scheme


def flow(number, cells):
    """Box and liquid of vortices side by side, at Re = 100."""
    return Problem(
        columns=cells * number,
        rows=number,
        spacing=1 / number,
        n_fluid=cells * number**2,
        density=1.0,
        kinematic_viscosity=VISCOSITY,
        reference_velocity=1.0,
    )


def run(scheme, end):
    """Step until ``end`` and return the last snapshot."""
    while scheme.time < end:
        scheme.advance()
    return scheme.snapshot()


def errors(snapshot):
    """Relative L2 errors of velocity and of pressure, both over all particles, and that of the kinetic energy."""
    u, v, p = exact(snapshot.x, snapshot.y, snapshot.t, VISCOSITY)
    squares = np.sum(u**2 + v**2)
    velocity = np.sqrt(np.sum((snapshot.u - u) ** 2 + (snapshot.v - v) ** 2) / squares)
    p = p - p.mean()
    pressure = np.linalg.norm(snapshot.pressure - snapshot.pressure.mean() - p) / np.linalg.norm(p)
    return velocity, pressure, np.sum(snapshot.u**2 + snapshot.v**2) / squares - 1
