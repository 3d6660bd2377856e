"""How a wall moves, and what a polymer adds to a liquid: small parts of a scene."""

from dataclasses import dataclass

from tisph.geometry.motion import WallMotion

__all__ = ["Polymer", "WallMotion"]


@dataclass(frozen=True)
class Polymer:
    """Polymer in an Oldroyd-B liquid: relaxation time [time], and the solvent's share of the total viscosity."""

    relaxation_time: float
    solvent_fraction: float
