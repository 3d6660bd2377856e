"""Circular Couette flow: fluid between two cylinders, either of which turns: steadily, from a jump on, oscillating,
or as velocities at some times say.

Particles fill the annulus evenly, the first layer half a spacing from the walls. Motion starts, or changes, at t = 0.
The run's clock starts at ``start_time``: at the initial time of the config for the state ``exact``, else at 0. The
fluid is any of ``tisph/rheology``. See ``tisph/exact/start_up.py`` for the reference.
"""

import math
from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem, Signed, findings, refusals, refuse
from tisph.config.fields import Member
from tisph.config.motion import Amplitude, Times, Values, WallMotion, check_as_many, check_schedule
from tisph.scenes._annulus.scene import Annulus
from tisph.scenes._initial import Initial, start_problems, still_problem

__all__ = ["Annulus", "Config", "Scene"]

WallTreatment = Member("walls", usual="adami")

TURN = "give walls.inner or walls.outer an angular_velocity other than 0"
"""Remedy where no cylinder moves."""

Scene = Annulus
"""The name under which a run asks a module of this folder for its scene."""


class Radii(Model):
    """Radii of the cylinders [length]."""

    inner_radius: Positive
    outer_radius: Positive

    @model_validator(mode="after")
    def _check_order(self) -> "Radii":
        if not self.inner_radius < self.outer_radius:
            text = f"must be greater than geometry.inner_radius {self.inner_radius:g}"
            raise refusals([(("outer_radius",), text, self.outer_radius)])
        return self


class Geometry(Radii):
    """Radii of the cylinders [length], and where their common axis is."""

    centre: Annotated[tuple[Signed, Signed], Field(strict=False)] = (0.0, 0.0)

    offset: ClassVar[float] = 0.0


class Cylinder(WallMotion):
    """Angular velocity of a cylinder from t = 0 on, counterclockwise: constant, or oscillating, or given at times.

    ``angular_velocity`` [radians/time], with ``angular_velocity_before`` for one that turned otherwise before t = 0; or
    ``amplitude`` [radians/time] * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t; or
    ``angular_velocities`` at ``times``, linear in between and constant before and after; where two times are equal it
    jumps.
    """

    speed_key = "angular_velocity"
    other_keys = ("angular_velocities",)
    exclusive_keys = ("angular_velocity", "amplitude", "angular_velocities")
    unset_keys = ("angular_velocity_before", "angular_frequency", "phase", "times")

    angular_velocity: Signed | None = None
    angular_velocity_before: Signed | None = None
    amplitude: Amplitude | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None
    times: Times | None = None
    angular_velocities: Values | None = None

    @model_validator(mode="after")
    def _check_schedule(self) -> "Cylinder":
        scheduled = self.angular_velocities is not None
        alien = ("angular_velocity_before", "angular_frequency", "phase") if scheduled else ("times",)
        word = "not" if scheduled else "only"
        refuse(findings(self, alien, f"is {word} for a wall with angular_velocities at times"))
        if scheduled:
            check_as_many(self, "angular_velocities")
            check_schedule(self, "angular_velocities")
        return self


class Cylinders(Model):
    """The two cylinders."""

    inner: Cylinder = Cylinder()
    outer: Cylinder = Cylinder()


class Walls(Cylinders):
    """The two cylinders, and how scheme ``wcsph`` treats their walls: null for its own choice."""

    treatment: Annotated[Model, WallTreatment] | None = None


class Config(schema.Config):
    """A whole run of circular Couette flow."""

    geometry: Geometry
    walls: Walls
    initial: Initial = Initial()

    periodic = (False, False)
    has_exact_velocity = True
    across_name = "the gap between the cylinders"

    @property
    def across(self) -> float:
        """The gap."""
        return self.geometry.outer_radius - self.geometry.inner_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Diameter of the outer cylinder, twice."""
        return 2 * self.geometry.outer_radius, 2 * self.geometry.outer_radius

    @property
    def area(self) -> float:
        """Area between the cylinders."""
        return math.pi * (self.geometry.outer_radius + self.geometry.inner_radius) * self.across

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature of the walls."""
        return self.geometry.inner_radius

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]: ``initial.time`` for state ``exact``, else 0."""
        return self.initial.time

    @property
    def members(self) -> dict[str, Model]:
        """Those of every scene, and the wall treatment where one is given."""
        return {**({"walls": self.walls.treatment} if self.walls.treatment else {}), **super().members}

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        yield from _rheology(self)
        walls = self.walls.inner, self.walls.outer
        speeds = {speed for wall in walls for speed in (wall.speed, wall.speed_before)} - {None}
        if speeds <= {0.0} and not any(wall.amplitude or wall.angular_velocities for wall in walls):
            yield from still_problem(self, "walls", TURN)
        yield from start_problems(self, ("inner", "outer"))
        scheduled = [name for name in ("inner", "outer") if getattr(self.walls, name).angular_velocities]
        if scheduled and self.initial.state != "rest":
            yield "initial.state", f"must be rest where a wall has velocities at times (walls.{scheduled[0]})"


def _rheology(config: Config) -> Iterator[Problem]:
    """Starts of fluids without a reference."""
    rheology = config.fluid.rheology
    swinging = any(getattr(config.walls, name).amplitude is not None for name in ("inner", "outer"))
    if rheology.type != "newtonian" and swinging and config.initial.state == "developed":
        text = f"the periodic flow of {rheology.type} between cylinders that oscillate is not built in"
        yield "initial.state", f"must be rest or exact: {text}"
