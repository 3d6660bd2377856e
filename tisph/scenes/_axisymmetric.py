"""Axisymmetric flow: a half-plane y >= 0 above the axis, with walls of revolution.

x is along the axis, y the distance from it, w the velocity around it. ``Config`` and ``AxisymmetricScene`` are the
bases of all axisymmetric scenes. The scene's measures are forces and torques on whole walls, kinetic energies and the
mean velocity; its profiles are along the radius.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.config import schema
from tisph.config.base import Problem
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.region import Region
from tisph.geometry.shape import POINTS, volume_of_revolution
from tisph.measures.fits import max_void_radius, min_distance, section_mean
from tisph.measures.flow import Size
from tisph.scenes._initial import incommensurate_periods
from tisph.scenes._scene import BodyScene, bodies_in
from tisph.scenes._views import Line as ProfileLine
from tisph.scenes._views import Profile, TimeSeries
from tisph.scenes.annulus import scales
from tisph.snapshot import STRESSES_AROUND, Snapshot


class Config(schema.Config):
    """A run of axisymmetric flow, periodic along the axis: x along it, y the distance from it.

    The spacing is changed to the nearest one that divides the length.
    """

    geometry: Any

    axisymmetric = True
    periodic = (True, False)

    @property
    def inner_radius(self) -> float:
        """Radius of the inner wall [length], 0 where the fluid reaches the axis."""
        raise NotImplementedError

    @property
    def outer_radius(self) -> float:
        """Radius of the outer wall [length]."""
        raise NotImplementedError

    @property
    def across(self) -> float:
        """Difference of the radii."""
        return self.outer_radius - self.inner_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Length, and difference of the radii."""
        return self.geometry.length, self.across

    @property
    def spacing(self) -> float:
        """Particle spacing [length], which divides the length."""
        return self.geometry.length / max(1, round(self.geometry.length / super().spacing))

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        if self.scheme.type == "wcsph":
            yield "scheme.type", "wcsph is planar; take auto or implicit"
        if self.discretisation.precision == "f32":
            yield "discretisation.precision", "must be f64 in axisymmetric flow"

    def incommensurate(self) -> Iterator[Problem]:
        """Yield an error for a length that is too short."""
        return incommensurate_periods(self)


ENERGIES = "kinetic_energy_axial", "kinetic_energy_radial", "kinetic_energy_azimuthal"
"""Names of the ``kinetic_energies``."""

NAMES = {"u": "u", "v": "u_r", "w": "u_θ"}
"""Symbols in pictures of the velocities along the axis, along radii and around the axis."""


