"""Taylor-Green vortices in a doubly periodic box: a periodic array of vortices that decay by viscosity.

The box holds n x m periods; particles start at cell centres, (i + 1/2) spacing, or displaced at random, with the exact
velocity. The fluid is a Newtonian one. See ``tisph/exact/taylor_green.py`` for the solution.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem, Whole
from tisph.exact import taylor_green
from tisph.measures.metrics import field_error, velocities
from tisph.scenes._scene import Scene as AnyScene
from tisph.scenes._views import (
    Profile,
    TimeSeries,
    centre_line,
    kinetic_energy,
    planar_diagnostics,
    pressure_profile,
    velocity_profile,
    vorticity_profile,
)
from tisph.snapshot import Snapshot

Cells = Annotated[Whole, Field(ge=1, le=1000)]


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
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0


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
        return self.geometry.cells[0] * self.geometry.length, self.geometry.cells[1] * self.geometry.length

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        if not self.fluid.newtonian:
            text = f"must be newtonian: the decay of these vortices is not known for {self.fluid.rheology.type}"
            yield "fluid.rheology.type", f"{text}; shear_layer has fluids with polymer in a periodic box"


@dataclass(frozen=True, kw_only=True)
class Scene(AnyScene):
    """The vortices; all quantities in the config's units. ``speed``: largest speed at t = 0."""

    length: float
    cells: tuple[int, int]
    speed: float

    flow_quantities = ("kinetic_energy", "dissipation")

    @classmethod
    def from_config(cls, config: "Config") -> "Scene":
        """Return the scene that a validated config describes."""
        return cls(
            **cls.fluid_of(config),
            length=config.geometry.length,
            cells=config.geometry.cells,
            speed=config.initial.velocity,
            columns=config.columns,
            rows=config.rows,
        )

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of all periods."""
        return self.cells[0] * self.length, self.cells[1] * self.length

    @property
    def reference_length(self) -> float:
        """The period."""
        return self.length

    @property
    def velocity_scale(self) -> float:
        """The largest speed at t = 0."""
        return self.speed

    @property
    def fields(self) -> tuple[str, ...]:
        """Velocities and pressure."""
        return ("u", "v", "pressure") if self.isothermal else ()

    def exact(self, field: str, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact value of one of ``fields``; the pressure has zero mean."""
        if field == "pressure":
            return taylor_green.pressure(x, y, t, density=self.density, **self._flow)
        return taylor_green.velocity(x, y, t, **self._flow)["uv".index(field)]

    def exact_vorticity(self, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact vorticity dv/dx - du/dy (1/time)."""
        return taylor_green.vorticity(x, y, t, **self._flow)

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the exact velocity when the run starts."""
        u, v = taylor_green.velocity(x, y, self.start_time, **self._flow)
        return {"u": u, "v": v}

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return energy, dissipation and momentum of a snapshot and its error of the pressure.

        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), the mean of p - p_exact being subtracted;
        ``kinetic_energy`` and ``dissipation`` per mass, means over the box, each also ``_exact``; ``momentum_drift``:
        magnitude of the mean of u - u_exact, over U; and ``planar_diagnostics``.

        Energy and dissipation are the exact means times the ratio of two means over the particles, of the computed and
        of the exact flow at the same places: the scatter of a mean over random places is not an error of the flow.
        """
        t, flow = snapshot.t, self._flow
        square, others = planar_diagnostics(self, snapshot)
        if not self.isothermal:
            return {"kinetic_energy": self._kinetic_energy(snapshot), **others}
        values, exact = velocities(self, snapshot)
        weight = snapshot.weight
        exact_square = np.mean(weight * np.square(self.exact_vorticity(snapshot.x, snapshot.y, t)))
        dissipation = taylor_green.dissipation(t, **flow)
        return {
            "l2_pressure": field_error(self, snapshot, "pressure"),
            "kinetic_energy": self._kinetic_energy(snapshot),
            "kinetic_energy_exact": taylor_green.kinetic_energy(t, **flow),
            "dissipation": dissipation * square / exact_square,
            "dissipation_exact": dissipation,
            "momentum_drift": np.linalg.norm(np.mean(weight * (values - exact), axis=1)) / self.reference_velocity,
            **others,
        }

    def description(self) -> dict[str, Any]:
        """Return period and numbers of periods."""
        return {"length": self.length, "cells": list(self.cells)}

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
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

    def profiles(self) -> list[Profile]:
        """Return velocities along the centre lines and pressure along the vertical one, with their errors."""
        scale = self.reference_velocity, self.velocity_name("largest speed U at the start")
        shown = [
            velocity_profile(self, field, along, exact=partial(self.exact, field), scale=scale)
            for field, along in (("u", "y"), ("v", "x"))
        ]
        return [self.compared(each) for each in (*shown, pressure_profile(self, centre_line(self, "y")))]

    def time_series(self) -> TimeSeries:
        """Return the kinetic energy."""
        series = TimeSeries(
            content="mean kinetic energy per mass over time t",
            name="kinetic energy per mass",
            unit="energy",
            scale=float(taylor_green.kinetic_energy(0.0, **self._flow)),
            columns=["kinetic_energy"],
            labels=[("mean over the box", None)],
            exact_columns=["kinetic_energy_exact"],
            measure=lambda snapshot: np.array([self._kinetic_energy(snapshot)]),
            exact=lambda times: taylor_green.kinetic_energy(times, **self._flow)[:, None],
        )
        return self.compared(series)

    def movie_profiles(self) -> dict[str, Profile]:
        """Return the velocities, and vorticity and pressure along the vertical centre line."""
        line = centre_line(self, "y")
        found = {
            "vorticity": vorticity_profile(self, line, self.exact_vorticity),
            "pressure": pressure_profile(self, line),
        }
        return super().movie_profiles() | {name: self.compared(each) for name, each in found.items()}

    @property
    def _flow(self) -> dict[str, float]:
        return {"length": self.length, "speed": self.speed, "kinematic_viscosity": self.kinematic_viscosity}

    def _kinetic_energy(self, snapshot: Snapshot) -> float:
        if not self.isothermal:
            return kinetic_energy(self, snapshot)
        exact = np.array(taylor_green.velocity(snapshot.x, snapshot.y, snapshot.t, **self._flow))
        square = np.sum(snapshot.weight * np.square([snapshot.u, snapshot.v], dtype=float))
        return taylor_green.kinetic_energy(snapshot.t, **self._flow) * square / np.sum(snapshot.weight * exact**2)
