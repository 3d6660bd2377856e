"""Channel flow: between planes y = 0 and y = gap, periodic in x, driven by the walls and by an acceleration.

The walls are the planes y = 0 and y = gap; fluid particles start at cell centres, (i + 1/2) spacing. Motion
starts, or changes, at t = 0. The run's clock starts at ``start_time``: at the initial time of the config for the
state ``exact``, else at 0.

This file has the config; the flow is in ``_channel``. With ``bodies`` the flow is not parallel and has no exact
solution: the scene then is a cell between two walls (``_cell``). Runs without bodies do not import it.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from tisph.bodies._files import FromFile, OfOutline
from tisph.config import schema
from tisph.config.base import Model, NonNegative, Positive, Problem, Signed, Whole, findings, refusals, refuse
from tisph.config.ends import Ends
from tisph.config.fields import Bodies, Member, number_or
from tisph.config.motion import (
    Amplitude,
    SlipLength,
    Spacing,
    Times,
    Values,
    WallMotion,
    check_as_many,
    check_schedule,
    frictionless_findings,
)
from tisph.scenes._channel import SIDES, Channel
from tisph.scenes._initial import Contact, Initial, PulsatingDrive, start_problems, still_problem

__all__ = ["Channel", "Config", "Scene"]

WallTreatment = Member("walls", usual="consistent_image")

STRESS_KEYS = ("shear_stress", "stress_amplitude", "stresses")
"""Keys of a wall that make it stress-controlled."""

OUTLINE_KEYS = ("outline", "corner_radius", "smooth")
"""Keys of a wall that is no plane."""

PLACES = 1000
"""Points on each wall from which the distance between a wall with an outline and the other one is computed."""

OVERSHOOT = 1e-3
"""Part of the height by which a smooth curve may leave the box between its places."""

Place = Annotated[tuple[Signed, Signed], Field(strict=False)]


class Geometry(Model):
    """Distance between the walls and period along them [length]."""

    gap: Positive
    length: Positive


class Wall(FromFile, WallMotion):
    """Velocity of a wall along x from t = 0 on, of either sign: constant, or oscillating; or the stress that drives it.

    ``velocity`` [length/time], and ``velocity_before`` for another velocity before t = 0; or ``amplitude``
    [length/time] * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t; or ``velocities`` at ``times``, linear
    in between and constant before and after, with a jump where two times are equal.

    Or a plate that starts from rest, of ``mass_per_area`` [mass/length^2] (default 0), under an external shear stress
    along x [mass/(length time^2)]: constant, ``shear_stress``; ``stress_amplitude`` with ``angular_frequency`` and
    ``phase``; or ``stresses``, each from one of the ``times`` on.

    Or a wall at rest that is no plane: its ``outline`` is a polyline through places [x, y] from x = 0 to x = length,
    with corners rounded by arcs of ``corner_radius`` [length], or a ``smooth`` curve through them. Its places may come
    from a ``file`` with an open path.

    The fluid at the wall is faster than the wall by ``slip_length`` [length] * shear stress / dynamic viscosity;
    ``infinite``: no shear stress, as on a flat free surface or a plane of symmetry. ``spacing``: see
    ``config/motion.Spacing``.
    """

    speed_key = "velocity"
    other_keys = (*STRESS_KEYS, "velocities")
    exclusive_keys = ("velocity", "amplitude", *STRESS_KEYS, "velocities")
    unset_keys = (
        "velocity_before",
        "angular_frequency",
        "phase",
        "times",
        "mass_per_area",
        "slip_length",
        "spacing",
        *OUTLINE_KEYS,
        "file",
    )
    points_key, encloses, smooth_words = "outline", False, "smooth: true"

    velocity: Signed | None = None
    velocity_before: Signed | None = None
    amplitude: Amplitude | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None
    shear_stress: Signed | None = None
    stress_amplitude: Amplitude | None = None
    times: Times | None = None
    stresses: Values | None = None
    velocities: Values | None = None
    mass_per_area: NonNegative | None = None
    outline: Annotated[tuple[Place, ...], Field(strict=False, min_length=2, max_length=1000)] | None = None
    corner_radius: Positive | None = None
    smooth: bool | None = None
    file: OfOutline | None = None
    slip_length: SlipLength | None = None
    spacing: Spacing = None

    @property
    def shaped_by(self) -> str:
        """Key of ``BULGES`` in ``bodies/_clearance``."""
        return "outline" if self.smooth else "corners"

    @property
    def stress_controlled(self) -> bool:
        """Whether the config gives a stress."""
        return any(getattr(self, key) is not None for key in STRESS_KEYS)

    @model_validator(mode="before")
    @classmethod
    def _fill_in_phase(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("stress_amplitude") is not None and data.get("phase") is None:
            return {**data, "phase": "cos"}
        return data

    @model_validator(mode="after")
    def _check_what_is_given(self) -> "Wall":
        found = [(key, text) for key, text in _alien_keys(self) if getattr(self, key) is not None]
        if self.stress_amplitude is not None and self.angular_frequency is None:
            raise refusals([(("angular_frequency",), "is missing: a stress with an amplitude oscillates", {})])
        for key in ("stresses", "velocities"):
            check_as_many(self, key)
        if self.velocities is not None:
            check_schedule(self, "velocities")
        elif self.times and any(late <= early for early, late in pairwise((-1e-300, *self.times))):
            raise refusals([(("times",), "must ascend from 0 on", self.times)])
        if found:
            raise refusals([((key,), text, getattr(self, key)) for key, text in found])
        refuse(frictionless_findings(self, ("velocity", "velocity_before", "amplitude", "velocities")))
        return self

    @model_validator(mode="after")
    def _check_outline(self) -> "Wall":
        if self.outline is None:
            refuse(findings(self, OUTLINE_KEYS[1:], "is only for a wall with an outline"))
            return self
        moves = [key for key in self.exclusive_keys if getattr(self, key)]
        refuse(findings(self, (*moves, "velocity_before"), "is not for a wall with an outline: it is at rest"))
        if self.smooth:
            refuse(findings(self, ("corner_radius",), "is not for a smooth wall, which has no corners"))
        return self

    def shape(self, side: str, periodic: bool) -> Any:
        """Return the outline of the ``side`` bottom, below the fluid, or top; ValueError where it is impossible."""
        from tisph.geometry.outline import Outline, SmoothOutline

        places = (self.outline or ())[:: 1 if side == "bottom" else -1]
        if self.smooth:
            return SmoothOutline(places, periodic=periodic)
        return Outline(places, self.corner_radius or 0.0, periodic=periodic)

    @classmethod
    def smooth_of(cls, data: Mapping[str, Any]) -> bool:
        """Return whether raw ``data`` are a smooth wall."""
        return bool(data.get("smooth"))

    @classmethod
    def shape_through(cls, points: np.ndarray, data: Mapping[str, Any], periodic: bool) -> Any:
        """Return the outline of a bottom wall through ``points``."""
        wall = cls.model_construct(outline=points.tolist(), **{key: data.get(key) for key in OUTLINE_KEYS[1:]})
        return wall.shape("bottom", periodic)


def _alien_keys(wall: Wall) -> Iterator[tuple[str, str]]:
    """Yield keys that do not belong to this kind of ``wall``, and the reason, whether they are given or not."""
    if wall.stresses is None and wall.velocities is None:
        yield "times", "is only for a wall with stresses, each from one of the times on, or with velocities"
    if wall.velocities is not None:
        yield "velocity_before", "is not for a wall with velocities at times: it starts from rest"
        yield "angular_frequency", "is only for a wall that oscillates, not for one with velocities at times"
        yield "phase", "is only for a wall that oscillates, not for one with velocities at times"
    if not wall.stress_controlled:
        yield "mass_per_area", "is only for a stress-controlled wall, with keys such as shear_stress"
        return
    yield "velocity_before", "is not for a stress-controlled wall: it starts from rest"
    yield "slip_length", "is not for a stress-controlled wall, whose stress is given"
    if wall.stress_amplitude is None:
        yield "angular_frequency", "is only for a wall that oscillates, which has an amplitude or stress_amplitude"
        yield "phase", "is only for a wall that oscillates, which has an amplitude or stress_amplitude"


class Walls(Model):
    """Wall treatment, and the walls at y = 0 (``bottom``) and y = gap (``top``)."""

    treatment: Annotated[Any, WallTreatment] = Field(default_factory=WallTreatment.default)
    bottom: Wall = Wall()
    top: Wall = Wall()


class Drive(PulsatingDrive):
    """Drive along x, see ``PulsatingDrive``; with bodies or open ends it is constant, with the ``gravity`` of bodies.

    A constant acceleration and gravity act on bodies as in ``_initial.Drive``.
    """

    unset_keys = ("gravity", *PulsatingDrive.unset_keys[1:])

    acceleration: Signed = 0.0
    gravity: Annotated[tuple[Signed, Signed], Field(strict=False)] | None = None


class Probes(Model):
    """Fixed points on a vertical line at ``x`` [length], whose velocities go to history.csv."""

    count: Annotated[Whole, Field(ge=2, le=1000)] = 10
    x: number_or(Annotated[float, Field(ge=0)], "centre") = "centre"


class Config(schema.Config):
    """A whole run in the channel."""

    geometry: Geometry
    walls: Walls = Walls()
    ends: Ends | None = None
    drive: Annotated[Drive, Field(default_factory=lambda: Drive.model_validate({}))]
    contact: Contact | None = None
    bodies: Bodies = ()
    initial: Initial = Initial()
    probes: Probes = Probes()

    unset_keys = (*schema.Config.unset_keys, "bodies", "contact", "ends")
    across_name = "the gap"

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether the box is periodic in x and y."""
        return self.ends is None, False

    @property
    def parallel(self) -> bool:
        """Whether all flow is along x, and nothing that the fluid carries varies along it."""
        carried = (*self.scalars, *([self.temperature] if self.temperature else []))
        return not (self.bodies or self.ends or self.outlined or any(each.varies_along for each in carried))

    @property
    def outlined(self) -> bool:
        """Whether a wall has an outline."""
        return any(getattr(self.walls, side).outline for side in SIDES)

    @property
    def flow(self) -> str:
        """See ``schema.Config.flow``."""
        if self.bodies:
            return f"{self.named_bodies} in a channel"
        if self.ends:
            return "Flow through a channel with open ends"
        if self.outlined:
            return "Flow between walls that are no planes"
        walls: Any = (self.walls.bottom, self.walls.top)
        if any(wall.stress_controlled for wall in walls):
            return "Plane shear under a given stress"
        if any(wall.amplitude is not None for wall in walls):
            return "Flow at an oscillating wall"
        moving = any(wall.velocity or wall.velocity_before or wall.velocities for wall in walls)
        driven = bool(self.drive.acceleration or self.drive.varies)
        return {(True, False): "Plane Couette flow", (False, True): "Plane Poiseuille flow"}.get(
            (moving, driven), "Plane Couette-Poiseuille flow" if moving else super().flow
        )

    @property
    def has_exact_velocity(self) -> bool:
        """Whether the exact velocity is known."""
        return self.parallel

    @property
    def singular(self) -> bool:
        """Whether the velocity of the inlet jumps at walls."""
        return self.ends is not None and self.ends.inlet is not None and self.ends.inlet.jumps_at_walls()

    @property
    def extent(self) -> tuple[float, float]:
        """Length and gap."""
        return self.geometry.length, self.geometry.gap

    @property
    def aspect(self) -> float:
        """Length over gap; 1 with open ends, when the spacing need not divide the length."""
        return 1.0 if self.ends else self.geometry.length / self.geometry.gap

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]: ``initial.time`` for state ``exact``, else 0."""
        return self.initial.time

    @property
    def members(self) -> dict[str, Any]:
        """Members of every scene, and without bodies the wall treatment, which is for plane walls only."""
        return {"walls": self.walls.treatment, **super().members} if self.parallel else super().members

    @property
    def time_series(self) -> dict[str, Any]:
        """Settings of the probes; none with bodies, where forces are recorded."""
        return {} if not self.parallel else {"count": self.probes.count, "x": self.probes.x}

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the channel finds in the config."""
        if not self.parallel:
            yield from _problems_with_bodies_or_ends(self)
            return
        if self.contact:
            yield "contact", "is for free bodies, and there are none: leave it out"
        if self.drive.gravity:
            yield "drive.gravity", "moves free bodies only, and there are none; drive.acceleration drives the fluid"
        yield from _driven(self)
        yield from _motion(self)
        yield from start_problems(self, SIDES)
        yield from self.drive.start_problems(self)
        rheology = self.fluid.rheology
        swinging = any(getattr(self.walls, side).amplitude is not None for side in SIDES)
        if not self.fluid.newtonian and swinging and self.initial.state == "developed":
            text = f"no periodic flow is built in for {rheology.type} fluids"
            yield "initial.state", f"{text}: take rest, or walls of constant velocity"
        if self.probes.x != "centre" and self.probes.x > self.geometry.length:
            yield "probes.x", f"must be inside the channel: centre, or 0 to {self.geometry.length:g}"

    def incommensurate(self) -> Iterator[Problem]:
        """Yield an error for a length that the spacing does not divide, or that is too short."""
        wrong = [] if self.ends else schema.incommensurate_columns(self)
        yield from wrong
        periodic_pairs = not self.parallel and (self.bodies or not self.ends)
        least = schema.LEAST_IN_PERIOD if periodic_pairs else schema.least_in_period(self)
        if not wrong and self.columns < least:
            text = f"must be at least {least * self.spacing:.6g}, {least} particle spacings"
            yield "geometry.length", f"{text}: the neighbour search needs three cells along x"


