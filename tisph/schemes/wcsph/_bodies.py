"""Bodies around the fluid of an explicit run, or in it: layers of wall particles that move as these do.

The scheme needs no stress at a wall: the loads on bodies follow from the particles. Around points of the walls, a
spacing apart, the velocities of the nearest particles and of these points themselves are fitted by a polynomial of
``DEGREE`` (``measures/fits.py``), from which follow velocity gradients, and the pressures of the particles alone by a
linear function.
"""

from dataclasses import replace

import numpy as np

from tisph import registry
from tisph.domain import PeriodicDomain
from tisph.geometry.region import box_around
from tisph.measures.fits import local_fits, parts, periodic_tree, with_walls
from tisph.runtime import view
from tisph.schemes import AROUND_BODIES
from tisph.schemes._two_dimensional.wall_points import WallPoints
from tisph.schemes.wcsph._boundaries import PeriodicBoundaries
from tisph.snapshot import Bodies

DEGREE, NEAREST = 4, 44
"""Of the velocities' fit, and how many it takes: three times as many as coefficients."""

PRESSED = 12
"""How many pressures a fit takes: four times as many as coefficients."""


class SolidBodies(PeriodicBoundaries):
    """Bodies of a scene; for the rest the box around them is periodic, though nothing is near its ends.

    The mean compression stays what it is at the start: density diffusion, a Laplacian of the pressure, lets some
    through walls on which the pressure has a slope, as that of fluid that turns has.
    """

    kept = (*PeriodicBoundaries.kept, "middle", "built", "compression")

    def __init__(self, config, scene, radius):
        super().__init__(config, scene)
        self.scene, self.parameters = scene, config.walls.treatment
        name = self.parameters.type if self.parameters else AROUND_BODIES[0]
        self.treatment = registry.load("walls", name).treatments().bodies
        self.layers = self.treatment.arrange(scene.bodies, scene.spacing, radius)
        self.slots = self.layers.slots
        corners = scene.origin, np.add(scene.origin, scene.extent)
        self.box = box_around(corners, scene.spacing, scene.periodic, 2.0 * radius)
        self.origin, self.domain = self.box.origin, PeriodicDomain(self.box.length, self.box.height)
        self.radii = [
            self.layers.radius(number, self.treatment.uses_mirror_points) for number in range(len(scene.bodies))
        ]
        self.middle = self.built = scene.start_time
        self.compression = 0.0
        self.loads = Loads(scene)

    @property
    def drift(self):
        """How far the wall particles of each body are, at most, from where the lists expect them."""
        for body, radius in zip(self.scene.bodies, self.radii, strict=True):
            here, there = body.at(self.middle), body.at(self.built)
            yield float(np.linalg.norm(here.centre - there.centre)) + radius * abs(here.angle - there.angle)

    def surround(self, operators, kernel):
        """Make the ``walls`` that particles see, for the lists and the fluid of ``operators``; return them."""
        place = self.layers, self.scene.bodies, self.origin
        self.walls = self.treatment(operators.lists, kernel, operators.fluid, self.parameters, *place)
        self.displacement_factor = self.walls.displacement_factor
        return self.walls

    def begin(self, momentum):
        """Place the wall particles around a fluid whose velocities along x add up to ``momentum``."""
        super().begin(momentum)
        self.compression = self.mean_compression(0)
        self.walls.load(self.scene.start_time)

    def move_on(self, before, middle):
        """Move the bodies from the middle of one step to that of the next."""
        self.middle = middle
        self.walls.place_bodies(middle)

    def rebuilt(self, now, middle):
        """Prepare the wall particles for lists that were built anew, and remove the density that has leaked."""
        self.built = middle
        leaked = self.mean_compression(now) - self.compression
        view(self.walls.particles.compression)[now, : self.walls.particles.fluid] -= leaked
        self.walls.refresh(now)

    def mean_compression(self, now):
        """Return the mean of the compressions at the end of a step."""
        return float(view(self.walls.particles.compression)[now, : self.walls.particles.fluid].mean(dtype=float))

    def described(self, snapshot):
        """Return the ``snapshot`` with the bodies, and from the first step on the loads on them."""
        loads = self.loads.of(snapshot) if snapshot.step else None
        return replace(snapshot, bodies=Bodies.at(snapshot.t, self.scene.bodies, loads))


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
