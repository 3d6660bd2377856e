"""What schemes ask of a wall treatment before anything is compiled."""

from typing import ClassVar

from tisph.config.base import Model


class WallParameters(Model):
    """Base of the parameters of a wall treatment: a ``type``, which is its name, and numbers of its own."""

    obeys_momentum: ClassVar[bool] = False
    """Whether image velocities follow from the momentum equation at the wall."""

    type: str
