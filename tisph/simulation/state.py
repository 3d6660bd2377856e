"""The state of a simulation, as one looks at it from Python."""

from functools import cached_property
from typing import Any

import numpy as np

from tisph.measures.metrics import relative_error, velocities, with_reference
from tisph.snapshot import Snapshot


class State:
    """The fluid particles at time ``t``, after ``step`` steps: arrays (particles,) in the order of their creation.

    All numbers are in the units of the config. The arrays belong to this state and do not change with the run.
    """

    def __init__(self, snapshot: Snapshot, scene: Any):
        self.snapshot = snapshot
        self._scene = scene

    def __repr__(self) -> str:
        return f"<State t={self.t:g}, step {self.step}, {len(self.x)} particles>"

    @property
    def t(self) -> float:
        """Time on the clock of the run."""
        return self.snapshot.t

    @property
    def step(self) -> int:
        """Steps of the run so far."""
        return self.snapshot.step

    @property
    def x(self) -> np.ndarray:
        """Positions along x, within the box of the scene."""
        return self.snapshot.x

    @property
    def y(self) -> np.ndarray:
        """Positions along y."""
        return self.snapshot.y

    @property
    def u(self) -> np.ndarray:
        """Velocities along x."""
        return self.snapshot.u

    @property
    def v(self) -> np.ndarray:
        """Velocities along y."""
        return self.snapshot.v

    @property
    def pressure(self) -> np.ndarray:
        """Pressure; NaN where the scheme has none."""
        return self.snapshot.pressure

    @property
    def stress(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Polymer stresses xx, xy, yy; None where the fluid has none."""
        parts = self.snapshot.stress_xx, self.snapshot.stress_xy, self.snapshot.stress_yy
        return None if parts[0] is None else parts

    @cached_property
    def reference(self) -> dict[str, np.ndarray]:
        """The reference solution at the particles by field (``u``, ``v``, ...); empty where the scene has none."""
        return with_reference(self._scene, self.snapshot).reference or {}

    @cached_property
    def error(self) -> np.ndarray | None:
        """Size of the difference between velocity and reference at each particle; None without a reference.

        Of the components that have a reference, one or both.
        """
        values, exact = velocities(self._scene, self.snapshot)
        return np.linalg.norm(values - exact, axis=0) if len(exact) else None

    @cached_property
    def l2(self) -> float | None:
        """Relative error sqrt(sum error^2 / sum reference^2), as in ``summary.json``; None where there is none."""
        return relative_error(self._scene, self.snapshot)
