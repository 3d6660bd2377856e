"""Taylor-Couette flow: fluid between two cylinders that turn around one axis; Taylor's vortices.

The flow is axisymmetric. It is periodic along the axis, or between end plates, which make vortices of their own. It
starts at rest, or as the laminar flow A r + B/r around the axis of cylinders that have always turned, with the stress
of an Oldroyd-B fluid. ``disturbance`` adds one pair of vortices in the length; it is their largest radial velocity over
the speed of the fastest wall. Above the critical Reynolds number of their wavenumber the vortices grow, exponentially
at first, until they carry a part of the torque (G. I. Taylor, Phil. Trans. R. Soc. A 223 (1923) 289-343).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from tisph.config.base import NonNegative, Positive, Problem
from tisph.config.motion import slip_length_of
from tisph.exact.taylor_vortices import coefficients
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.motion import STILL
from tisph.measures.flow import Size
from tisph.scenes import _axisymmetric, annulus
from tisph.scenes._axisymmetric import AxisymmetricScene, cylinder, layer_at_plates
from tisph.scenes._initial import RestInitial, still_problem
from tisph.scenes._scene import Reference
from tisph.scenes._views import Profile, TimeSeries
from tisph.scenes.annulus import turning_of
from tisph.snapshot import Snapshot

RECENT = 0.1
"""Last fraction of the elapsed time, over which the growth rate is computed."""


class Geometry(annulus.Radii):
    """Radii of the cylinders, and period along the axis, or distance of the ``end_plates`` [length].

    ``end_plates``: none in periodic flow, or plates at rest, or plates that turn with either cylinder.
    """

    length: Positive
    end_plates: Literal["none", "at_rest", "with_inner", "with_outer"] = "none"


class Initial(RestInitial):
    """Start: at rest, or as the laminar flow of cylinders that have always turned.

    ``disturbance``: largest radial velocity of a pair of vortices that is added, over the speed of the fastest wall.
    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y, after they have been
    spread evenly; the same ``seed`` gives the same displacements.
    """

    state: Literal["rest", "developed"] = "rest"
    disturbance: NonNegative = 0.0


class Config(_axisymmetric.Config):
    """A whole run of Taylor-Couette flow."""

    geometry: Geometry
    walls: annulus.Cylinders
    initial: Initial = Initial()

    across_name = "the gap between the cylinders"

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether the box is periodic in x and y."""
        return self.geometry.end_plates == "none", False

    @property
    def singular(self) -> bool:
        """Whether plates meet a cylinder that turns differently."""
        return not self.periodic[0] and len(set(_spins(self).values())) > 1

    @property
    def inner_radius(self) -> float:
        """Radius of the inner cylinder [length]."""
        return self.geometry.inner_radius

    @property
    def outer_radius(self) -> float:
        """Radius of the outer cylinder [length]."""
        return self.geometry.outer_radius

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        yield from super().problems()
        walls = {"inner": self.walls.inner, "outer": self.walls.outer}
        if not any(wall.speed or wall.amplitude or wall.angular_velocities for wall in walls.values()):
            yield from still_problem(self, "walls", annulus.TURN)
        developed = self.initial.state == "developed"
        if not self.periodic[0] and (developed or self.initial.disturbance):
            key = "initial.state" if developed else "initial.disturbance"
            yield key, "is for flow without geometry.end_plates: between these it starts from rest"
        for name, wall in walls.items():
            if wall.speed_before is not None:
                yield f"walls.{name}.angular_velocity_before", "is for scene annulus alone"
            if developed and wall.speed is None:
                yield "initial.state", f"must be rest where walls.{name} does not turn at a constant angular_velocity"
            if developed and wall.slip_length:
                yield "initial.state", f"must be rest where the fluid slips (walls.{name}): no laminar flow is built in"
        if developed and not self.fluid.linear:
            yield "initial.state", f"must be rest: the laminar flow of {self.fluid.rheology.type} is not built in here"


