"""Angular momentum of axisymmetric flow beside what its walls give it, in the verification suite.

A step does not conserve it by its construction: velocities are those at particles, torques are of values at walls. The
angular momentum is that of values at nodes, by polynomials of degree 6 through the particles.
"""

import numpy as np

from tisph import scenes
from tisph.measures.fits import interpolated
from tisph.measures.wall_shear import integral
from tisph.results import open_run
from tisph.studies.verification.criteria import of_whole_runs

NODES = 32
"""Along the axis, and of Gauss and Legendre across: twice as many change the row below by less than 1e-6."""


def momentum_closes(case, bound):
    """The gain from the first sample to the last is that of both torques, within ``bound`` of the larger of these."""

    def off(result):
        history, samples = open_run(result.folder).history, result.summary["samples"]
        ends = samples[0]["t"], samples[-1]["t"]
        impulses = [_impulse(history["t"], history[f"torque_{side}"], ends) for side in ("inner", "outer")]
        before, after = (_angular_momentum(result, place) for place in (0, len(samples) - 1))
        return abs(after - before + sum(impulses)) / np.abs(impulses).max()

    return of_whole_runs(case, "angular momentum off the torques'", bound, off)


def _impulse(t, torque, ends):
    known = np.isfinite(torque)  # there is none at the start
    return np.diff(np.interp(ends, t[known], integral(t[known], torque[known])))[0]


def _angular_momentum(result, place):
    scene, arrays = scenes.of(open_run(result.folder).config), result.arrays()
    x, y, w = (arrays[f"sample_{place:03d}/{name}"] for name in "xyw")
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    radii = scene.inner_radius + scene.extent[1] * 0.5 * (nodes + 1.0)
    along = scene.length * (np.arange(NODES) + 0.5) / NODES
    points = np.stack(np.meshgrid(along, radii, indexing="ij"), axis=-1).reshape(-1, 2)
    swirl = interpolated(scene, np.stack([x, y], axis=1), w[:, None], points)[:, 0].reshape(NODES, NODES).mean(axis=0)
    return scene.density * scene.length * np.pi * scene.extent[1] * np.sum(weights * radii**2 * swirl)
