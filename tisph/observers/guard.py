"""Guard: stops a run that has gone wrong, and remembers the last state that was sound."""

import numpy as np

from tisph.errors import DivergedError
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import EverySteps
from tisph.snapshot import OPTIONAL

INTERVAL = 50
"""Steps between two looks: a run that goes wrong is stopped within twice as many."""

DENSITY_LIMIT = 0.2
"""Largest sound departure of the density from the reference density, as a fraction of it."""

TRANSVERSE_LIMIT = 0.1
"""Largest sound velocity across the channel, over the fastest along it: the exact flows have none."""

SETTLING = 2.0
"""From when on that counts, in times spacing^2 / nu, in which viscosity crosses a spacing.

Before, the layer at a wall that has started is thinner than a spacing. Layers of particles that shear there, and
disorder, may stir up more than the limit and calm down again: by 1.4 such times in every run of the stability matrix
that did (docs/evidence/stability.md).
"""


class Guard(StateObserver):
    """Checks every snapshot for numbers that are none, compression, break-up, and particles beyond a wall."""

    def __init__(self, scene):
        self.schedule = EverySteps(INTERVAL)
        self.scene = scene
        self.settled_from = scene.start_time + SETTLING * scene.spacing**2 / scene.solvent_viscosity
        self.last_good = None

    def tell(self, step, times):
        """Check the last step, once, whoever asks for it."""
        step.check()

    def check(self, snapshot):
        """Raise DivergedError naming field, particle, step and time; else keep ``snapshot`` as good."""
        others = [name for name in OPTIONAL if getattr(snapshot, name) is not None]
        for field in ("x", "y", "u", "v", "density", *others):
            self._refuse(snapshot, field, ~np.isfinite(getattr(snapshot, field)), "is not a finite number")
        off = np.abs(snapshot.density / self.scene.density - 1.0) > DENSITY_LIMIT
        limit = f"is off the reference density {self.scene.density:.6g} by more than {DENSITY_LIMIT:.0%}"
        self._refuse(snapshot, "density", off, limit)
        if self.scene.parallel and snapshot.t >= self.settled_from:
            across = np.abs(snapshot.v) > TRANSVERSE_LIMIT * self.scene.peak_velocity
            limit = f"is more than {TRANSVERSE_LIMIT:.0%} of the fastest velocity along x: the parallel flow breaks up"
            self._refuse(snapshot, "v", across, limit)
        if self.scene.bodies:
            points = np.stack([snapshot.x, snapshot.y], axis=1)
            self._refuse(snapshot, "x", ~self.scene.seen(snapshot).contains(points, snapshot.t), "lies beyond a wall")
        else:
            self._keep_in_box(snapshot)
        self.last_good = snapshot

    def _keep_in_box(self, snapshot):
        for axis, size, periodic in zip("xy", self.scene.extent, self.scene.periodic, strict=True):
            if not periodic:
                place = getattr(snapshot, axis)
                self._refuse(snapshot, axis, (place < 0.0) | (place > size), f"lies beyond a wall (0 to {size:.6g})")

    def _refuse(self, snapshot, field, bad, reason):
        if not bad.any():
            return
        particle = int(np.argmax(bad))
        value = getattr(snapshot, field)[particle]
        raise DivergedError(
            f"{field} = {value:.6g} of particle {particle} {reason}, "
            f"at step {snapshot.step}, t = {snapshot.t:.6g} ({int(bad.sum())} particles are wrong)"
        )
