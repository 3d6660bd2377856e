"""The implicit scheme of two-dimensional flows: pressure, motion and viscosity of third order in a periodic box.

The problem that the scheme solves is a box, a fluid, scales, and the walls in it.
"""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tisph.config.schema import Config
from tisph.scenes._scene import Scene
from tisph.schemes._protocol import SampleEstimate, Scheme, SchemeEstimates
from tisph.schemes._step_control import LARGEST_MULTISTEP_FACTOR, SAFETY
from tisph.schemes.implicit.planar.problem import problem_of
from tisph.schemes.implicit.planar.step_limits import (
    SMALLEST_SCALE,
    TOLERANCE,
    courant_speed,
    first_step,
    is_slow,
    viscous_step,
)

COST, OVERHEAD = 3.5e-6, 2e-3
"""Rough cost of one particle and step on two threads, and of a step whatever the number of particles [s]."""

BETWEEN_WALLS = 2.2
"""Factor of the cost of a particle between walls: supports are wider, and the pressure is solved for twice a step. In
slow flow and in quick start-up it was 2.9, in developed flow 1.6."""

NOT_NEWTONIAN = 1.7
"""Factor of the cost of a particle with a polymer, or with a viscosity that varies."""

FREE = 1.6
"""Factor of the cost of a particle with bodies that the flow carries."""

TOGETHER = 4.0
"""Factor of the cost of a particle in slow flow, where velocity and pressure are solved for together."""

STARTING = 1.7
"""Time scale of a flow that starts from rest, over the time since its start: its layers grow with the square root of
the time. Starts of 20 runs took as many steps as with 1.0 to 2.4."""

IN_PASSAGES = 1.5
"""Largest velocity over the mean velocity of a passage, as between plane walls: around a cylinder it was 1.5 to 1.7."""

IN_PIPES = 2.0
"""The same in a pipe with open ends."""

PLACES, ANGLES, NEAREST = 100, 24, 1e-6
"""Places around a body at which the velocity of the flow is estimated, and angles to which it turns; least distance of
these places from walls in spacings."""

FACTORS = 0.5, 2.0
"""Steps of a run over the estimated ones, least and most. Of 34 configs and 46 cells of the stability matrix they were
0.53 to 1.9, but 2.8 in ``segre_silberberg`` and 4.0 in ``contraction``: ``benchmarks/estimates.py``."""

JUDGED_BY = "divergence", "steepest stress"
"""Numbers of a run that decide whether a sample is resolved (``measures/resolution.py``); the second with polymer."""


def build(config: Config, scene: Scene, targets: Sequence[float], serial: bool) -> Scheme:
    """Return the ``PlanarScheme`` of a scene."""
    from tisph.schemes.implicit.planar.scheme import PlanarScheme  # imports Taichi

    ratio = None if scene.substances else config.scheme.error_ratio  # the divergence shows no error of a temperature
    return PlanarScheme(problem_of(scene), targets, serial, *_steps(config), ratio)


def _steps(config: Config) -> tuple[float | None, float]:
    """Tolerance of a step, None where the Courant number alone sets it, and the largest Courant number."""
    if config.time.cfl != "auto":
        return None, config.time.cfl
    if config.singular:
        return None, config.scheme.largest_courant
    tolerance = TOLERANCE if config.time.tolerance == "auto" else config.time.tolerance
    return tolerance, config.scheme.largest_courant


def estimates(config: Config, scene: Scene) -> SchemeEstimates:
    """Return the estimates of a run for ``tisph check``: steps from its scales; none of errors."""
    tolerance, courant = _steps(config)
    slow = is_slow(scene, courant)
    limits = {"cfl": courant * _passing_time(scene, courant_speed(0.0, scene))}
    if not slow:
        limits["viscous"] = viscous_step(scene)
    binding = min(limits, key=lambda name: limits[name])
    counts = _guessed_steps(scene, [*config.time.samples, config.time.end], tolerance, courant)
    known = "u" in scene.fields
    cost = COST * (BETWEEN_WALLS if scene.bodies else 1.0) * (NOT_NEWTONIAN if scene.rheology else 1.0)
    cost *= TOGETHER if slow else FREE if scene.has_free_bodies else 1.0
    judged_by = JUDGED_BY if scene.polymer else JUDGED_BY[:1]
    sample = SampleEstimate(0.0, 0, steps_reliable=known, steps_factors=FACTORS, judged_by=judged_by)
    return {
        "mach": 0.0,
        "sound_speed": None,
        "time_step": limits[binding],
        "binding_limit": binding,
        "steps": counts[-1],
        "run_time": counts[-1] * (OVERHEAD + scene.particles * cost),
        "lost": False,
        "samples": [replace(sample, t=t, steps=n) for t, n in zip(config.time.samples, counts, strict=False)],
    }


