"""Wall treatments of scheme ``wcsph``: the values that wall particles carry beyond a no-slip wall. One file each.

A file has the formulas in its docstring, ``Parameters``, and a function ``treatments`` with the classes that Taichi
compiles. Only that function imports Taichi, so that a config is read without it.
"""

from typing import TYPE_CHECKING, ClassVar, NamedTuple

from tisph.config.base import Model

if TYPE_CHECKING:
    from tisph.schemes.wcsph.walls._treatment import SolidWalls, WallTreatment


class WallParameters(Model):
    """Base of the parameters of a wall treatment: ``type``, its name, and numbers of its own."""

    obeys_momentum: ClassVar[bool] = False
    """Whether image velocities follow from the momentum equation at the wall."""

    type: str


class Treatments(NamedTuple):
    """Classes of a wall treatment: for the plane walls of a channel, and for the walls of bodies, None without one."""

    channel: "type[WallTreatment]"
    bodies: "type[SolidWalls] | None" = None
