"""What a config says of every body: where it is, how it is turned and moves; and the ``Body`` that comes of it."""

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from tisph.config.base import Model, Positive, Signed, refusals
from tisph.config.fields import number_or
from tisph.geometry.body import Body
from tisph.geometry.motion import REST, RigidMotion, WallMotion

Point = Annotated[tuple[Signed, Signed], Field(strict=False)]
"""A place or a vector [x, y]."""

Points = Annotated[tuple[Point, ...], Field(strict=False, max_length=1000)]


class Motion(Model):
    """Velocity [length/time] of the centre and angular velocity [1/time, counterclockwise] from t = 0 on.

    Constant: ``velocity`` [u, v] and ``angular_velocity``. Oscillating: ``amplitude`` [u, v] of the velocity and
    ``angular_amplitude`` of the angular velocity * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t.
    """

    unset_keys = ("velocity", "angular_velocity", "amplitude", "angular_amplitude", "angular_frequency", "phase")

    velocity: Point | None = None
    angular_velocity: Signed | None = None
    amplitude: Point | None = None
    angular_amplitude: Signed | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None

    @model_validator(mode="after")
    def _check_forms(self) -> "Motion":
        swings, turns = self.amplitude is not None or self.angular_amplitude is not None, self.angular_frequency
        constant = [key for key in ("velocity", "angular_velocity") if getattr(self, key) is not None]
        found: list[tuple[Any, ...]] = []
        if not swings and not constant:
            found.append(((), "give velocity or angular_velocity, amplitude or angular_amplitude, or fixed", {}))
        if swings:
            text = "is only for a body of constant velocity; this one oscillates, which has an amplitude"
            found += [((key,), text, getattr(self, key)) for key in constant]
            if turns is None:
                found.append((("angular_frequency",), "is missing: a body with an amplitude oscillates", {}))
        else:
            text = "is only for a body that oscillates, which has an amplitude"
            alien = (key for key in ("angular_frequency", "phase") if getattr(self, key) is not None)
            found += [((key,), text, getattr(self, key)) for key in alien]
        if found:
            raise refusals(found)
        return self

    def rigid(self) -> RigidMotion:
        """The motion as walls have it."""
        if self.angular_frequency is None:
            parts = (*(self.velocity or (0.0, 0.0)), self.angular_velocity or 0.0)
            return RigidMotion(*map(WallMotion, parts))
        parts = (*(self.amplitude or (0.0, 0.0)), self.angular_amplitude or 0.0)
        sizes = [(part, 0.0) if self.phase != "sin" else (0.0, part) for part in parts]
        return RigidMotion(*(WallMotion(*size, self.angular_frequency) for size in sizes))


class Placed(Model):
    """``centre`` [length], which a body turns about, ``angle`` [radians] of it at t = 0, and its motion.

    Parameters of a shape add what it is, in the frame of its centre, and say of which key they make it.
    """

    shaped_by: ClassVar[str]

    centre: Point = (0.0, 0.0)
    angle: Signed = 0.0
    motion: number_or(Motion, "fixed") = "fixed"

    @model_validator(mode="after")
    def _check_shape(self) -> "Placed":
        try:
            self.shape()
        except ValueError as error:
            raise refusals([((self.shaped_by,), str(error), getattr(self, self.shaped_by))]) from None
        return self

    def shape(self):
        """The shape, with the fluid outside; ValueError where it is impossible."""
        raise NotImplementedError

    def body(self, periods: tuple[float, float] = (math.inf, math.inf)) -> Body:
        """The body, in a cell of these periods (infinite where it is not periodic)."""
        motion = REST if self.motion == "fixed" else self.motion.rigid()
        return Body(self.shape(), self.centre, self.angle, motion, periods)
