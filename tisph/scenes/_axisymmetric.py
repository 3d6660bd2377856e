"""Axisymmetric flow: a half-plane y >= 0 above the axis, with walls of revolution.

x is along the axis, y the distance from it, w the velocity around it. Here are the config and the scene that all
axisymmetric flows share, their measures (forces and torques on whole walls, kinetic energies, mean velocity), and their
profiles over the radius.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tisph.config import schema
from tisph.config.base import Model, Problem
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.region import Region
from tisph.geometry.shape import POINTS, volume_of_revolution
from tisph.measures.fits import max_void_radius, min_distance, section_weights, with_walls
from tisph.scenes._body_scene import BodyScene
from tisph.scenes._initial import incommensurate_periods
from tisph.scenes._views import Line as ProfileLine
from tisph.scenes._views import Profile, TimeSeries
from tisph.scenes.annulus import scales
from tisph.snapshot import STRESSES_AROUND


class Config(schema.Config):
    """A run of axisymmetric flow, periodic along the axis: x along it, y the distance from it.

    The spacing is the nearest to the one given of which the length is a whole number.
    """

    geometry: Model

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
        """What the scene has against the config."""
        if self.scheme.type == "wcsph":
            yield "scheme.type", "wcsph is planar; take auto or implicit"
        if self.discretisation.precision == "f32":
            yield "discretisation.precision", "must be f64 in axisymmetric flow"

    def incommensurate(self) -> Iterator[Problem]:
        """A length that is too short."""
        return incommensurate_periods(self)


ENERGIES = "kinetic_energy_axial", "kinetic_energy_radial", "kinetic_energy_azimuthal"
"""Names of ``kinetic_energies``."""


def loads(scene, snapshot):
    """Force along the axis and torque around it of the fluid on each wall: ``force_NAME`` and ``torque_NAME``.

    Forces on bodies have the part of the mean pressure gradient.
    """
    found, gradient = {}, scene.density * acceleration(scene, snapshot)
    for index, name in enumerate(scene.names):
        pressed = gradient * scene.volumes[index] if gradient else 0.0
        found[f"force_{name}"] = snapshot.bodies.force[index, 0] + pressed
        found[f"torque_{name}"] = snapshot.bodies.torque[index]
    return found


def acceleration(scene, snapshot):
    """That of the fluid along the axis by the mean pressure gradient."""
    return scene.acceleration if snapshot.acceleration is None else snapshot.acceleration


def kinetic_energies(snapshot):
    """Mean kinetic energies per mass (3,) over the volume: of the flow along the axis, along radii and around the axis.

    Particles are even in the half-plane, so that each has the weight of its distance from the axis.
    """
    parts = (snapshot.u, snapshot.v, snapshot.w)
    return np.array([0.5 * float(np.average(np.square(part), weights=snapshot.y)) for part in parts])


def mean_velocity(scene, snapshot):
    """Mean velocity along the axis over a cross-section."""
    positions, velocity = with_walls(scene, snapshot)
    return float(section_weights(scene.seen(snapshot), positions, snapshot.t) @ velocity[:, 0])


def spread(scene, snapshot):
    """Nearest two particles and largest void, in spacings, and the divergence, see ``_two_dimensional.diagnostics``."""
    return {
        "divergence_over_gradient": snapshot.divergence,
        "min_distance": min_distance(scene, snapshot),
        "max_void_radius": max_void_radius(scene, snapshot),
        "density_variation": 0.0,
    }


NAMES = {"u": "u", "v": "u_r", "w": "u_θ"}
"""Velocities along the axis, along radii and around the axis, as pictures call them."""


def across(scene, place=None):
    """The line over the radius at ``place`` along the axis, with the particles half a spacing around it, or all."""
    ends = scene.inner_radius, scene.outer_radius
    return ProfileLine("y", ends, 0.0) if place is None else ProfileLine("y", ends, place, 0.5 * scene.spacing)


def velocity(scene, field, line, **reference):
    """The Profile of a velocity, the ``field`` u, v or w, on a ``line``."""
    return Profile(NAMES[field], "velocity", line, of=lambda snapshot: getattr(snapshot, field), **reference)


def loads_series(scene, columns, **others):
    """The TimeSeries of loads on walls, the ``columns`` of ``loads``; ``others`` are of its fields."""
    area = 2.0 * np.pi * scene.outer_radius * scene.length
    force = area * scene.dynamic_viscosity * scene.reference_velocity / scene.reference_length
    kinds = [("force", "whole_force") if name.startswith("force") else ("torque", "moment") for name in columns]

    def measure(snapshot):
        found = loads(scene, snapshot)
        return np.array([found[name] for name in columns])

    labels = [(name.replace("_", " on ", 1), None) for name in columns]
    return TimeSeries(
        content="forces along the axis and torques around it of the fluid on the walls",
        name=kinds[0][0],
        unit=kinds[0][1],
        scale=force,
        columns=list(columns),
        measure=measure,
        sizes=[force if kind == "force" else force * scene.outer_radius for kind, _ in kinds],
        panels=kinds,
        **{"labels": labels} | others,
    )


def only_first(series):
    """Of a TimeSeries of loads those of the first kind."""
    return series.only(series.name, series.name, series.unit)


@dataclass(frozen=True, kw_only=True)
class AxisymmetricScene(BodyScene):
    """Fluid from ``inner_radius`` to ``outer_radius`` around a ``length`` of the axis; all in the config's units.

    ``names`` are those of ``bodies``, which are walls of revolution; the fluid reaches the axis where ``inner_radius``
    is 0. Forces are those on whole bodies of revolution, one period long. ``left`` is where the length begins along the
    axis, ``periodic`` as of ``Scene``.
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
    def origin(self):
        """Lowest corner of the half-plane that holds fluid."""
        return self.left, self.inner_radius

    @property
    def extent(self):
        """Length, and difference of the radii."""
        return self.length, self.outer_radius - self.inner_radius

    @cached_property
    def region(self):
        """The fluid's region at t = 0, with the axis as a wall where the fluid reaches it."""
        high, bodies = (self.left + self.length, self.outer_radius), self.bodies
        if self.inner_radius == 0.0:
            bodies = (axis(self.length), *bodies)
        return Region(bodies, self.origin, high, self.periodic, axisymmetric=True)

    @cached_property
    def volumes(self):
        """Volumes of the closed ones of the ``bodies``, as what is turned around the axis; 0 of the others."""
        return [
            volume_of_revolution(body.boundary_points(body.shape.length / POINTS)) if body.shape.area else 0.0
            for body in self.bodies
        ]

    @property
    def reference_length(self):
        """Difference of the radii."""
        return self.extent[1]

    @property
    def fastest_wall(self):
        """Speed of the fastest wall or body, as the config gives it."""
        return max(map(wall_speed, self.bodies))

    @property
    def velocity_scale(self):
        """``fastest_wall``."""
        return self.fastest_wall

    @property
    def time_scale(self):
        """Viscous time of the difference of the radii."""
        return self.viscous_time

    @property
    def swirls(self):
        """Whether a wall turns around the axis."""
        return any(body.spin.largest_speed for body in self.bodies)

    @property
    def jump_times(self):
        """Times above 0 at which the angular velocity of a wall, or its slope, jumps."""
        return tuple(sorted({time for body in self.bodies for time in body.spin.jump_times}))

    def narrowest(self, t):
        """Radius of the inner wall, and gap between the walls.

        Where that wall turns the shear rate falls as r^(-2/n), n the index of a power law: as that of a Newtonian fluid
        does at n times the radius.
        """
        index = min(1.0, getattr(self.rheology, "index", 1.0)) if self.swirls else 1.0
        what = "the radius of the inner wall" + (f" times the fluid's index {index:g}" if index < 1.0 else "")
        return (index * self.inner_radius or np.inf, what), (self.extent[1], "the gap between the walls")

    def open_section(self, t):
        """Place along the axis of a cross-section with no body in it."""
        return 0.0

    def initial(self, x, y):
        """Rest, without stress."""
        around = STRESSES_AROUND[: None if self.swirls else 1] if self.polymer else ()
        return {**super().initial(x, y), **dict.fromkeys(("w", *around), np.zeros(np.shape(x)))}

    def movie_profiles(self):
        """See ``Scene.movie_profiles``; the velocity around the axis is called as its colour is."""
        found = super().movie_profiles()
        around = found.get(NAMES["w"])
        return found | {"swirl": replace(around, name="swirl")} if around else found

    def movie_fields(self, name):
        """See ``Scene.movie_fields``; the trace has the stress around the axis, too."""
        return *super().movie_fields(name), *STRESSES_AROUND[: name == "conformation_trace"]

    def description(self):
        """Radii and length."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "length": self.length}

    def parameters(self, length=None, cause=None):
        """Pairs (label, text) of the flow, independent of particles; in words, the ``length`` H and the ``cause`` of U.

        Without a cause U is that of the fastest wall, or an estimate.
        """
        length = length or ("the difference of the radii" if self.inner_radius else "the radius")
        if self.reference_velocity == self.fastest_wall:
            cause = "of the fastest wall or body"
        return scales(self, length, cause or "an estimate: by load or drive, in a Newtonian fluid", cause is not None)


def axis(length):
    """The axis as a wall, for the arrangement of particles."""
    return Body(Line((0.0, 0.0), (1.0, 0.0), length))


def cylinder(radius, length, outer, **motion):
    """The wall of a cylinder, with the fluid inside it where it is the ``outer`` one; ``motion`` as of ``Body``."""
    line = Line((length, radius), (-1.0, 0.0), length) if outer else Line((0.0, radius), (1.0, 0.0), length)
    return Body(line, **motion)


def layer_at_plates(scene):
    """Depth sqrt(nu/Omega) of layers at walls across the axis (von Karman 1921), Omega of the fastest, and a name."""
    fastest = max(body.spin.largest_speed for body in scene.bodies)
    return np.sqrt(scene.kinematic_viscosity / fastest) if fastest else np.inf, "the layer at walls that turn"


def wall_speed(body):
    """Largest speed of a wall, along the axis and around it."""
    turning = body.spin.largest_speed * (body.centre[1] + body.shape.extent[1, 1]) if body.spin.largest_speed else 0.0
    return float(np.hypot(body.motion.x.largest_speed, turning))
