"""The protocol of a scene: a flow (``measures/flow.py``), its first particles, and the quantities that a run reports.

A scene is one file of this folder with two names: ``Config``, the model of its config (``tisph/config/schema.py``),
and ``Scene``, a frozen dataclass derived from the ``Scene`` here, or a maker of one. Observers, results and pictures
use only the members of the flow and those below. A scene must define every member whose default raises
NotImplementedError. ``BodyScene`` is the base of scenes with walls or bodies of any shape.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.motion import REST, RigidMotion, Schedule, WallMotion
from tisph.geometry.packing import number_of_particles, pack
from tisph.geometry.region import Region
from tisph.measures.fits import fluid_mean
from tisph.measures.flow import FlowInBox
from tisph.measures.substance import Substance
from tisph.scenes._views import COLOURS, ERRORS, Colour, ExtraSeries, MovieView, Profile, TimeSeries, substance_colour
from tisph.scenes._views import Line as ProfileLine
from tisph.snapshot import STRESSES, Bodies, Snapshot

if TYPE_CHECKING:  # which takes another process, for pictures, a while to import
    from tisph.config.schema import Config


@dataclass(frozen=True)
class Reference:
    """A reference by ``name``, and its ``assumptions``: words -> whether the config meets them."""

    name: str
    assumptions: Mapping[str, bool]

    @property
    def applies(self) -> bool:
        """Whether the config meets all assumptions."""
        return all(self.assumptions.values())

    def __str__(self) -> str:
        if self.applies:
            return f"{self.name}, for {'; '.join(self.assumptions)}"
        return f"none: {self.name} is for {'; '.join(words for words, met in self.assumptions.items() if not met)}"


def age(wall: Any, t: float) -> float:
    """Return the time since a ``wall`` that starts at t = 0 last jumped before ``t``; infinite if it has only kinks."""
    if isinstance(wall, Schedule):
        return wall.age(t)
    return t - max((change for change in wall.jump_times if change < t), default=0.0)


Shown = TypeVar("Shown", Profile, TimeSeries)


@dataclass(frozen=True, kw_only=True)
class Scene(FlowInBox):
    """A flow with its samples and views; all quantities in the config's units."""

    reference: ClassVar[Reference | None] = None
    """Reference whose assumptions some configs of the scene do not meet; None if there is none of this kind."""

    flow_quantities: ClassVar[tuple[str, ...]] = ()
    """Names of the ``diagnostics`` that are quantities of the flow, not errors: extrapolated to spacing 0."""

    extra_series: ClassVar[ExtraSeries | None] = None
    """Further columns of ``history.csv``, which are not drawn."""

    time_formula: ClassVar[str] = "Ut/L"
    """Formula of the time over ``time_scale``, for labels."""

    @classmethod
    def from_config(cls, config: "Config") -> "Scene":
        """Return the scene that a validated config describes."""
        raise NotImplementedError

    @staticmethod
    def fluid_of(config: "Config") -> dict[str, Any]:
        """Return the fluid, spacing and units of a validated config, as arguments of a scene."""
        return {
            "density": config.fluid.density,
            "kinematic_viscosity": config.kinematic_viscosity,
            "spacing": config.spacing,
            "units": config.units,
            "inertia": config.fluid.inertia,
            "rheology": None if config.fluid.newtonian else config.fluid.rheology,
            "given_velocity": config.reference.velocity if config.reference else None,
        }

    def compared(self, view: Shown) -> Shown:
        """Return a profile or time series, without its reference where the temperature acts on the flow."""
        return view if self.comparable else view.without_reference()

    def reference_for(self, name: str, assumptions: Mapping[str, bool]) -> Reference:
        """Return a reference with its ``assumptions``, which a temperature that acts on the flow breaks."""
        broken = {} if self.isothermal else {"a flow on which no temperature acts": False}
        return Reference(name, {**assumptions, **broken})

    def velocity_name(self, own: str) -> str:
        """Return the name of the reference velocity in tables and pictures: ``own`` for the ``velocity_scale``."""
        return "reference velocity U" if self.given_velocity else own

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """What movies show as the drive of the flow: its name, kind of unit, and largest components along x and y."""
        return "drive", "acceleration", (self.drive.largest, 0.0)

    def drive_share(self, t: float) -> float | None:
        """Return the drive at time ``t`` over ``drive_shown``; None if it is constant."""
        return self.drive.value(t) / self.drive.largest if self.drive.varies else None

    @cached_property
    def region(self) -> Region:
        """The fluid's region, a box without bodies."""
        return Region((), self.origin, tuple(np.add(self.origin, self.extent)), self.periodic)

    @cached_property
    def particles(self) -> int:
        """Number of fluid particles at the start."""
        if self.wanted_spacing.varies:
            return number_of_particles(self.region, self.wanted_spacing, self.start_time)
        return self.rows * self.columns

    def mean(self, snapshot: Snapshot, values: np.ndarray) -> float:
        """Return the mean over the fluid: between straight walls that of polynomials, else that of the particles."""
        if not all(isinstance(body.shape, Line) for body in self.bodies):
            return float(np.mean(snapshot.weight * values))
        size = np.array(self.extent)
        places = (np.stack([snapshot.x, snapshot.y], axis=1) - self.origin) / size
        return fluid_mean(places, values, snapshot.weight, size / self.spacing, self.periodic)

    def lattice(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the cell centres x, y (particles,), row by row from the bottom."""
        y, x = np.meshgrid(np.arange(self.rows) + 0.5, np.arange(self.columns) + 0.5, indexing="ij")
        return self.spacing * x.ravel(), self.spacing * y.ravel()

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return cell centres x, y (particles,) displaced at random, uniformly within +- ``jitter`` * spacing.

        ``0 <= jitter < 0.5`` (else ValueError), so that each particle stays in its cell, and in the box. The same
        ``seed`` gives the same positions. Where the spacing varies, particles fill the region (geometry/packing.py).
        """
        if not 0 <= jitter < 0.5:
            raise ValueError(f"jitter {jitter} is outside [0, 0.5)")
        if self.wanted_spacing.varies:
            x, y = pack(self.region, self.wanted_spacing, jitter, seed, self.particles, self.start_time).T
            return x, y
        x, y = self.lattice()
        shift_x, shift_y = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, x.size))
        return x + jitter * self.spacing * shift_x, y + jitter * self.spacing * shift_y

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields at the places ``x``, ``y`` (n,) at the start of the run, by name: at least u and v."""
        raise NotImplementedError

    def description(self) -> dict[str, Any]:
        """Return the sizes of the scene by name, for the files of a run."""
        width, height = self.extent
        return {"width": width, "height": height}

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles, for ``tisph check``."""
        raise NotImplementedError

    def profiles(self) -> list[Profile]:
        """Return the profiles of ``profiles.png``."""
        raise NotImplementedError

    def time_series(self, **settings: Any) -> TimeSeries:
        """Return the series of ``history.csv`` and ``history.png``; ``settings``: ``Config.time_series``."""
        raise NotImplementedError

    def movie_profiles(self) -> dict[str, Profile]:
        """Return the profile of each quantity that may colour a movie, by name; ``speed``: a velocity profile."""
        profiles = self.profiles()
        return {profile.name: profile for profile in profiles if profile.unit == "velocity"} | {"speed": profiles[0]}

    @property
    def substance_colours(self) -> dict[str, Colour]:
        """The quantities of ``output.video.color_by`` that are substances, by name."""
        return {each.name: substance_colour(each) for each in self.substances}

    def all_profiles(self) -> list[Profile]:
        """Return ``profiles`` and those of temperature and dissolved substances."""
        return [*self.profiles(), *map(self.substance_profile, self.substances)]

    def substance_profile(self, each: Substance) -> Profile:
        """Return the profile of a substance, on the line of another profile whose ends differ most in it."""
        colour, name = self.substance_colours[each.name], each.name
        exact = partial(self.exact, name) if name in self.fields else None
        lines = [profile.line for profile in self.profiles()]
        line = max(lines, key=lambda line: self._difference(each, line))
        scale = (each.scale, f"range of {colour.words}") if exact else None
        return Profile(colour.words, colour.unit, line, partial(colour.of, self), exact=exact, scale=scale)

    def _difference(self, each: Substance, line: ProfileLine) -> float:
        """Return the difference of the values that the walls at both ends of a line give a substance."""
        ends, t, found = np.stack(np.broadcast_arrays(*line.points(np.array(line.ends))), axis=1), self.start_time, []
        for end in ends if self.bodies else ():
            distances = [abs(body.nearest(end[None], t).distance[0]) for body in self.bodies]
            value = each.conditions[int(np.argmin(distances))].value
            found += [float(value(end[0], end[1], t))] if value else []
        return abs(found[1] - found[0]) if len(found) == 2 else 0.0

    def movie_series(self) -> TimeSeries:
        """Return the time series that a movie shows."""
        return self.time_series()

    def movie_marks(self, snapshot: Snapshot) -> list[tuple[str, float, float]]:
        """Return the places on walls that a movie marks: name, x and y of each."""
        return []

    def slip_wall_velocity(self, points: np.ndarray, t: float) -> np.ndarray:
        """Return the velocities (n, 2) of walls along which the fluid slips, at ``points`` on them; NaN elsewhere."""
        found = np.full(points.shape, np.nan)
        for body in (body for body in self.bodies if body.slip_length):
            there = np.abs(body.nearest(points, t).distance) < 1e-3 * self.spacing
            found[there] = body.velocity(points[there], t)
        return found

    def movie_ends(self, profile: Profile, end: float) -> Sequence[float]:
        """Return values that span the range of ``profile``, one of ``movie_profiles``, to time ``end``."""
        return profile.extremes(self.start_time, end)

    def movie_fields(self, name: str) -> tuple[str, ...]:
        """Return the fields that a movie coloured by ``name`` needs beside places, velocities and shear stress."""
        without = name == "viscosity" and not self.polymer  # which fields are those of a polymer's stress
        colours = COLOURS | self.substance_colours
        return () if without or name not in colours else colours[name].fields

    def movie_view(self, name: str, end: float) -> MovieView:
        """Return the view of a movie to time ``end`` whose fluid is coloured by ``name``, with the own profile, if any.

        The range is known before the run if that profile has an exact solution at all times.
        """
        carried = {each.name: each for each in self.substances}
        colour, own = (COLOURS | self.substance_colours)[name], self.movie_profiles()
        if name in carried:
            own = {**own, name: self.substance_profile(carried[name])}
        profile = own.get(name)
        of = profile.of if profile and colour.words != "speed" else lambda snapshot: colour.of(self, snapshot)
        words = profile.name if profile and colour.unit == "stress" and name != "pressure" else colour.words
        words = f"polymer {words}" if self.polymer and words == "shear stress" else words
        judged, errors = name if name in carried else "u", ERRORS | {each: (each, colour.words) for each in carried}
        known = profile if profile and profile.exact and judged in self.fields else None
        shown = profile or Profile(colour.words, colour.unit, own["speed"].line, of)
        return MovieView(
            name=words,
            signed=colour.signed,
            of=of,
            profile=shown,
            ends=self.movie_ends(known, end) if known else None,
            values=known.spread(self.start_time, end) if known else None,
            error=errors[name] if errors.get(name, ("",))[0] in self.fields else None,
            from_zero=colour.from_zero,
            base=colour.base[self.axisymmetric],
            walls=np.concatenate(
                [shown.of_slip_walls(self.slip_wall_velocity, t)[0] for t in (self.start_time, end)]
            ).tolist(),
        )


