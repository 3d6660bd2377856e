"""What the fluid does to bodies, as the particles show it: the scheme itself needs no stress at a wall.

Around points of the walls, a spacing apart, the velocities of the nearest particles and of these points themselves are
fitted by a polynomial of ``DEGREE`` (``measures/fits.py``), from which follow velocity gradients, and the pressures
of the particles alone by a linear function.
"""

import numpy as np

from tisph.measures.fits import local_fits, parts, periodic_tree, with_walls
from tisph.schemes._splitting._wall_points import WallPoints

DEGREE, NEAREST = 4, 44
"""Of the velocities' fit, and how many it takes: three times as many as coefficients."""

PRESSED = 12
"""How many pressures a fit takes: four times as many as coefficients."""


class Loads:
    """Force and torque on the bodies of a ``scene``; its fluid is a Newtonian one."""

    def __init__(self, scene):
        self.scene = scene
        self.walls = WallPoints(scene.bodies, scene.spacing, scene.origin)

    def of(self, snapshot):
        """Return force along x and y, torque and stresslet (2, bodies, 4) of all, and of the pressure, or NaN."""
        scene, walls, time = self.scene, self.walls, snapshot.t
        places, velocities = with_walls(scene, snapshot)
        pressures = snapshot.pressure.astype(float)
        if not all(np.isfinite(values).all() for values in (places, velocities, pressures)):
            return np.full((2, len(scene.bodies), 4), np.nan)
        points, normal = places[len(pressures) :], walls.at(time)[1]
        gradient = self._fitted(places, velocities, points, DEGREE, NEAREST)[1]
        pressure = self._fitted(places[: len(pressures)], pressures[:, None], points, 1, PRESSED)[0][:, 0]
        gradient = walls.gradients(gradient.transpose(2, 1, 0), time)
        stress = scene.dynamic_viscosity * (gradient + gradient.transpose(1, 0, 2))
        viscous = np.einsum("abn,nb->na", stress, normal)
        pushed = -pressure[:, None] * normal
        return walls.sums(np.stack([viscous + pushed, pushed]), time)

    def _fitted(self, places, values, points, degree, near):
        """Return ``values`` (n, fields) at ``points`` (k, fields) and their slopes along x and y (k, 2, fields)."""
        tree, _ = periodic_tree(self.scene, places)
        pairs = [local_fits(tree, part, values, degree, near) for part in parts(points)]
        fits = np.concatenate([fit for fit, _ in pairs])
        return fits[:, 0], fits[:, 1:3] / np.concatenate([radius for _, radius in pairs])[..., None]
