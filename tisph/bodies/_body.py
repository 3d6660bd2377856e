"""Keys of every body in a config: place, angle and motion; and the ``Body`` that they define."""

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from tisph.config.base import Model, NonNegative, Positive, Signed, findings, refusals, refuse
from tisph.config.fields import either
from tisph.config.motion import SlipLength, Spacing, slip_length_of
from tisph.geometry.body import Body
from tisph.geometry.motion import FREEDOMS, REST, FreeMotion, Inertia, RigidMotion, WallMotion
from tisph.geometry.shape import Shape, centroid, polar_moment

Point = Annotated[tuple[Signed, Signed], Field(strict=False)]
"""A place or a vector [x, y]."""

Holds = Annotated[tuple[Literal["x", "y", "angle"], ...], Field(strict=False, max_length=3)]

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
            found += findings(self, constant, text)
            if turns is None:
                found.append((("angular_frequency",), "is missing: a body with an amplitude oscillates", {}))
        else:
            text = "is only for a body that oscillates, which has an amplitude"
            found += findings(self, ("angular_frequency", "phase"), text)
        refuse(found)
        return self

    def rigid(self) -> RigidMotion:
        """Return the motion of the wall of the body."""
        if self.angular_frequency is None:
            parts = (*(self.velocity or (0.0, 0.0)), self.angular_velocity or 0.0)
            return RigidMotion(*map(WallMotion, parts))
        parts = (*(self.amplitude or (0.0, 0.0)), self.angular_amplitude or 0.0)
        sizes = [(part, 0.0) if self.phase != "sin" else (0.0, part) for part in parts]
        return RigidMotion(*(WallMotion(*size, self.angular_frequency) for size in sizes))


if TYPE_CHECKING:
    BodyMotion = Motion | Literal["fixed", "free"]
else:
    BodyMotion = either(Motion, Literal["fixed", "free"], lambda value: isinstance(value, str), "fixed or free")

OFF_CENTRE = 1e-4
"""Largest distance of a free body's centre of mass from its centre, over the square root of its area."""

FREE_KEYS = (
    *("density", "mass", "moment_of_inertia", "velocity", "angular_velocity", "hold", "force", "torque", "enters"),
)


class Placed(Model):
    """``centre`` [length] of rotation, ``angle`` [radians] at t = 0, and motion of a body.

    A body whose motion is ``free`` is carried by the fluid. It has a ``density`` [mass/length^3], by default the
    density of the fluid, or a ``mass`` [mass/length] and a ``moment_of_inertia`` [mass length] around the centre, which
    is its centre of mass; a ``velocity`` [u, v] and an ``angular_velocity`` just before t = 0; an external ``force``
    [fx, fy] [mass/time^2] and ``torque``, per length across the plane; and ``hold``: the coordinates among x, y and
    angle that keep their initial velocity. It may be in the fluid from the time on at which it ``enters``, by default
    with the velocities of the fluid in its place.

    ``slip_length`` and ``spacing`` of its wall: see ``config/motion.py``.

    Parameters of a shape add its size, in the frame of the centre; ``shaped_by`` is the key that defines it.
    """

    shaped_by: ClassVar[str]
    unset_keys: ClassVar[tuple[str, ...]] = (*FREE_KEYS, "slip_length", "spacing")

    centre: Point = (0.0, 0.0)
    angle: Signed = 0.0
    motion: BodyMotion = "fixed"
    density: NonNegative | None = None
    mass: NonNegative | None = None
    moment_of_inertia: NonNegative | None = None
    velocity: Point | None = None
    angular_velocity: Signed | None = None
    hold: Holds = ()
    force: Point | None = None
    torque: Signed | None = None
    enters: Positive | None = None
    slip_length: SlipLength | None = None
    spacing: Spacing = None

    @model_validator(mode="after")
    def _check_free(self) -> "Placed":
        text = "is only for a body that the flow moves, with motion: free"
        found = findings(self, FREE_KEYS, text) if self.motion != "free" else []
        if self.density is not None and self.mass is not None:
            found.append((("mass",), "give density or mass, not both", self.mass))
        refuse(found)
        return self

    @model_validator(mode="after")
    def _check_shape(self) -> "Placed":
        try:
            shape = self.shape()
        except ValueError as error:
            raise refusals([((self.shaped_by,), str(error), getattr(self, self.shaped_by))]) from None
        if self.motion == "free":
            x, y = centroid(shape)
            if math.hypot(x, y) > OFF_CENTRE * math.sqrt(shape.area):
                text = f"of a free body must be around its centre of mass: here that is at [{x:.6g}, {y:.6g}]"
                raise refusals([((self.shaped_by,), text, getattr(self, self.shaped_by))])
        return self

    def shape(self) -> Shape:
        """Return the shape, with the fluid outside; ValueError where it is impossible."""
        raise NotImplementedError

    def body(self, periods: tuple[float, float] = (math.inf, math.inf), surroundings: Any = None) -> Body:
        """Return the body, in a cell of these periods (infinite where it is not periodic).

        For a free body ``surroundings`` have the ``density`` of the fluid and the ``acceleration`` and ``gravity`` (2,)
        that drive it.
        """
        motion: FreeMotion | RigidMotion = REST
        if self.motion == "free":
            motion = FreeMotion(self._inertia(surroundings))
        elif self.motion != "fixed":
            motion = self.motion.rigid()
        enters = -math.inf if self.enters is None else self.enters
        return Body(
            self.shape(), self.centre, self.angle, motion, periods, enters=enters, slip_length=slip_length_of(self)
        )

    def _inertia(self, surroundings: Any) -> Inertia:
        """Return inertia and external load of a free body.

        The computed pressure lacks the part that falls by density * acceleration along x and the hydrostatic part;
        their forces on the body are included in the load.
        """
        shape, fluid = self.shape(), surroundings.density
        density = fluid if self.density is None else self.density
        mass = density * shape.area if self.mass is None else self.mass
        moment = self.moment_of_inertia
        if moment is None:
            moment = polar_moment(shape) * mass / shape.area
        force = np.array(self.force or (0.0, 0.0)) + fluid * shape.area * np.array([surroundings.acceleration, 0.0])
        force += (mass - fluid * shape.area) * np.array(surroundings.gravity)
        velocity = (*(self.velocity or (0.0, 0.0)), self.angular_velocity or 0.0)
        load = (*force.tolist(), self.torque or 0.0)
        x, y, angle = (name in self.hold for name in FREEDOMS)
        along, turning = (self.enters is not None and each is None for each in (self.velocity, self.angular_velocity))
        carried = along and not x, along and not y, turning and not angle
        return Inertia((mass, mass, moment), load, velocity, (x, y, angle), carried)