def bodies_in(snapshot: Snapshot) -> Bodies:
    """Return the state of the bodies in a snapshot of a scene with bodies."""
    assert snapshot.bodies is not None
    return snapshot.bodies


def farthest(shape: Any) -> float:
    """Return the largest distance of points of a ``shape`` from the centre of its body; 0 for a line."""
    return shape.largest_distance if shape.area else 0.0


def largest_speed(body: Body) -> float:
    """Return an upper bound of the speed of the points of a ``body``."""
    return body.motion.largest_speed(farthest(body.shape))


def open_place(bodies: Sequence[Body], length: float, t: float) -> float | None:
    """Return the middle of the longest part of a period ``length`` along x without ``bodies`` at time ``t``, or None.

    0 where there are no bodies.
    """
    if not bodies:
        return 0.0
    radii = np.array([farthest(body.shape) for body in bodies])
    first = (np.array([body.at(t).centre[0] for body in bodies]) - radii) % length
    order = np.argsort(first)
    first, last = first[order], np.maximum.accumulate((first + 2.0 * radii)[order])
    last = np.maximum(last, last[-1] - length)  # bodies across the end of the cell
    gaps = np.append(first[1:], first[0] + length) - last
    longest = int(np.argmax(gaps))
    return float(last[longest] + 0.5 * gaps[longest]) if gaps[longest] > 0.0 else None


