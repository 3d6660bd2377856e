"""Keys of the config of flow in a pipe: its geometry, walls and drive."""

from typing import ClassVar, Literal

from pydantic import model_validator

from tisph.config.base import Model, NonNegative, Positive, Signed, refusals
from tisph.config.motion import Amplitude
from tisph.config.motion import WallMotion as Oscillation


class Geometry(Model):
    """Radius and length of the pipe [length]; ``inner_radius`` of a second one inside, 0 without."""

    radius: Positive
    length: Positive
    inner_radius: NonNegative = 0.0

    @model_validator(mode="after")
    def _check_order(self) -> "Geometry":
        if not self.inner_radius < self.radius:
            text = f"must be less than geometry.radius {self.radius:g}"
            raise refusals([(("inner_radius",), text, self.inner_radius)])
        return self


class Cylinder(Model):
    """Velocity along the axis [length/time] and angular velocity around it [1/time] of a wall, from t = 0 on."""

    velocity: Signed = 0.0
    angular_velocity: Signed = 0.0


class Walls(Model):
    """The walls of the pipe: ``outer``, and ``inner`` where there is one."""

    unset_keys = ("inner",)

    outer: Cylinder = Cylinder()
    inner: Cylinder | None = None


class Drive(Oscillation):
    """Acceleration along the axis [length/time^2], -(dp/dx)/density: constant, or oscillating.

    ``acceleration``; or ``amplitude`` * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t.
    """

    speed_key = "acceleration"
    exclusive_keys = ("acceleration", "amplitude")
    unset_keys = ("angular_frequency", "phase")

    acceleration: Signed | None = None
    amplitude: Amplitude | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None

    acceleration_before: ClassVar[None] = None
