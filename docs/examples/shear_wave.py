"""Decaying shear wave: u = U sin(2 pi y/L) exp(-nu (2 pi/L)^2 t) in a square box that is periodic in x and y."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from tisph.config import schema
from tisph.config.base import Model, Positive
from tisph.scenes._scene import Scene as AnyScene
from tisph.scenes._views import Line, Profile, TimeSeries


class Geometry(Model):
    """Side of the box, which is the wave length [length]."""

    length: Positive


class Initial(Model):
    """Amplitude [length/time], random displacement of the particles [spacings] and its seed."""

    velocity: Positive
    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 0


class Config(schema.Config):
    """A whole run of a shear wave."""

    geometry: Geometry
    initial: Initial

    periodic = (True, True)
    across_name = "the wave length"
    has_exact_velocity = True

    @property
    def across(self):
        """Return the length that ``particles_across`` counts."""
        return self.geometry.length

    @property
    def extent(self):
        """Return width and height of the box."""
        return self.geometry.length, self.geometry.length

    def problems(self):
        """Yield dotted key and message of each unsupported choice."""
        if self.fluid.rheology.type != "newtonian":
            yield "fluid.rheology.type", "must be newtonian: of other fluids the decay is not known"


@dataclass(frozen=True, kw_only=True)
class Scene(AnyScene):
    """The wave; every number is in the units of the config."""

    length: float
    speed: float

    fields = ("u", "v")

    @classmethod
    def from_config(cls, config):
        """Return the scene of a validated ``config``."""
        return cls(
            **cls.fluid_of(config),
            length=config.geometry.length,
            speed=config.initial.velocity,
            columns=config.columns,
            rows=config.rows,
        )

    @property
    def extent(self):
        """Return width and height of the box."""
        return self.length, self.length

    @property
    def reference_length(self):
        """Return the length of the Reynolds number."""
        return self.length

    @property
    def velocity_scale(self):
        """Return the velocity over which errors are given, unless a config has reference.velocity."""
        return self.speed

    def exact(self, field, x, y, t):
        """Return the exact value of one of ``fields`` at the points ``x``, ``y`` and the time ``t``."""
        number = 2 * np.pi / self.length
        wave = self.speed * np.exp(-self.kinematic_viscosity * number**2 * t) * np.sin(number * y)
        return wave + 0.0 * x if field == "u" else 0.0 * (wave + x)

    def initial(self, x, y):
        """Return the velocities at the start."""
        return {field: self.exact(field, x, y, self.start_time) for field in self.fields}

    def parameters(self):
        """Return label and text of each line of ``tisph check``."""
        speed = f"{self.reference_velocity:.6g} {self.units.length}/{self.units.time}"
        return [
            ("Reynolds number", f"{self.reynolds:.6g}  (U L / nu, L the wave length)"),
            (self.velocity_name("amplitude U"), speed),
        ]

    def profiles(self):
        """Return the curves of ``profiles.png``."""
        line = Line("y", (0.0, self.length), 0.5 * self.length, half_width=0.5 * self.spacing)
        exact, scale = lambda x, y, t: self.exact("u", x, y, t), (self.speed, "amplitude U at the start")
        return [Profile("u", "velocity", line, of=lambda snapshot: snapshot.u, exact=exact, scale=scale)]

    def time_series(self):
        """Return the columns of ``history.csv``, with their labels in ``history.png``."""
        return TimeSeries(
            content="root mean square of u over time t",
            name="root mean square of u",
            unit="velocity",
            scale=self.speed,
            columns=["u_rms"],
            labels=[("all particles", None)],
            exact_columns=["u_rms_exact"],
            measure=lambda snapshot: np.array([np.sqrt(np.mean(snapshot.u**2))]),
            exact=lambda times: self.exact("u", 0.0, 0.25 * self.length, times)[:, None] / np.sqrt(2.0),
        )
