"""``bodies.h5`` as a mapping: what bodies in the fluid do over time."""

import h5py
import numpy as np

from tisph.observers._storage import readable
from tisph.results._arrays import Arrays


class Trajectories(Arrays):
    """Bodies in the fluid at evenly spaced times: arrays by name, read when they are asked for.

    ``t`` (times,); ``centre`` (times, bodies, 2), not wrapped by periods; ``angle`` [radians], ``angular_velocity``
    (times, bodies), counterclockwise; ``velocity``, ``force`` and ``contact_force`` (times, bodies, 2); ``torque``,
    ``stresslet`` (times, bodies). Loads are per length across the plane, NaN at the start. All are in the units of the
    config.
    """

    def __repr__(self) -> str:
        return f"<Trajectories of {len(self.names)} bodies: {', '.join(self)}>"

    @property
    def names(self) -> list[str]:
        """Number of each body in the config, as in columns of the history."""
        return [str(name) for name in self._attribute("names")]

    @property
    def shapes(self) -> list[str]:
        """What each body is, such as ``circle``."""
        return [str(name) for name in self._attribute("shapes")]

    @property
    def free(self) -> np.ndarray:
        """Whether the flow carries each of the bodies, bool (bodies,)."""
        return np.asarray(self._attribute("free"), dtype=bool)

    def _attribute(self, name: str) -> np.ndarray:
        with readable(self._path), h5py.File(self._path, "r") as file:
            return np.asarray(file.attrs[name])
