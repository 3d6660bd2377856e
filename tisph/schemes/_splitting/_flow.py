"""What the scheme has to know of a flow: a doubly periodic box, its liquid and its scales."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class PeriodicFlow:
    """``columns`` x ``rows`` particles ``spacing`` apart in a box without walls, in any consistent units.

    ``reference_velocity`` is the velocity that errors and steps refer to, as seen from the frame of the mean flow.
    """

    columns: int
    rows: int
    spacing: float
    density: float
    kinematic_viscosity: float
    reference_velocity: float
    start_time: float = 0.0

    @property
    def length(self):
        """Period along x."""
        return self.columns * self.spacing

    @property
    def gap(self):
        """Period along y."""
        return self.rows * self.spacing