class Scene:
    """Maker of the scene of a run: the plane channel, or a cell if there are bodies."""

    @staticmethod
    def from_config(config: "Config") -> Any:
        """Return the scene that a validated config describes."""
        if config.parallel:
            return Channel.from_config(config)
        if config.ends:
            from tisph.scenes._stream import PressureStream, Stream

            return (Stream if config.ends.inlet else PressureStream).from_config(config)
        from tisph.scenes._cell import Cell, DevelopedFlow, bodies_of, planes, walls_along

        walls = walls_along(config)
        developed = DevelopedFlow.of(config) if config.initial.state == "developed" else None
        bodies = bodies_of(config, walls)
        return Cell.around(config, bodies, walls, walls=planes(walls), initial_velocity=developed)


def _motion(config: Config) -> Iterator[Problem]:
    """Yield an error if nothing moves."""
    walls = (config.walls.bottom, config.walls.top)
    driven = config.drive.acceleration or config.drive.varies
    if driven or any(wall.amplitude or wall.stress_controlled or wall.velocities for wall in walls):
        return
    velocities = {velocity for wall in walls for velocity in (wall.velocity, wall.velocity_before)} - {None}
    developed = config.initial.state == "developed" or any(wall.velocity_before is not None for wall in walls)
    if len(velocities | (set() if developed else {0.0})) == 1:
        remedy = "give walls.bottom or walls.top a velocity other than 0, or drive.acceleration"
        together = f"{remedy}; walls and fluid move together at {walls[0].velocity:g}"
        yield from still_problem(config, "walls", together if walls[0].velocity else remedy)


