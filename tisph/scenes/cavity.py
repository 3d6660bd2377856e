"""Lid-driven cavity: fluid in a box whose top slides, from rest to the steady state.

Particles fill the box evenly, the first layer half a spacing from the walls. The lid starts at t = 0. A ``sharp`` lid
has the same speed U everywhere: it slides past the corners, where the flow is singular. A ``regular`` lid has the speed
16 X^2 (1 - X)^2 U, X = x/width. The references are of the steady state of a Newtonian fluid, without inertia of Stokes
flow: see ``tisph/exact/cavity.py``.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem, Signed, findings, refusals, refuse
from tisph.config.motion import (
    SlipLength,
    Spacing,
    Times,
    Values,
    check_as_many,
    check_schedule,
    frictionless_findings,
    slip_length_of,
)
from tisph.config.schema import is_whole
from tisph.exact.cavity import LID, CentreLine, RegularCavity, centre_lines
from tisph.exact.cavity import extremes as tabulated_extremes
from tisph.exact.sliding_corner import CornerSingularity
from tisph.geometry.body import Body, SlidingWall
from tisph.geometry.line import Line
from tisph.geometry.motion import Schedule, SmoothSchedule, WallMotion
from tisph.measures.fits import interpolated, with_walls
from tisph.measures.flow import Size
from tisph.measures.steadiness import followed, steadiness
from tisph.scenes._initial import RestInitial, still_problem
from tisph.scenes._scene import BodyScene, Reference
from tisph.scenes._views import (
    Profile,
    TimeSeries,
    energy_series,
    kinetic_energy,
    planar_diagnostics,
    velocity_errors,
    velocity_profile,
)
from tisph.snapshot import Snapshot

DECAY_LENGTH, VISCOUS_DECAY_LENGTH, LEAST_DECAY_LENGTH = 0.5, 100.0, 4.0
"""Decay length of the inertial part of the corner flow: largest in shorter sides and in nu/U, least in spacings."""

RESOLVED_CORNER = 10.0
"""Cell Reynolds number U spacing/nu above which the inertial part is reduced: its gradients are too steep."""

LARGEST_REYNOLDS = 400.0
"""Reynolds number of the regular lid up to which the error of the reference is below 4e-7 in a square."""

LARGEST_ASPECT = 2.0
"""Height over width up to which the error of the reference is below 2e-5."""

DECAYED, SLOW = 1.0, 10.0
"""Viscous times of the larger side after which a start is over, up to this Reynolds number of the lid: the slowest mode
of Stokes flow in a square is then exp(-52). Energies scatter with the arrangement of particles, by 1e-3 of themselves
where velocities have errors of 3e-5, and may not tell."""

POINTS = 401
"""Points on a centre line among which its extremes are found."""


@dataclass(frozen=True, kw_only=True)
class Cavity(BodyScene):
    """The box 0 <= x <= ``width``, 0 <= y <= ``height`` under a lid; all quantities in the config's units.

    ``velocity``: velocity of a sharp lid, or of the middle of a ``regular`` one; of a lid that changes its velocity the
    one of the largest size. ``varying``: velocity in time of such a lid. ``slip_lengths``: of the ``bodies``.
    """

    width: float
    height: float
    velocity: float
    regular: bool
    slip_lengths: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    varying: Schedule | SmoothSchedule | None = None

    periodic = (False, False)
    names = ("bottom", "right", "lid", "left")
    flow_quantities = ("u_extreme", "v_min", "v_max", "kinetic_energy")

    @classmethod
    def from_config(cls, config: "Config") -> "Cavity":
        """Return the scene that a validated config describes."""
        return cls(
            **cls.fluid_of(config),
            width=config.geometry.width,
            height=config.geometry.height,
            velocity=config.walls.lid.largest_velocity,
            varying=config.walls.lid.varying,
            regular=config.walls.lid.profile == "regular",
            slip_lengths=config.walls.slip_lengths,
        )

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.width, self.height

    @property
    def course(self) -> WallMotion | Schedule | SmoothSchedule:
        """Velocity in time of a sharp lid, or of the middle of a regular one."""
        return self.varying or WallMotion(self.velocity)

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times above 0 at which the velocity of the lid, or its slope, jumps."""
        return tuple(self.course.jump_times)

    def _part(self, t: Any) -> Any:
        """Return the velocity of the lid at ``t`` over ``velocity``."""
        return self.course.velocity(t) / (self.velocity or 1.0)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Bottom, right wall, lid and left wall."""
        width, height = self.extent
        lid = Line((width, height), (-1.0, 0.0), width)
        profile = LID if self.regular else np.polynomial.Polynomial([1.0])
        bottom, right, top, left = self.slip_lengths
        return (
            Body(Line((0.0, 0.0), (1.0, 0.0), width), slip_length=bottom),
            Body(Line((width, 0.0), (0.0, 1.0), height), slip_length=right),
            SlidingWall(lid, slip_length=top, course=self.course, width=width, profile=profile),
            Body(Line((0.0, height), (0.0, -1.0), height), slip_length=left),
        )

    @cached_property
    def corners(self) -> tuple[CornerSingularity, ...]:
        """The two upper corners, past which a sharp lid slides; none where the fluid slips along it."""
        if self.regular or not self.velocity or self.bodies[2].slip_length:
            return ()
        cell = self.velocity_scale * self.spacing / self.kinematic_viscosity
        viscous = max(VISCOUS_DECAY_LENGTH * self.spacing / cell, LEAST_DECAY_LENGTH * self.spacing)
        same: dict[str, Any] = {
            "inward": (0.0, -1.0),
            "angle": 0.5 * np.pi,
            "kinematic_viscosity": self.kinematic_viscosity,
            "decay_length": min(DECAY_LENGTH * min(self.extent), viscous),
            "share": min(1.0, RESOLVED_CORNER / cell),
        }
        return tuple(
            CornerSingularity((x, self.height), (way, 0.0), speed=way * self.velocity, **same)
            for x, way in ((0.0, 1.0), (self.width, -1.0))
        )

    @property
    def reference_length(self) -> float:
        """The width."""
        return self.width

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """See ``Scene.drive_shown``."""
        return "lid", "velocity", (self.velocity, 0.0)

    def drive_share(self, t: float) -> float | None:
        """See ``Scene.drive_share``."""
        return float(self._part(t)) if self.varying else None

    @property
    def velocity_scale(self) -> float:
        """The largest speed of the lid."""
        return abs(self.velocity)

    @property
    def _unit(self) -> float:
        """Velocity over which velocities are given: of the lid, or the reference velocity under a lid at rest."""
        return self.velocity or self.reference_velocity

    @property
    def _lid_reynolds(self) -> float:
        """Reynolds number with the speed of the lid, by which references are tabulated."""
        return self.velocity_scale * self.width / self.kinematic_viscosity

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: the layer under the lid, in which fluid stays for a time width/U."""
        if not self.velocity:
            return math.inf, ""
        depth = self.layer_depth(min(t, self.width / self.velocity_scale))
        return depth, "the layer under the lid", self.wall_spacings[2]

    @property
    def steepness(self) -> float:
        """See ``FlowDefaults.steepness``, under a regular lid.

        On the lid, of velocity u(x), a large stretch A_xx obeys d ln A/dx = 2 u'/u - 1/(relaxation time u); shear adds
        to it. It grows from x_0, where the strain rate exceeds half the relaxation rate. Fluid that is x_0 below the
        lid there, and not stretched, comes to the middle at the distance x_0 u(x_0)/u: there the stress falls again.
        """
        if not (self.regular and self.velocity and self.polymer and self.linear):
            return 0.0
        x = np.linspace(0.0, 0.5, 10_001)[1:]
        passed = (2.0 * np.log(x / (1.0 - x)) + 1.0 / (1.0 - x) - 1.0 / x) / 16.0  # integral of dx/LID
        growth = 2.0 * np.log(LID(x)) - passed * self.width / (self.polymer.relaxation_time * self.velocity_scale)
        rise = growth - np.minimum.accumulate(growth)
        start = x[int(np.argmin(growth[: int(np.argmax(rise)) + 1]))]
        return float(rise.max() / max(1.0, start * LID(start) * self.width / self.spacing))

    @cached_property
    def reference(self) -> Reference:
        """See ``Scene.reference``: all are of the steady state."""
        assumptions = {"a Newtonian fluid": self.rheology is None, "walls without slip": not any(self.slip_lengths)}
        if not self.velocity:
            assumptions["a moving lid"] = False
        if not self.regular:
            assumptions["a square cavity"] = self.width == self.height
            assumptions["a tabulated Reynolds number"] = bool(self._tables)
            sources = ", ".join(sorted({table.source for table in self._tables})) or "tables"
            return self.reference_for(sources, assumptions | {"the steady state": True})
        assumptions[f"a height up to {LARGEST_ASPECT:g} widths"] = self.height <= LARGEST_ASPECT * self.width
        if self.inertia:
            assumptions["a lid of constant velocity, or no inertia"] = self.varying is None
            largest = f"a Reynolds number of the lid up to {LARGEST_REYNOLDS:g}"
            assumptions |= {largest: self._lid_reynolds <= LARGEST_REYNOLDS, "the steady state": True}
        name = "spectral solution" if self.inertia else "Stokes flow (spectral solution)"
        return self.reference_for(name, assumptions)

    @cached_property
    def _exact(self) -> RegularCavity | None:
        """The flow under the regular lid, None where there is no reference."""
        if not (self.regular and self.reference.applies):
            return None
        viscosity = self.kinematic_viscosity if self.inertia else math.inf
        return RegularCavity(self.width, self.height, self.velocity, viscosity)

    @cached_property
    def _tables(self) -> list[CentreLine]:
        """Tabulated centre lines of the square cavity under the sharp lid; none at other Reynolds numbers."""
        tabulated = self.velocity and self.width == self.height and not any(self.slip_lengths)
        if self.regular or not (tabulated and self.isothermal):
            return []
        try:
            return centre_lines(round(self._lid_reynolds, 9))
        except ValueError:
            return []

    def lines(self, snapshot: Snapshot, coordinate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return u (n,) on the vertical centre line and v (n,) on the other one, at ``coordinate`` (n,) from 0 to 1.

        ``measures/fits.py`` interpolates between particles and points on the walls.
        """
        upright = np.stack([np.full(len(coordinate), 0.5), coordinate], 1)
        points = np.concatenate([upright, upright[:, ::-1]]) * self.extent
        positions, velocity = with_walls(self, snapshot)
        found = interpolated(self, positions, velocity, points)
        return found[: len(upright), 0], found[len(upright) :, 1]

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return extremes of the velocities and other numbers of a snapshot, and their errors.

        Errors and exact values are None until the flow is steady; Stokes flow always is, slow flow after its start.
        ``u_extreme``: extreme of u on the vertical centre line, opposite to the lid's direction; ``v_min``, ``v_max``:
        extremes of v on the horizontal one; each also ``_exact``. All are over the speed of the lid.
        ``centre_line_error``: largest difference of u and v from the tables; with the regular lid ``l2``, ``rms`` and
        ``linf`` of the velocities. ``kinetic_energy`` per mass; ``planar_diagnostics``.
        """
        u, v = (line / self._unit for line in self.lines(snapshot, np.linspace(0.0, 1.0, POINTS)))
        numbers = {"u_extreme": u.min(), "v_min": v.min(), "v_max": v.max()}
        viscous_time = max(self.extent) ** 2 / self.kinematic_viscosity
        decayed = not self.varying and self._lid_reynolds <= SLOW and snapshot.t >= DECAYED * viscous_time
        known = steadiness(self, snapshot.t, followed(series)).steady or decayed or not self.inertia
        exact = self.extremes() if known else {}  # found in a second
        references = {f"{name}_exact": self._part(snapshot.t) * exact[name] if exact else None for name in numbers}
        errors = self._errors(snapshot) if known else {}
        others = planar_diagnostics(self, snapshot)[1]
        if self.corners:
            del others["divergence_over_gradient"]  # divergence and gradient are infinite in the corners
        return {
            **numbers,
            **references,
            "centre_line_error": None,
            **errors,
            "kinetic_energy": kinetic_energy(self, snapshot),
            **others,
        }

    def extremes(self) -> dict[str, float]:
        """Return the reference extremes over the speed of the lid, by their names in ``diagnostics``, if known."""
        if not (self._exact or self._tables):
            return {}
        known = self._exact.extremes() if self._exact else tabulated_extremes(round(self._lid_reynolds, 9))
        return {"u_extreme": known["u_min"], "v_min": known["v_min"], "v_max": known["v_max"]}

    def _errors(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return the errors of a steady state against the reference."""
        if self._exact:
            part = self._part(snapshot.t)
            if not part:
                return {}
            return velocity_errors(
                self, snapshot, *(part * each for each in self._exact.velocity(snapshot.x, snapshot.y))
            )
        differences = [
            self.lines(snapshot, self._along_lid(table))["uv".index(table.component)] / self.velocity - table.value
            for table in self._tables
        ]
        return {"centre_line_error": max((np.abs(difference).max() for difference in differences), default=None)}

    def _along_lid(self, table: CentreLine) -> np.ndarray:
        """Return the coordinates (n,) of a table, mirrored if the lid moves in the direction -x."""
        mirrored = self.velocity < 0 and table.component == "v"
        return 1.0 - table.coordinate if mirrored else table.coordinate

    def _curve(self, field: str, tables: list[CentreLine]) -> Callable:
        """Return a function of places on a centre line that interpolates ``tables`` of a ``field`` and the walls."""
        from scipy.interpolate import CubicSpline  # only pictures need it

        along = np.concatenate([[0.0, 1.0], *(self._along_lid(table) for table in tables)])
        values = np.concatenate([[0.0, float(field == "u")], *(table.value for table in tables)])
        places, first = np.unique(along.round(9), return_index=True)  # tables share some
        curve = CubicSpline(places, self.velocity * values[first])
        return lambda x, y, t: curve((y if field == "u" else x) / self.width) + 0.0 * t

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        length, time = self.units.length, self.units.time
        kind = "regular: 16 X^2 (1 - X)^2 of it" if self.regular else "sharp"
        given = [("reference velocity U", f"{self.given_velocity:.6g} {length}/{time}")] if self.given_velocity else []
        return [
            ("Reynolds number", f"{self.reynolds:.6g}  (U W / nu, W the width)"),
            *given,
            ("velocity of the lid", f"{'up to ' if self.varying else ''}{self.velocity:.6g} {length}/{time}, {kind}"),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("cavity", f"{self.width:.6g} x {self.height:.6g} {length}"),
            ("reference", str(self.reference)),
        ]

    def profiles(self) -> list[Profile]:
        """Return the velocities along the centre lines."""
        return [self._velocity("u", "y"), self._velocity("v", "x")]

    def time_series(self) -> TimeSeries:
        """Return the kinetic energy."""
        return replace(energy_series(self), may_be_steady=True)

    def _velocity(self, field: str, along: str) -> Profile:
        flow, tables = self._exact, [table for table in self._tables if table.component == field]
        reference: dict[str, Any] = {}
        if flow:
            scale = self.reference_velocity, self.velocity_name("speed of the lid")
            exact = lambda x, y, t: self._part(t) * flow.velocity(x, y)["uv".index(field)]  # noqa: E731
            name = "steady" if self.inertia else "Stokes flow"
            reference = {"exact": exact, "scale": scale, "reference": name, "steady": True}
        elif tables:
            name = tables[0].source if len(tables) == 1 else "published tables"  # frames have no room for two
            reference = {"exact": self._curve(field, tables), "reference": f"{name}, steady", "steady": True}
        return velocity_profile(self, field, along, **reference)


__all__ = ["Cavity", "Config", "Scene"]

Scene = Cavity
"""The name under which a run looks up the scene of a module of this folder."""


class Geometry(Model):
    """Sides of the box 0 <= x <= ``width``, 0 <= y <= ``height`` [length]."""

    width: Positive
    height: Positive


class Lid(Model):
    """Velocity along x of the lid y = height [length/time]: of the whole lid (sharp), or of its middle (regular).

    A constant ``velocity``, or ``velocities`` at ``times``: linear in between, with a jump where two times are equal,
    or a cubic spline if ``smooth``; constant before and after.

    ``slip_length`` and ``spacing``: see ``config/motion.py``.
    """

    speed_key: ClassVar[str] = "velocity"
    exclusive_keys = ("velocity", "velocities")
    unset_keys = ("times", "smooth", "slip_length", "spacing")

    velocity: Signed | None = None
    times: Times | None = None
    velocities: Values | None = None
    smooth: bool | None = None
    profile: Literal["sharp", "regular"] = "sharp"
    slip_length: SlipLength | None = None
    spacing: Spacing = None

    @model_validator(mode="after")
    def _check_friction(self) -> "Lid":
        refuse(frictionless_findings(self, ("velocity", "velocities")))
        return self

    @model_validator(mode="after")
    def _check_times(self) -> "Lid":
        if self.velocities is None:
            refuse(findings(self, ("times", "smooth"), "is only for a lid with velocities at times"))
            return self
        check_as_many(self, "velocities")
        check_schedule(self, "velocities")
        if self.smooth and len(set(self.times or ())) < len(self.velocities):
            raise refusals([(("smooth",), "must be left out where the velocity jumps", self.smooth)])
        return self

    @property
    def varying(self) -> Schedule | SmoothSchedule | None:
        """Velocity in time; None for a constant one."""
        if self.velocities is None or self.times is None:
            return None
        return (SmoothSchedule if self.smooth else Schedule)(self.times, self.velocities)

    @property
    def largest_velocity(self) -> float:
        """The velocity of the largest size."""
        return max(self.velocities or (self.velocity or 0.0,), key=abs)


class Side(Model):
    """A wall at rest; ``slip_length`` and ``spacing``: see ``config/motion.py``."""

    unset_keys = ("slip_length", "spacing")

    slip_length: SlipLength | None = None
    spacing: Spacing = None


class Walls(Model):
    """The lid; the other three walls are at rest."""

    unset_keys = ("bottom", "right", "left")

    lid: Lid
    bottom: Side | None = None
    right: Side | None = None
    left: Side | None = None

    @property
    def slip_lengths(self) -> tuple[float, ...]:
        """Slip lengths of the bottom, the right wall, the lid and the left wall."""
        return tuple(map(slip_length_of, (self.bottom, self.right, self.lid, self.left)))


class Config(schema.Config):
    """A whole run of a lid-driven cavity."""

    geometry: Geometry
    walls: Walls
    initial: RestInitial = RestInitial()

    periodic = (False, False)
    across_name = "the width"

    @property
    def across(self) -> float:
        """The width."""
        return self.geometry.width

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height."""
        return self.geometry.width, self.geometry.height

    @property
    def flow(self) -> str:
        """The flow in words, for titles."""
        if self.walls.lid.largest_velocity:
            return super().flow
        return "Cavity at rest" if self.isothermal else "Convection in a cavity"

    @property
    def singular(self) -> bool:
        """Whether the lid slides past corners, and drags the fluid there with it."""
        lid = self.walls.lid
        return lid.profile == "sharp" and lid.slip_length is None and lid.largest_velocity != 0.0

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        rheology = self.fluid.rheology
        if not self.fluid.newtonian and self.singular:
            text = f"must be regular with {rheology.type}"
            yield "walls.lid.profile", f"{text}: the corner flow under a sharp lid is known for newtonian fluids only"
        for side in ("bottom", "right", "left") if self.singular else ():
            if getattr(self.walls, side) and getattr(self.walls, side).slip_length:
                text = "must be left out under a sharp lid without slip: the flow in its corners is known without slip"
                yield f"walls.{side}.slip_length", text
        if self.singular and self.walls.lid.velocities:
            text = (
                "must be left out under a sharp lid without slip: the flow in its corners is known for a constant one"
            )
            yield "walls.lid.velocities", text
        if self.walls.lid.velocity == 0:
            yield from still_problem(self, "walls.lid.velocity", "give the lid a velocity other than 0")

    def incommensurate(self) -> Iterator[Problem]:
        """Yield an error for a height that is not a whole number of spacings."""
        if not is_whole(self.geometry.height / self.spacing):
            rows = max(1, round(self.geometry.height / self.spacing))
            nearest = f"{rows * self.spacing:.6g}"
            yield "geometry.height", f"must be a whole number of spacings of {self.spacing:.6g}; nearest: {nearest}"
