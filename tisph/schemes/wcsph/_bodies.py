"""Bodies around the fluid of an explicit run, or in it: wall particles that move with the bodies, and loads.

The scheme needs no stress at a wall: the loads on bodies follow from the particles. At points of the walls, a spacing
apart, a polynomial of ``DEGREE`` is fitted to the velocities of the nearest particles and wall points
(``measures/fits.py``), whose slopes are the velocity gradient, and a linear function to the pressures of the particles.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from tisph import registry
from tisph.config.schema import Config
from tisph.geometry.region import box_around
from tisph.measures.fits import local_fits, parts, periodic_tree, with_walls
from tisph.numerics.domain import PeriodicDomain
from tisph.runtime import view
from tisph.scenes._scene import Scene
from tisph.schemes import AROUND_BODIES
from tisph.schemes.implicit.planar.wall_points import WallPoints
from tisph.schemes.wcsph._boundaries import PeriodicBoundaries
from tisph.schemes.wcsph.operators._pairs import PairOperators
from tisph.schemes.wcsph.walls._treatment import SolidWalls
from tisph.snapshot import Bodies, Snapshot

DEGREE, NEAREST = 4, 44
"""Degree of the fit to velocities, and its number of values: three times the number of coefficients."""

PRESSED = 12
"""Number of pressures of a fit: four times the number of coefficients."""


class SolidBodies(PeriodicBoundaries):
    """Bodies of a scene, in a periodic box around them; no particle is near the ends of the box.

    The mean compression is kept at its initial value, ``compression``: density diffusion, a Laplacian of the pressure,
    lets density through walls at which the pressure has a slope, as in rotating fluid. ``middle`` and ``built``: times
    in the middle of the present step and when the lists were built.
    """

    kept = (*PeriodicBoundaries.kept, "middle", "built", "compression")
    walls: SolidWalls

    def __init__(self, config: Config, scene: Scene, radius: float):
        super().__init__(scene)
        self.scene, self.parameters = scene, config.walls.treatment
        name = self.parameters.type if self.parameters else AROUND_BODIES[0]
        self.treatment = registry.load("walls", name).treatments().bodies
        self.layers = self.treatment.arrange(scene.bodies, scene.spacing, radius)
        self.slots = self.layers.slots
        corners = scene.origin, np.add(scene.origin, scene.extent)
        self.box = box = box_around(corners, scene.spacing, scene.periodic, 2.0 * radius)
        self.origin, self.domain = box.origin, PeriodicDomain(box.length, box.height)
        self.radii = [
            self.layers.radius(number, self.treatment.uses_mirror_points) for number in range(len(scene.bodies))
        ]
        self.middle = self.built = scene.start_time
        self.compression = 0.0
        self.loads = Loads(scene)

    def drifts(self) -> Iterable[float]:
        """Return for each body the largest distance of a wall particle from its position as the lists predict it."""
        for body, radius in zip(self.scene.bodies, self.radii, strict=True):
            here, there = body.at(self.middle), body.at(self.built)
            yield float(np.linalg.norm(here.centre - there.centre)) + radius * abs(here.angle - there.angle)

    def create_walls(self, operators: PairOperators, kernel: Any) -> SolidWalls:
        """Create the ``walls`` for the lists and the fluid of ``operators``; return them."""
        place = self.layers, self.scene.bodies, self.origin
        self.walls = self.treatment(operators.lists, kernel, operators.fluid, self.parameters, *place)
        self.displacement_factor = self.walls.displacement_factor
        return self.walls

    def begin(self, momentum: float) -> None:
        """Place the wall particles at the start; ``momentum``: sum of the fluid's velocities along x."""
        super().begin(momentum)
        self.compression = self.mean_compression(0)
        self.walls.load(self.scene.start_time)

    def move_on(self, before: float, middle: float) -> None:
        """Move the bodies to the ``middle`` of the next step."""
        self.middle = middle
        self.walls.place_bodies(middle)

    def rebuilt(self, now: int, middle: float) -> None:
        """Prepare the wall particles for new lists, and restore the mean compression."""
        self.built = middle
        leaked = self.mean_compression(now) - self.compression
        view(self.walls.particles.compression)[now, : self.walls.particles.fluid] -= leaked
        self.walls.refresh(now)

    def mean_compression(self, now: int) -> float:
        """Return the mean of the compressions at the end of a step."""
        return float(view(self.walls.particles.compression)[now, : self.walls.particles.fluid].mean(dtype=float))

    def described(self, snapshot: Snapshot) -> Snapshot:
        """Return the ``snapshot`` with the bodies, and from the first step on the loads on them."""
        loads = self.loads.of(snapshot) if snapshot.step else None
        return replace(snapshot, bodies=Bodies.at(snapshot.t, self.scene.bodies, loads))


class Loads:
    """Force and torque on the bodies of a ``scene`` with a Newtonian fluid."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.walls = WallPoints(scene.bodies, scene.spacing, scene.origin)

    def of(self, snapshot: Snapshot) -> np.ndarray:
        """Return force along x and y, torque and stresslet, in total and by the pressure: (2, bodies, 4), or NaN."""
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

    def _fitted(
        self, places: np.ndarray, values: np.ndarray, points: np.ndarray, degree: int, near: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return fits to ``values`` (n, fields) at ``points`` (k, 2), (k, fields), and their slopes (k, 2, fields)."""
        tree, _ = periodic_tree(self.scene, places)
        pairs = [local_fits(tree, part, values, degree, near) for part in parts(points)]
        fits = np.concatenate([fit for fit, _ in pairs])
        return fits[:, 0], fits[:, 1:3] / np.concatenate([radius for _, radius in pairs])[..., None]