def _driven(config: Config) -> Iterator[Problem]:
    """Yield errors of stress-controlled walls, of slip, and of walls with velocities at times."""
    sides, scheduled, slipping = (
        [side for side in SIDES if getattr(getattr(config.walls, side), key)]
        for key in ("stress_controlled", "velocities", "slip_length")
    )
    loose = sides + [side for side in slipping if getattr(config.walls, side).slip_length == "infinite"]
    if len(sides) > 1:
        yield "walls.top", "must have a velocity if the bottom wall is stress-controlled: nothing else holds the fluid"
    elif len(loose) > 1:
        text = "must be finite: the other wall has no friction, or a given stress, and nothing else holds the fluid"
        yield f"walls.{loose[-1]}.slip_length", text
    for which, text in ((sides, "a wall is stress-controlled"), (scheduled, "a wall has velocities at times")):
        if which and config.initial.state != "rest":
            yield "initial.state", f"must be rest where {text} (walls.{which[0]})"
    for which, text in ((sides, "a wall is stress-controlled"), (slipping, "the fluid slips")):
        if which and not config.walls.treatment.obeys_momentum:
            text = f"must be consistent_image where {text} (walls.{which[0]})"
            yield "walls.treatment.type", f"{text}: only its images take a stress"


def _problems_with_bodies_or_ends(config: Config) -> Iterator[Problem]:
    """Yield the errors in the config of a channel with bodies, or with open ends."""
    from tisph.geometry.body import Body
    from tisph.scenes._cell import bodies_of, cell_problems, walls_along

    if config.drive.varies:
        yield f"drive.{config.drive.varies}", "must be left out: with bodies, outlines or open ends a drive is constant"
        return
    sides = {side: getattr(config.walls, side) for side in SIDES}
    where = "with bodies in the channel" if config.bodies else "with a wall that is no plane"
    able = "a Newtonian fluid and steady walls make it developed"
    if config.ends:
        where, able = "with open ends", "a fluid without polymer makes it developed"
        if errors := list(_problems_with_ends(config)):
            yield from errors
            return
    for side, wall in sides.items():
        if wall.stress_controlled:
            yield f"walls.{side}", f"must have a velocity: {where} no stress can drive a wall"
            return
    for side, wall in sides.items():
        if wall.slip_length and config.initial.state == "developed":
            yield "initial.state", f"must be rest {where} if the fluid slips along a wall (walls.{side})"
        if wall.velocities:
            yield f"walls.{side}.velocities", f"must be left out {where}: give velocity, or an amplitude"
            return
    moving = any(wall.amplitude for wall in sides.values())
    unknown = config.fluid.polymer if config.ends else not config.fluid.newtonian
    if config.initial.state != "rest" and (moving or unknown):
        yield "initial.state", f"must be rest {where}, unless {able}"
    elif config.initial.state == "exact":
        yield "initial.state", f"must be rest or developed: {where} no exact flow is known"
    if config.initial.time:
        yield "initial.time", f"must be 0: {where} the run starts at 0"
    for side, wall in sides.items():
        if wall.speed_before is not None:
            yield f"walls.{side}.velocity_before", f"is not allowed {where}: the run starts from rest"
    if config.walls.treatment != WallTreatment.default():
        yield "walls.treatment.type", f"must be left out: {where} walls have boundary points and no images"
    if config.probes != type(config.probes)():
        yield "probes", f"must be left out: {where} forces are recorded, and no velocities at probes"
    if errors := list(outlined_wall_problems(config)):
        yield from errors
        return
    named = {f"walls.{name}": wall for name, wall in walls_along(config).items()}
    if config.ends:
        from tisph.scenes._ends import end_lines

        named |= {f"ends.{side}": Body(line) for side, line in end_lines(config).items()}
    yield from cell_problems(config, bodies_of(config, named), named)