Kind = TypeVar("Kind", bound="BodyScene")

LEAST_JITTER = 0.05
"""Least random displacement of the particles far from walls, in spacings. The flow would stretch a perfect lattice, or
tear it along the diagonals, because repulsive displacements cancel there."""


ABSENT = 1e3
"""Distance, in lengths of the cell, at which a body is ``seen`` that is not in the fluid."""


class BodyScene(Scene):
    """A scene with ``bodies``: fluid around them, and within them where the box is not ``periodic``.

    Scenes with free bodies have ``bodies`` as a field.
    """

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields of a fluid at rest without stress."""
        return {name: np.zeros(np.shape(x)) for name in ("u", "v", *(STRESSES if self.polymer else ()))}

    @cached_property
    def region(self) -> Region:
        """The fluid's region at t = 0."""
        bodies = tuple(body for body in self.bodies if body.enters <= self.start_time)
        return Region(bodies, self.origin, tuple(np.add(self.origin, self.extent)), self.periodic)

    @cached_property
    def particles(self) -> int:
        """Number of fluid particles at the start."""
        return number_of_particles(self.region, self.wanted_spacing, self.start_time)

    @property
    def fluid_area(self) -> float:
        """Area of the fluid."""
        return self.region.area

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return x, y (particles,) of particles that fill the region; see ``tisph/geometry/packing.py``."""
        jitter = max(jitter, LEAST_JITTER)
        x, y = pack(self.region, self.wanted_spacing, jitter, seed, self.particles, self.start_time).T
        return x, y

    def seen(self: Kind, snapshot: Snapshot) -> Kind:
        """See ``Scene.seen``; bodies that are not in the fluid are far away."""
        if not self.has_free_bodies:
            return self
        bodies, found = list(self.bodies), bodies_in(snapshot)
        for index, body in enumerate(self.bodies):
            if body.free and np.isnan(found.angle[index]):
                far = ABSENT * (1 + index) * self.extent[0]
                bodies[index] = replace(body, centre=(far, 0.0), motion=REST, enters=math.inf)
            elif body.free:
                velocity, rotation = found.velocity[index], float(found.angular_velocity[index])
                motion = RigidMotion(*(WallMotion(float(part)) for part in (*velocity, rotation)))
                centre = tuple((found.centre[index] - snapshot.t * velocity).tolist())
                angle = float(found.angle[index]) - snapshot.t * rotation
                bodies[index] = replace(body, centre=centre, angle=angle, motion=motion, enters=-math.inf)
        now = dict(zip(map(id, self.bodies), bodies, strict=True))
        sources = [each.placed(lambda body: now.get(id(body), body)) for each in self.spacing_sources]
        changed: Any = {"bodies": tuple(bodies), "spacing_sources": tuple(sources)}
        scene = replace(self, **changed)
        vars(scene)["region"] = self.region  # only its area is needed, which stays
        return scene
