"""Guard: stops a run whose state is not sound, and stores the last sound state."""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from tisph.errors import DivergedError
from tisph.observers.protocol import EverySteps, LastStep, StateObserver
from tisph.scenes._scene import Scene
from tisph.snapshot import OPTIONAL, Snapshot

INTERVAL = 50
"""Steps between two checks: an unsound run is stopped within twice as many."""

DENSITY_LIMIT = 0.2
"""Largest sound departure of the density from the reference density, as a fraction of it."""

TRANSVERSE_LIMIT = 0.1
"""Largest sound velocity across the channel, over the fastest along it: the exact flows have none."""

SETTLING = 2.0
"""Time from which the transverse velocity is checked, over spacing^2 / nu, the time of diffusion over a spacing.

Before, the layer at a wall that has started is thinner than a spacing. Particles that shear there may exceed the limit
and calm down again: by 1.4 such times in every run of the stability matrix that did.
"""


class Guard(StateObserver):
    """Checks snapshots for numbers that are not finite, compression, break-up, and particles beyond a wall."""

    def __init__(self, scene: Scene):
        self.schedule = EverySteps(INTERVAL)
        self.scene = scene
        self.settled_from = scene.start_time + SETTLING * scene.spacing**2 / scene.solvent_viscosity
        self.last_good: Snapshot | None = None

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Check the last step, once, however many observers ask for it."""
        step.check()

    def check(self, snapshot: Snapshot) -> None:
        """Raise DivergedError with field, particle, step and time, or store ``snapshot`` as the last sound one."""
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
            points, scene = np.stack([snapshot.x, snapshot.y], axis=1), cast(Any, self.scene.seen(snapshot))
            self._refuse(snapshot, "x", ~scene.contains(points, snapshot.t), "lies beyond a wall")
        else:
            for axis, size, periodic in zip("xy", self.scene.extent, self.scene.periodic, strict=True):
                if not periodic:
                    place = getattr(snapshot, axis)
                    self._refuse(
                        snapshot, axis, (place < 0.0) | (place > size), f"lies beyond a wall (0 to {size:.6g})"
                    )
        self.last_good = snapshot

    def _refuse(self, snapshot: Snapshot, field: str, bad: np.ndarray, reason: str) -> None:
        """Raise DivergedError for the first of the particles that are ``bad``, bool (particles,)."""
        if not bad.any():
            return
        particle = int(np.argmax(bad))
        value = getattr(snapshot, field)[particle]
        raise DivergedError(
            f"{field} = {value:.6g} of particle {particle} {reason}, "
            f"at step {snapshot.step}, t = {snapshot.t:.6g} ({int(bad.sum())} particles are wrong)"
        )