def outlined_wall_problems(config: schema.Config) -> Iterator[Problem]:
    """Yield the errors of walls with outlines."""
    from tisph.bodies._clearance import size_problems
    from tisph.scenes._cell import walls_along
    from tisph.scenes._spacing import wanted_spacing

    given = {side: wall for side in SIDES if (wall := getattr(config.walls, side)) and wall.outline}
    if not given:
        return
    if config.scheme.type == "wcsph":
        yield "scheme.type", "wcsph has no treatment of walls with outlines; take auto or implicit"
        return
    length, height = config.extent
    low = config.geometry.inner_radius if config.axisymmetric else 0.0
    if getattr(config.initial, "state", "rest") == "developed":
        yield "initial.state", "must be rest where a wall has an outline: no developed flow is known there"
    for side, wall in given.items():
        first, last = wall.outline[0][0], wall.outline[-1][0]
        if (first, last) != (0.0, length):
            yield f"walls.{side}.outline", f"must lead from x = 0 to x = {length:g}, not from {first:g} to {last:g}"
            return
        try:
            extent = wall.shape(side, config.periodic[0]).extent[:, 1] - low
        except ValueError as error:
            yield f"walls.{side}.outline", str(error)
            return
        if not -OVERSHOOT * height <= extent[0] <= extent[1] <= (1.0 + OVERSHOOT) * height:
            text = f"must be within the box: y from {low:g} to {low + height:g}"
            yield f"walls.{side}.outline", f"{text}, not from {extent[0] + low:.6g} to {extent[1] + low:.6g}"
    walls = walls_along(config)
    sized = [(f"walls.{side}", wall, walls[side]) for side, wall in given.items() if side in walls]
    wanted = wanted_spacing(config, {f"walls.{side}": wall for side, wall in walls.items()})
    yield from size_problems(sized, wanted, config.across)
    least = schema.LEAST_PARTICLES_ACROSS * max(map(wanted.along, walls.values()))
    points = {side: wall.boundary_points(wall.shape.length / PLACES).point for side, wall in walls.items()}
    other = [walls[one].nearest(points[two]).distance for one, two in (SIDES, SIDES[::-1])] if len(walls) > 1 else []
    narrowest = min(float(distance.min()) for distance in other or [points["top"][:, 1]])
    if narrowest < least * (1.0 - 1e-3):
        text = f"leaves a passage {narrowest:.4g} wide" if narrowest > 0.0 else "meets the other wall"
        text = f"{text}: leave {schema.LEAST_PARTICLES_ACROSS} spacings, {least:.4g}"
        yield f"walls.{next(iter(given))}.outline", text


def _problems_with_ends(config: Config) -> Iterator[Problem]:
    """Yield the errors in the config of a channel with open ends."""
    from tisph.scenes._ends import end_problems

    for side in SIDES:
        wall = getattr(config.walls, side)
        if wall.velocity or wall.amplitude or wall.velocities or wall.stress_controlled:
            yield f"walls.{side}", "must be at rest: with open ends no wall moves yet"
    yield from end_problems(config)
