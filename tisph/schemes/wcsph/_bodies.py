"""Bodies around the fluid of an explicit run, or in it: layers of wall particles that move as these do."""

from dataclasses import replace

import numpy as np

from tisph import registry
from tisph.geometry.region import box_around
from tisph.periodic import PeriodicDomain
from tisph.runtime import view
from tisph.schemes._supported import AROUND_BODIES
from tisph.schemes.wcsph._boundaries import PeriodicBoundaries
from tisph.schemes.wcsph._loads import Loads
from tisph.snapshot import Bodies

STATE = "middle", "built", "compression"
"""Attributes of ``SolidBodies`` that change while it runs."""


class SolidBodies(PeriodicBoundaries):
    """Bodies of a scene; for the rest the box around them is periodic, though nothing is near its ends.

    The mean compression stays what it is at the start: density diffusion, a Laplacian of the pressure, lets some
    through walls on which the pressure has a slope, as that of fluid that turns has.
    """

    def __init__(self, config, scene, radius):
        super().__init__(config, scene)
        self.scene, self.parameters = scene, config.walls.treatment
        name = self.parameters.type if self.parameters else AROUND_BODIES[0]
        self.treatment = registry.compiled("walls", name).BodyTreatment
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
        """Prepare the wall particles for lists that were built anew, and take back what density has leaked."""
        self.built = middle
        leaked = self.mean_compression(now) - self.compression
        view(self.walls.particles.compression)[now, : self.walls.particles.fluid] -= leaked
        self.walls.refresh(now)

    def mean_compression(self, now):
        """Return the mean of the compressions at the end of a step."""
        return float(view(self.walls.particles.compression)[now, : self.walls.particles.fluid].mean(dtype=float))

    def described(self, snapshot):
        """Return the ``snapshot`` with the bodies, and from the first step on what the fluid does to them."""
        loads = self.loads.of(snapshot) if snapshot.step else None
        return replace(snapshot, bodies=Bodies.at(snapshot.t, self.scene.bodies, loads))

    def state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {**super().state(), **{name: getattr(self, name) for name in STATE}}

    def restore(self, state):
        """Take up the numbers of ``state``."""
        super().restore(state)
        for name in STATE:
            setattr(self, name, state[name])