@dataclass(frozen=True, kw_only=True)
class Scene(AxisymmetricScene):
    """Two cylinders; ``developed``: whether they have always turned, ``disturbance`` as of ``Initial``."""

    developed: bool
    disturbance: float

    @property
    def flow_quantities(self) -> tuple[str, ...]:
        """Torques and largest radial velocity; no torques with end plates, where torques do not converge."""
        return (*("torque_inner", "torque_outer", "torque_ratio") * self.periodic[0], "radial_velocity")

    @classmethod
    def from_config(cls, config: "Config") -> "Scene":
        """Return the scene that a validated config describes."""
        radii, length = (config.inner_radius, config.outer_radius), config.geometry.length
        spins, gap = _spins(config), radii[1] - radii[0]
        slips = [slip_length_of(config.walls.inner), slip_length_of(config.walls.outer)]
        plates = Line((0.0, radii[1]), (0.0, -1.0), gap), Line((length, radii[0]), (0.0, 1.0), gap)
        return cls(
            **cls.fluid_of(config),
            length=length,
            inner_radius=radii[0],
            outer_radius=radii[1],
            periodic=config.periodic,
            names=tuple(spins),
            bodies=(
                cylinder(radii[0], length, outer=False, spin=spins["inner"], slip_length=slips[0]),
                cylinder(radii[1], length, outer=True, spin=spins["outer"], slip_length=slips[1]),
                *(Body(plate, spin=spins[name]) for plate, name in zip(plates, tuple(spins)[2:], strict=False)),
            ),
            developed=config.initial.state == "developed",
            disturbance=config.initial.disturbance,
        )

    @property
    def reference(self) -> Reference:
        """See ``Scene.reference``: the torque of laminar flow."""
        spins = [body.spin for body in self.bodies[:2]]
        constant = not any(spin.oscillates or spin.jump_times for spin in spins)
        assumptions = {"a Newtonian fluid": self.rheology is None, "flow without end plates": self.periodic[0]}
        assumptions["constant angular velocities"] = constant
        assumptions["cylinders without slip"] = not any(body.slip_length for body in self.bodies)
        return self.reference_for("torque of steady laminar flow", assumptions)

    @property
    def laminar(self) -> tuple[float, float]:
        """A and B of the steady laminar flow A r + B/r with the angular velocities at the start."""
        inner, outer = (float(body.spin.velocity(self.start_time)) for body in self.bodies[:2])
        return coefficients((self.inner_radius, self.outer_radius), (inner, outer))

    @property
    def laminar_torque(self) -> float:
        """Torque [mass length^2/time^2] of the steady laminar flow of a Newtonian fluid on the outer cylinder."""
        return 4.0 * np.pi * self.dynamic_viscosity * self.laminar[1] * self.length

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: the layer at end plates."""
        return super().thinnest_layer(t) if self.periodic[0] else layer_at_plates(self)

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return rest or laminar flow plus vortices with u_r = a(y) cos kx, div u = 0, and u = 0 at the walls."""
        fields = super().initial(x, y)
        gap, inner, outer = self.reference_length, y - self.inner_radius, self.outer_radius - y
        shape, slope = 16.0 * (inner * outer) ** 2, 32.0 * inner * outer * (outer - inner)
        speed, wave = self.disturbance * self.velocity_scale / gap**4, 2.0 * np.pi / self.length
        fields["u"] = -speed / wave * (slope + shape / y) * np.sin(wave * x)
        fields["v"] = speed * shape * np.cos(wave * x)
        if self.developed:
            fields["w"] = self.laminar[0] * y + self.laminar[1] / y
        if self.polymer and self.developed:
            ((_, _, _, around, _, shear),) = self._excess_at(x, y)
            modulus = (self.dynamic_viscosity - self.density * self.solvent_viscosity) / self.polymer.relaxation_time
            fields |= {"stress_tt": modulus * around, "stress_yt": modulus * shear}
        return fields

    @property
    def initial_conformation_excess(self) -> Callable | None:
        """Function of places x, y (n,) that returns C (components, n) of the polymer in laminar flow.

        C_rt = N and C_tt = 2 N^2, N = relaxation time * shear rate. None at rest and without polymer.
        """
        return self._excess_at if self.polymer and self.developed else None

    def _excess_at(self, x: np.ndarray, y: np.ndarray) -> list[tuple[np.ndarray, ...]]:
        assert self.polymer
        shear, none = -2.0 * self.polymer.relaxation_time * self.laminar[1] / y**2, np.zeros_like(y)
        return [(none, none, none, 2.0 * shear**2, none, shear)]

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return torques and forces on the cylinders, kinetic energies, and the growth rate of vortices.

        ``torque_inner``, ``torque_outer``: torque of the fluid on one period of a cylinder. ``torque_ratio``: torque on
        the inner cylinder over the torque of steady laminar flow; None where that is no ``reference``.
        ``radial_velocity``: the largest one, over the speed of the fastest wall. ``growth_rate`` [1/time]: of the
        radial velocity, from its mean square over the last tenth of the elapsed time; None where that is 0.
        """
        loads = self.loads(snapshot)
        known = self.reference.applies and self.laminar_torque
        return {
            **loads,
            "torque_ratio": -loads["torque_inner"] / self.laminar_torque if known else None,
            "radial_velocity": np.max(np.abs(snapshot.v)) / self.reference_velocity,
            "growth_rate": self._growth_rate(snapshot.t, series),
            **dict(zip(_axisymmetric.ENERGIES, self.kinetic_energies(snapshot), strict=True)),
            **self.spread(snapshot),
        }

    def _growth_rate(self, t: float, series: Sequence) -> float | None:
        if len(series) < 3:
            return None
        times, values = series[2]
        recent = (times <= t) & (times >= t - RECENT * (t - self.start_time))
        energy = values[recent, COLUMNS.index("kinetic_energy_radial")]
        if np.count_nonzero(recent) < 3 or not (energy > 0.0).all():
            return None
        return 0.5 * float(np.polyfit(times[recent], np.log(energy), 1)[0])

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        ratio, wave = self.inner_radius / self.outer_radius, 2.0 * np.pi * self.reference_length / self.length
        more = (("radius ratio", f"{ratio:.6g}"), ("axial wavenumber", f"{wave:.6g}  (2 pi H / length)"))
        return [*super().parameters(), *more, ("reference", str(self.reference))]

    def profiles(self) -> list[Profile]:
        """Return velocities around the axis and along radii where the disturbance's radial velocity is largest."""
        line = self.radial_line(0.0 if self.periodic[0] else 0.5 * self.length)
        return [self.radial_profile(name, line) for name in ("w", "v")]

    def time_series(self) -> TimeSeries:
        """Return torques on the cylinders, and kinetic energies."""
        torque, energy = abs(self.laminar_torque) or 1.0, 0.5 * self.reference_velocity**2
        sign = -self.laminar_torque
        return TimeSeries(
            content="torques of the fluid on the cylinders, and mean kinetic energies per mass along each axis",
            name="torque",
            unit="moment",
            scale=torque,
            columns=list(COLUMNS),
            labels=[(name, None) for name in ("inner cylinder", "outer cylinder", "axial", "radial", "azimuthal")],
            measure=lambda snapshot: np.array([*snapshot.bodies.torque[:2], *self.kinetic_energies(snapshot)]),
            sizes=[torque, torque, energy, energy, energy],
            panels=[*2 * [("torque", "moment")], *2 * [("energy of the vortices", "energy")], ("energy", "energy")],
            levels=[sign, -sign, *3 * [np.nan]] if self.reference.applies else (),
            level_name="laminar",
        )

    def movie_series(self) -> TimeSeries:
        """Return the torques on the cylinders, over those of laminar flow where these are known."""
        series = self.time_series().only("torque", "torque", "moment")
        if not (series.levels and self.laminar_torque):
            return series
        laminar = np.array(series.levels)
        return replace(
            series,
            name="torque over laminar torque",
            unit="number",
            columns=[f"{name}_ratio" for name in series.columns],
            measure=lambda snapshot: series.measure(snapshot) / laminar,
            levels=[1.0, 1.0],
        )


def _spins(config: "Config") -> dict[str, Any]:
    """Return the motions around the axis of cylinders and end plates by name."""
    found = {"inner": turning_of(config.walls.inner), "outer": turning_of(config.walls.outer)}
    if config.periodic[0]:
        return found
    plates = found.get(config.geometry.end_plates.removeprefix("with_"), STILL)
    return found | {"left": plates, "right": plates}


COLUMNS = ("torque_inner", "torque_outer", *_axisymmetric.ENERGIES)