@dataclass(frozen=True, kw_only=True)
class AxisymmetricScene(BodyScene):
    """Fluid from ``inner_radius`` to ``outer_radius`` around a ``length`` of the axis; all in the config's units.

    ``bodies`` are walls and bodies of revolution with these ``names``. The fluid reaches the axis where
    ``inner_radius`` is 0. The length begins at x = ``left``. Forces are on whole bodies of revolution, one period long.
    """

    length: float
    inner_radius: float
    outer_radius: float
    names: tuple[str, ...]
    bodies: tuple[Body, ...]
    start_time: float = 0.0
    left: float = 0.0
    periodic: tuple[bool, bool] = (True, False)

    axisymmetric = True
    time_formula = "νt/H²"

    @property
    def origin(self) -> tuple[float, float]:
        """Lowest corner of the half-plane that holds fluid."""
        return self.left, self.inner_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Length, and difference of the radii."""
        return self.length, self.outer_radius - self.inner_radius

    @cached_property
    def region(self) -> Region:
        """The fluid's region at t = 0; the axis counts as a wall where the fluid reaches it."""
        high, bodies = (self.left + self.length, self.outer_radius), self.bodies
        if self.inner_radius == 0.0:
            bodies = (Body(Line((0.0, 0.0), (1.0, 0.0), self.length)), *bodies)
        return Region(bodies, self.origin, high, self.periodic, axisymmetric=True)

    @cached_property
    def volumes(self) -> list[float]:
        """Volume of each of the ``bodies`` as a body of revolution; 0 for walls that are not closed."""
        return [
            volume_of_revolution(body.boundary_points(body.shape.length / POINTS)) if body.shape.area else 0.0
            for body in self.bodies
        ]

    @property
    def reference_length(self) -> float:
        """Difference of the radii."""
        return self.extent[1]

    @property
    def fastest_wall(self) -> float:
        """Speed of the fastest wall or body in the config."""
        return max(map(wall_speed, self.bodies))

    @property
    def velocity_scale(self) -> float:
        """``fastest_wall``."""
        return self.fastest_wall

    @property
    def time_scale(self) -> float:
        """Viscous time of the difference of the radii."""
        return self.viscous_time

    @property
    def swirls(self) -> bool:
        """Whether a wall turns around the axis."""
        return any(body.spin.largest_speed for body in self.bodies)

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times above 0 at which the angular velocity of a wall, or its slope, jumps."""
        return tuple(sorted({time for body in self.bodies for time in body.spin.jump_times}))

    def narrowest(self, t: float) -> tuple[Size, Size]:
        """Return the radius of the inner wall, and the gap between the walls, as ``Scene.narrowest``.

        If that wall turns, the shear rate falls as r^(-2/n), n the index of a power law. This is the shear rate of a
        Newtonian fluid at a wall of n times the radius.
        """
        index = min(1.0, getattr(self.rheology, "index", 1.0)) if self.swirls else 1.0
        what = "the radius of the inner wall" + (f" times the fluid's index {index:g}" if index < 1.0 else "")
        radius = index * self.inner_radius or np.inf, what, self.wall_spacings[0]
        return radius, (self.extent[1], "the gap between the walls")

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields of a fluid at rest without stress."""
        around = STRESSES_AROUND[: None if self.swirls else 1] if self.polymer else ()
        return {**super().initial(x, y), **dict.fromkeys(("w", *around), np.zeros(np.shape(x)))}

    @property
    def named_loads(self) -> dict[str, tuple[int, int]]:
        """See ``Scene.named_loads``: loads on closed bodies, unless one is free."""
        named = [] if self.has_free_bodies else enumerate(zip(self.names, self.bodies, strict=False))
        closed, kinds = [(index, name) for index, (name, body) in named if body.shape.area], {"force": 0, "torque": 2}
        return {f"{kind}_{name}": (index, part) for index, name in closed for kind, part in kinds.items()}

    def loads(self, snapshot: Snapshot) -> dict[str, float]:
        """Return the fluid's force along the axis and torque around it on each wall: ``force_NAME``, ``torque_NAME``.

        Forces on bodies include the force of the mean pressure gradient.
        """
        found, bodies = {}, bodies_in(snapshot)
        gradient = self.density * self.axial_acceleration(snapshot)
        for index, name in enumerate(self.names):
            pressed = gradient * self.volumes[index] if gradient else 0.0
            found[f"force_{name}"] = bodies.force[index, 0] + pressed
            found[f"torque_{name}"] = bodies.torque[index]
        return found

    def axial_acceleration(self, snapshot: Snapshot) -> float:
        """Return the fluid's acceleration along the axis by the mean pressure gradient."""
        return self.acceleration if snapshot.acceleration is None else snapshot.acceleration

    def kinetic_energies(self, snapshot: Snapshot) -> np.ndarray:
        """Return the mean kinetic energies per mass (3,): of the flow along the axis, along radii and around the axis.

        The weight of each particle in the mean over the volume is its area in the half-plane times its radius y.
        """
        weight = snapshot.weight * snapshot.y
        parts: tuple[Any, ...] = (snapshot.u, snapshot.v, snapshot.w)
        return np.array([0.5 * float(np.average(np.square(part), weights=weight)) for part in parts])

    def mean_velocity(self, snapshot: Snapshot) -> float:
        """Return the mean velocity along the axis over a cross-section."""
        scene: Any = self.seen(snapshot)
        return section_mean(scene, snapshot, scene.open_section(snapshot.t))

    def spread(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return least distance of particles and largest void, in spacings, and the divergence.

        See ``_views.planar_diagnostics``.
        """
        return {
            "divergence_over_gradient": snapshot.divergence,
            "min_distance": min_distance(self, snapshot),
            "max_void_radius": max_void_radius(self, snapshot),
            "density_variation": 0.0,
        }

    def radial_line(self, place: float | None = None) -> ProfileLine:
        """Return the line over the radius with all particles, or with those half a spacing around x = ``place``."""
        ends = self.inner_radius, self.outer_radius
        return ProfileLine("y", ends, 0.0) if place is None else ProfileLine("y", ends, place, 0.5 * self.spacing)

    def radial_profile(self, field: str, line: ProfileLine, **reference: Any) -> Profile:
        """Return the Profile of the velocity u, v or w, ``field``, on a ``line``; ``reference``: its other fields."""
        return Profile(NAMES[field], "velocity", line, of=lambda snapshot: getattr(snapshot, field), **reference)

    def loads_series(self, columns: Sequence[str], **others: Any) -> TimeSeries:
        """Return the TimeSeries of the ``columns`` of ``loads``; ``others``: further fields of the TimeSeries."""
        area = 2.0 * np.pi * self.outer_radius * self.length
        force = area * self.dynamic_viscosity * self.reference_velocity / self.reference_length
        kinds = [("force", "whole_force") if name.startswith("force") else ("torque", "moment") for name in columns]
        name, unit = kinds[0] if kinds else ("force", "whole_force")

        def measure(snapshot: Snapshot) -> np.ndarray:
            found = self.loads(snapshot)
            return np.array([found[name] for name in columns])

        labels = [(name.replace("_", " on ", 1), None) for name in columns]
        return TimeSeries(
            content="forces along the axis and torques around it of the fluid on the walls",
            name=name,
            unit=unit,
            scale=force,
            columns=list(columns),
            measure=measure,
            sizes=[force if kind == "force" else force * self.outer_radius for kind, _ in kinds],
            panels=kinds,
            **{"labels": labels} | others,
        )

    def movie_series(self) -> TimeSeries:
        """Return the loads of the first kind in ``time_series``."""
        series = self.time_series()
        return series.only(series.name, series.name, series.unit)

    def movie_profiles(self) -> dict[str, Profile]:
        """See ``Scene.movie_profiles``; the velocity around the axis has the name of its colour, swirl."""
        found = super().movie_profiles()
        around = found.get(NAMES["w"])
        return found | {"swirl": replace(around, name="swirl")} if around else found

    def movie_fields(self, name: str) -> tuple[str, ...]:
        """See ``Scene.movie_fields``; conformation trace and viscosity also need the stress around the axis."""
        found = super().movie_fields(name)
        around = {"conformation_trace": 1, "viscosity": 3 if self.swirls else 1}.get(name, 0) if found else 0
        return *found, *STRESSES_AROUND[:around]

    def description(self) -> dict[str, float]:
        """Return radii and length."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "length": self.length}

    def parameters(self, length: str | None = None, cause: str | None = None) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles.

        ``length`` names the reference length H in words, ``cause`` the cause of the reference velocity U. Without a
        cause, U is the speed of the fastest wall, or an estimate.
        """
        length = length or ("the difference of the radii" if self.inner_radius else "the radius")
        if self.reference_velocity == self.fastest_wall:
            cause = "of the fastest wall or body"
        estimated = "an estimate: by load or drive, in a Newtonian fluid"
        return scales(self, (self.inner_radius, self.outer_radius), length, cause or estimated, cause is not None)


def cylinder(radius: float, length: float, outer: bool, **motion: Any) -> Body:
    """Return the wall of a cylinder, with the fluid inside it if it is ``outer``; ``motion``: fields of ``Body``."""
    line = Line((length, radius), (-1.0, 0.0), length) if outer else Line((0.0, radius), (1.0, 0.0), length)
    return Body(line, **motion)


def layer_at_plates(scene: AxisymmetricScene) -> tuple[float, str]:
    """Return the depth sqrt(nu/Omega) of the layer at the fastest wall across the axis, and its name (von Karman 1921).

    Omega is the angular velocity of that wall.
    """
    fastest = max(body.spin.largest_speed for body in scene.bodies)
    return np.sqrt(scene.kinematic_viscosity / fastest) if fastest else np.inf, "the layer at walls that turn"


def wall_speed(body: Body) -> float:
    """Return the largest speed of a wall, along the axis and around it."""
    turning = body.spin.largest_speed * (body.centre[1] + body.shape.extent[1, 1]) if body.spin.largest_speed else 0.0
    return float(np.hypot(body.motion.x.largest_speed, turning))
