"""Taylor-Green vortices in a doubly periodic box: fluid that turns, and that viscosity alone brings to rest.

The box holds n x m periods; particles start at cell centres, (i + 1/2) spacing, or displaced at random, with the exact
velocity. The fluid is a Newtonian one. See ``tisph/exact/taylor_green.py`` for the solution.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem
from tisph.exact import taylor_green
from tisph.measures.metrics import field_error, velocities
from tisph.scenes import _two_dimensional
from tisph.scenes._scene import Scene as AnyScene
from tisph.scenes._views import TimeSeries

Cells = Annotated[int, Field(ge=1, le=1000)]


class Geometry(Model):
    """Period of the vortices [length], and how many periods there are along x and y (``cells``)."""

    length: Positive
    cells: Annotated[tuple[Cells, Cells], Field(strict=False)] = (1, 1)


class Initial(Model):
    """Largest speed at t = 0 [length/time].

    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y; the same ``seed`` gives
    the same displacements.
    """

    velocity: Positive
    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0


class Config(schema.Config):
    """A whole run of decaying vortices."""

    geometry: Geometry
    initial: Initial

    periodic = (True, True)
    has_exact_velocity = True
    across_name = "the period"

    @property
    def across(self) -> float:
        """The period."""
        return self.geometry.length

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of all periods."""
        return tuple(number * self.geometry.length for number in self.geometry.cells)

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        if self.fluid.rheology.type != "newtonian":
            text = f"must be newtonian: of {self.fluid.rheology.type} the decay of these vortices is not known"
            yield "fluid.rheology.type", f"{text}; shear_layer has fluids with polymer in a periodic box"


@dataclass(frozen=True, kw_only=True)
class Scene(AnyScene):
    """The vortices; every number in the config's units. ``speed`` is the largest one at t = 0."""

    length: float
    cells: tuple[int, int]
    speed: float

    fields = ("u", "v", "pressure")
    flow_quantities = ("kinetic_energy", "dissipation")

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        return cls(
            **cls.fluid_of(config),
            length=config.geometry.length,
            cells=config.geometry.cells,
            speed=config.initial.velocity,
            columns=config.columns,
            rows=config.rows,
        )

    @property
    def extent(self):
        """Width and height of all periods."""
        return tuple(number * self.length for number in self.cells)

    @property
    def reference_length(self):
        """The period."""
        return self.length

    @property
    def velocity_scale(self):
        """The largest speed at t = 0."""
        return self.speed

    def exact(self, field, x, y, t):
        """Exact value of one of ``fields``; of zero mean for the pressure."""
        if field == "pressure":
            return taylor_green.pressure(x, y, t, density=self.density, **self._flow)
        return taylor_green.velocity(x, y, t, **self._flow)["uv".index(field)]

    def exact_vorticity(self, x, y, t):
        """Exact vorticity dv/dx - du/dy (1/time)."""
        return taylor_green.vorticity(x, y, t, **self._flow)

    def initial(self, x, y):
        """The exact velocity when the run starts."""
        u, v = taylor_green.velocity(x, y, self.start_time, **self._flow)
        return {"u": u, "v": v}

    def diagnostics(self, snapshot, series):
        """Numbers of a snapshot with its reference.

        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), p - p_exact less its mean; ``kinetic_energy`` and
        ``dissipation`` per mass, means over the box, each also ``_exact``; ``momentum_drift``: size of the mean of u -
        u_exact over U; and those of ``_two_dimensional.diagnostics``.

        Mean energy and dissipation are the exact ones times what the particles have over what the exact flow has at
        their places: the scatter of a mean over places at random is not an error of the flow.
        """
        t, flow = snapshot.t, self._flow
        square, others = _two_dimensional.diagnostics(self, snapshot)
        values, exact = velocities(self, snapshot)
        exact_square = np.mean(np.square(self.exact_vorticity(snapshot.x, snapshot.y, t)))
        dissipation = taylor_green.dissipation(t, **flow)
        return {
            "l2_pressure": field_error(self, snapshot, "pressure"),
            "kinetic_energy": self._kinetic_energy(snapshot),
            "kinetic_energy_exact": taylor_green.kinetic_energy(t, **flow),
            "dissipation": dissipation * square / exact_square,
            "dissipation_exact": dissipation,
            "momentum_drift": np.linalg.norm(np.mean(values - exact, axis=1)) / self.reference_velocity,
            **others,
        }

    def description(self):
        """Period and numbers of periods."""
        return {"length": self.length, "cells": list(self.cells)}

    def parameters(self):
        """Numbers of the flow."""
        length, time = self.units.length, self.units.time
        rate = taylor_green.dissipation(0.0, **self._flow) / taylor_green.kinetic_energy(0.0, **self._flow)
        width, height = self.extent
        return [
            ("Reynolds number", f"{self.reynolds:.6g}  (U L / nu)"),
            (self.velocity_name("largest speed U"), f"{self.reference_velocity:.6g} {length}/{time}"),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("period L", f"{self.length:.6g} {length}, in a box of {width:.6g} x {height:.6g} {length}"),
            ("velocities decay in", f"{2 / rate:.6g} {time}  (by a factor e: 1 / (2 nu k^2))"),
        ]

    def profiles(self):
        """Velocities along the centre lines and pressure along the vertical one, with their errors."""
        return [self._velocity("u", "y"), self._velocity("v", "x"), self._pressure()]

    def time_series(self):
        """The kinetic energy."""
        return TimeSeries(
            content="mean kinetic energy per mass over time t",
            name="kinetic energy per mass",
            unit="energy",
            scale=taylor_green.kinetic_energy(0.0, **self._flow),
            columns=["kinetic_energy"],
            labels=[("mean over the box", None)],
            exact_columns=["kinetic_energy_exact"],
            measure=lambda snapshot: np.array([self._kinetic_energy(snapshot)]),
            exact=lambda times: taylor_green.kinetic_energy(times, **self._flow)[:, None],
        )

    def movie_profiles(self):
        """Also vorticity and pressure along the vertical centre line."""
        vorticity = _two_dimensional.vorticity_profile(self, _two_dimensional.centre_line(self, "y"))
        return {**super().movie_profiles(), "vorticity": vorticity, "pressure": self._pressure()}

    @property
    def _flow(self):
        return {"length": self.length, "speed": self.speed, "kinematic_viscosity": self.kinematic_viscosity}

    def _kinetic_energy(self, snapshot):
        values, exact = velocities(self, snapshot)
        return taylor_green.kinetic_energy(snapshot.t, **self._flow) * np.sum(values**2) / np.sum(exact**2)

    def _velocity(self, field, along):
        exact = lambda x, y, t: self.exact(field, x, y, t)  # noqa: E731
        scale = self.reference_velocity, self.velocity_name("largest speed U at the start")
        return _two_dimensional.velocity_profile(self, field, along, exact=exact, scale=scale)

    def _pressure(self):
        return _two_dimensional.pressure_profile(self, _two_dimensional.centre_line(self, "y"))