def _passing_time(scene: Scene, speed: float) -> float:
    """Return the time in which the fluid that is fastest, for the spacing of its place, moves by that spacing.

    It has at most this ``speed``. Free bodies among walls that alone drive the flow move with it. Its velocity there is
    the mean of the velocities of the walls over their distances: exact between two walls. A body turns: of its angles
    the rates are the mean.
    """
    wanted = scene.wanted_spacing
    walls = [body for body in scene.bodies if not body.free]
    motions: list[Any] = [body.motion for body in scene.bodies if body.free]
    loads = [motion.inertia.load for motion in motions]
    pushed = scene.acceleration or scene.kept_mean_velocity or scene.flows_through or np.any(loads)
    if not (wanted.varies and walls and loads) or pushed:
        return wanted.smallest / speed
    fastest, at = speed / scene.spacing, [wall.at(scene.start_time) for wall in walls]
    turns = np.exp(2j * np.pi * np.arange(ANGLES) / ANGLES)
    for body in scene.bodies:
        outline = body.boundary_points(body.shape.length / PLACES).point
        rates, away, spacing = [], outline - body.centre, wanted.at(outline)
        for turn in turns if body.free else turns[:1]:
            places = body.centre + away @ np.array([[turn.real, turn.imag], [-turn.imag, turn.real]])
            feet = [wall.nearest(places) for wall in at]
            nearness = np.stack([1.0 / np.maximum(foot.distance, NEAREST * scene.spacing) for foot in feet])
            velocities = np.stack([wall.velocity(foot.point) for wall, foot in zip(at, feet, strict=True)])
            flow = np.einsum("wn,wnc->nc", nearness / nearness.sum(axis=0), velocities)
            rates.append((np.hypot(*flow.T) / spacing).max())
        fastest = max(fastest, float(np.mean(rates)))
    return 1.0 / fastest


def _guessed_steps(scene: Scene, ends: Sequence[float], tolerance: float | None, courant: float) -> list[int]:
    """Return the steps up to each of the times ``ends``.

    With a ``tolerance`` e the backward differences allow steps of 0.9 (22 e / 3)^(1/4) times the time scale of the flow
    as a particle sees it (``TimeWeights.step_error``). It is 1 / frequency of a drive, L / (2 pi U) in vortices of size
    L in a box that holds nothing else, and ``STARTING`` times the time since a start. Velocities around the
    axis move no particle.
    """
    turns = scene.axisymmetric and not (scene.acceleration or scene.kept_mean_velocity or scene.has_free_bodies)
    open_ended = scene.flows_through
    turns = turns and not (open_ended or any(body.motion.x.largest_speed for body in scene.bodies))
    filled = "u" in scene.fields or open_ended or any(body.in_fluid for body in scene.bodies)
    vortices = not scene.bodies or (not filled and (turns or not any(scene.periodic)))
    speed = courant_speed(0.0 if turns else scene.reference_velocity, scene)
    peak = IN_PIPES if open_ended and scene.axisymmetric else IN_PASSAGES
    allowed = courant * _passing_time(scene, speed * (peak if scene.kept_mean_velocity or open_ended else 1.0))
    if not is_slow(scene, courant):
        allowed = min(allowed, viscous_step(scene))
    first, growth = first_step(allowed, scene), LARGEST_MULTISTEP_FACTOR
    accurate = SAFETY * (22 / 3 * tolerance) ** 0.25 if tolerance else np.inf
    if tolerance:
        frequency = scene.time_series().angular_frequency
        if vortices:
            around = 0.5 * speed if turns else speed  # Taylor vortices have about a twentieth of the wall's velocity
            frequency = max(frequency, 2.0 * np.pi * around / scene.reference_length)
        allowed = min(allowed, accurate / frequency) if frequency else allowed
        starts = scene.inertia and scene.bodies and np.isfinite(scene.thinnest_layer(scene.start_time)[0])
        growth = min(growth, 1.0 + accurate * STARTING) if starts else growth
    grown = allowed / (growth - 1.0)  # time at which steps that are a part of it are as long as allowed
    decay = 0.0 if scene.bodies else 2.0 * scene.kinematic_viscosity * (2.0 * np.pi / scene.reference_length) ** 2
    longest = courant * _passing_time(scene, courant_speed(0.0, scene))
    fading = np.log(longest / allowed) / decay if decay else np.inf  # time in which the steps of slower vortices grow
    decayed = -np.log(SMALLEST_SCALE)  # decay x time from which on errors refer to a constant velocity

    def steps(time: float) -> float:
        """Return the number of steps in the ``time`` after a start."""
        later = max(time - grown, 0.0)
        before = min(later, fading)
        count = (-np.expm1(-decay * before) / decay if decay else before) / allowed + (later - before) / longest
        count += min(decay * later, decayed) / accurate
        return np.log(max(min(time, grown) / first, growth)) / np.log(growth) + count

    begins = [[scene.start_time, *(change for change in scene.jump_times if change < end)] for end in ends]
    return [
        max(1, round(sum(steps(after - before) for before, after in itertools.pairwise([*begin, end]))))
        for begin, end in zip(begins, ends, strict=True)
    ]
