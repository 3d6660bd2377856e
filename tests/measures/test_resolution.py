"""Whether a sample is resolved: the depth of the layers of every kind of flow, by hand, against the spacing."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from polymer_laws import oldroyd_b
from report_scene import make_channel, make_snapshot

from tisph import scenes
from tisph.config import load
from tisph.config.loader import loaded
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import WallMotion
from tisph.measures.metrics import sample_metrics
from tisph.measures.resolution import LEAST_DEPTH, load_scatters, resolution
from tisph.report.labels import error_label
from tisph.snapshot import Bodies, Snapshot

CONFIGS = Path(__file__).parents[2] / "configs"
NU = 1e-6  # of make_channel, with a spacing of 1e-3
AT_REST = WallMotion(0.0)
SWINGING = WallMotion(0.0, 0.005, angular_frequency=2.0)


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({}, "the layer at the top wall"),
        ({"bottom": WallMotion(0.001)}, "the layer at each wall"),
        ({"bottom": WallMotion(0.001), "top": AT_REST}, "the layer at the bottom wall"),
        ({"top": AT_REST, "acceleration": 1e-4}, "the layer at each wall"),
        ({"top": WallMotion(0.0, before=0.005), "initial_state": "developed"}, "the layer at the top wall"),
        ({"initial_state": "exact", "start_time": 0.1}, "the layer at the top wall"),
    ],
)
def test_what_starts_diffuses_into_the_fluid(changes, place):
    channel = make_channel(**changes)
    assert channel.thinnest_layer(0.25) == (pytest.approx(5e-4, rel=1e-15), place)  # sqrt(1e-6 * 0.25)
    assert channel.thinnest_layer(0.0)[0] == 0.0


@pytest.mark.parametrize("changes", [{}, {"top": AT_REST, "acceleration": 1e-4}, {"top": WallMotion(0.1, before=0.1)}])
def test_a_flow_that_goes_on_has_no_layer(changes):
    channel = make_channel(initial_state="developed", **changes)
    assert channel.thinnest_layer(0.0) == (math.inf, "")
    assert resolution(channel, 0.0) == (True, None)


def test_an_oscillating_wall_moves_a_layer_that_grows_no_more():
    place = "the layer at the oscillating top wall"
    started = make_channel(top=SWINGING)
    assert started.thinnest_layer(0.16) == (pytest.approx(4e-4, rel=1e-15), "the layer at the top wall")
    for channel in (started, make_channel(top=SWINGING, initial_state="developed")):
        assert channel.thinnest_layer(100.0) == (pytest.approx(5e-4, rel=1e-15), place)  # sqrt(1e-6 / (2 * 2))
        assert resolution(channel, 100.0) == (False, f"{place} is 0.5 spacings thin; resolved from 2 spacings on")


def test_only_the_solvent_smooths_the_front_of_a_shear_wave():
    channel = make_channel(**oldroyd_b(2.0, 0.25))
    early, place = channel.thinnest_layer(1e-4)
    assert (early, place) == (pytest.approx(math.sqrt(0.25 * NU * 1e-4), rel=1e-14), "the layer at the top wall")
    # waves at sqrt(0.75e-6 / 2) = 6.1e-4: at t = 4 past sqrt(nu t / 4) = 1e-3; exp(-4/4) of the front is left
    assert channel.thinnest_layer(4.0) == (pytest.approx(1e-3, rel=1e-14), "the front of the shear wave")
    # exp(-16.7/4) = 0.0154, exp(-16.9/4) = 0.0146, and it is faint at 0.015
    assert channel.thinnest_layer(16.7)[1] == "the front of the shear wave"
    assert channel.thinnest_layer(16.9) == (pytest.approx(math.sqrt(NU * 16.9), rel=1e-14), "the layer at the top wall")


def test_a_layer_is_resolved_from_a_number_of_spacings_on():
    channel = make_channel()
    enough = (LEAST_DEPTH * channel.spacing) ** 2 / NU
    assert resolution(channel, enough * (1 + 1e-12)) == (True, None)
    resolved, reason = resolution(channel, 0.25 * enough)
    assert (resolved, reason) == (False, "the layer at the top wall is 1 spacings thin; resolved from 2 spacings on")
    assert resolution(replace(channel, spacing=0.5 * channel.spacing), 0.25 * enough * (1 + 1e-12)) == (True, None)


def test_without_inertia_nothing_diffuses_into_the_fluid():
    """Slow flow past bodies is all there from the start, however short the time since then."""
    lattice = {
        "scene": "lattice", "fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False},
        "geometry": {"length": 1.0, "height": 1.0}, "drive": {"acceleration": 1.0}, "time": {"end": 1e-4},
        "bodies": [{"type": "circle", "centre": [0.5, 0.5], "radius": 0.2}],
    }  # fmt: skip
    slow = scenes.of(loaded(lattice, {}))
    assert resolution(slow, 1e-4) == (True, None)
    assert resolution(replace(slow, inertia=True), 1e-4)[0] is False


def test_samples_and_pictures_say_so():
    channel = make_channel(rows=20)
    early, late = (make_snapshot(channel, t) for t in (1e-2, 20.0))
    tracers = channel.probe_positions(3)
    states = [sample_metrics(channel, snapshot, tracers) for snapshot in (early, late)]
    assert [(state["resolved"], state["reason"]) for state in states] == [
        (False, "the layer at the top wall is 0.2 spacings thin; resolved from 2 spacings on"),
        (True, None),
    ]
    assert error_label(channel)(early) == "unresolved: layer of 0.2 spacings"
    assert error_label(channel)(late).startswith("L2 error")
    assert error_label(channel)(make_snapshot(channel, 0.0)) == "unresolved: layer that starts"


@pytest.mark.parametrize(
    ("field", "resolved", "not_resolved", "text"),
    [
        (
            *("steepest", (2.0, 0.1, 0.2), (3.0, 0.1, 0.2)),
            "the polymer's stretch changes 20-fold within a spacing at (0.1, 0.2); resolved up to 7.4-fold",
        ),
        (
            *("added_power", 0.01, 0.025),
            "where the viscosity jumps, errors of the viscous force have a power of 0.025 of the dissipation; "
            "resolved up to 0.01",
        ),
        (
            *("load_scatter", (0.01, 0), (0.033, 0)),
            "the force on the body at (0.1, 0.2) scatters from step to step by 0.033 of its size; resolved up to 0.01",
        ),
    ],
)
def test_what_the_steps_have_seen_is_not_resolved(field, resolved, not_resolved, text):
    channel = make_channel(initial_state="developed")
    vars(channel)["bodies"] = (Body(Circle(0.1)),)
    bodies = Bodies(*(np.array([[0.1, 0.2]]) for _ in range(8)))
    snapshot = make_snapshot(channel, 0.0)
    seen = replace(snapshot, **{field: not_resolved})
    assert resolution(channel, 0.0, replace(snapshot, bodies=bodies, **{field: resolved})) == (True, None)
    assert resolution(channel, 0.0, replace(seen, bodies=bodies)) == (False, text)
    assert field == "load_scatter" or sample_metrics(channel, seen, channel.probe_positions(3))["reason"] == text


FORCES = {"drag": (5.58, 0.003), "lift": (0.0106, 0.004), "torque": (0.0, 0.0)}
"""Coefficients of drag and lift of ``cylinder_refined`` at t = 4, and their scatter."""


def seen_by(scene, **loads):
    """A sample of a scene with one body whose ``loads`` have these means and this scatter, which is all there is."""
    mean, scatter = np.array(list((FORCES | loads).values())).T
    others = np.full((len(scene.bodies) - 1, 3), np.nan)
    bodies = Bodies.at(4.0, scene.bodies, np.broadcast_to([*mean, 0.0], (2, len(scene.bodies), 4)))
    found = replace(
        bodies, load_scatter=np.vstack([scatter, others]), load_size=np.vstack([np.hypot(mean, scatter), others])
    )
    whole = float(np.hypot(*scatter[:2])) / 5.58, 0
    return Snapshot(4.0, 99, *np.empty((6, 0)), bodies=found, load_scatter=whole)


@pytest.fixture(scope="module")
def stream():
    return scenes.of(load(CONFIGS / "cylinder_in_stream.yaml"))


def test_a_lift_that_scatters_is_not_resolved_beside_a_smooth_drag(stream):
    """The scatter is 0.1 % of the whole force."""
    reason = "lift scatters from step to step by 0.35 of itself; resolved up to 0.01"
    assert resolution(stream, 4.0, seen_by(stream)) == (False, reason)
    both = seen_by(stream, torque=(0.01, 2e-4))
    assert "of itself, torque by 0.02; resolved" in resolution(stream, 4.0, both)[1]
    assert error_label(stream)(both) == "unresolved: lift scatters by 0.35"
    assert resolution(stream, 4.0, seen_by(stream, lift=(1.0, 0.004))) == (True, None)


@pytest.mark.parametrize(
    "lift",
    [
        pytest.param((0.002, 0.004), id="mean below scatter"),
        pytest.param((5e-3, 1e-4), id="size below a thousandth of the drag"),
    ],
)
def test_a_lift_of_0_by_symmetry_leaves_a_sample_resolved(stream, lift):
    symmetric = seen_by(stream, lift=lift)
    assert resolution(stream, 4.0, symmetric) == (True, None)
    found = load_scatters(stream, symmetric)
    assert found == {"drag_scatter": 0.003, "lift_scatter": lift[1], "torque_scatter": 0.0, "zero_within_error": "lift"}


def test_a_load_that_grows_is_judged_by_its_value_as_well(stream):
    """Its root mean square over the last steps is far smaller than its value."""
    growing = seen_by(stream, lift=(1.0, 0.008))
    growing.bodies.load_size[0, 1] = 0.1
    assert resolution(stream, 4.0, growing) == (True, None)


def test_a_zero_that_scatters_beside_the_whole_force_is_not_resolved(stream):
    resolved, reason = resolution(stream, 4.0, seen_by(stream, lift=(0.0, 0.06)))
    assert not resolved
    assert reason.startswith("the force on the body at (0.2, 0.2) scatters")


def test_loads_that_are_judged_have_the_names_of_their_numbers():
    named = {
        name: scenes.of(load(CONFIGS / f"{name}.yaml")).named_loads for name in ("turned_box", "eccentric_annulus")
    }
    assert named["turned_box"]["lift_around"] == (1, 1)
    assert named["eccentric_annulus"] == {
        "torque_inner": (0, 2), "torque_outer": (1, 2), "force_x": (0, 0), "force_y": (0, 1)
    }  # fmt: skip
    assert scenes.of(load(CONFIGS / "sphere_in_stream.yaml")).named_loads == {
        "force_body_0": (0, 0),
        "torque_body_0": (0, 2),
    }
    assert not scenes.of(load(CONFIGS / "free_cylinder.yaml")).named_loads


def pipe(rheology, across, **sections):
    """A pipe of a fluid of viscosity 1."""
    fluid = {"density": 1.0, "kinematic_viscosity": 1.0, "rheology": rheology}
    fixed = {"scene": "pipe", "fluid": fluid, "discretisation": {"particles_across": across}, "time": {"end": 1.0}}
    return scenes.of(loaded({**fixed, **sections}, {}))


THINNING = {"type": "power_law", "index": 0.5, "reference_rate": 1.0, "least_rate": 0.01}
TURNS = {"angular_velocity": 4.0}


@pytest.mark.parametrize(
    ("rheology", "wall", "spacings", "resolved"),
    [
        ({"type": "newtonian"}, TURNS, 3, True),
        ({"type": "newtonian"}, TURNS, 2.5, False),
        (THINNING, TURNS, 6, True),
        (THINNING, TURNS, 4, False),
        (THINNING, {"velocity": 4.0}, 4, True),
    ],
)
def test_radius_of_an_inner_wall_is_three_spacings(rheology, wall, spacings, resolved):
    """As of any wall that bulges; times the index where it turns, since the shear rate is r^(-2/n) there."""
    sections = {"geometry": {"inner_radius": 0.25, "radius": 1.25, "length": 2.5}, "walls": {"inner": wall}}
    found, reason = resolution(pipe(rheology, 4 * spacings, **sections), 1.0)
    assert found == resolved
    assert resolved or reason.startswith("the radius of the inner wall")


@pytest.mark.parametrize(
    ("rheology", "share"),
    [
        ({"type": "newtonian"}, 1.0),
        # d^2 = t/2 sqrt(d), since the stress sqrt(1/d) of the rate 1/d has the slope sqrt(d)/2
        ({**THINNING, "least_rate": 1e-6}, 0.5 * 0.02 ** (1 / 3)),
        ({"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.1}, 0.1),
    ],
)
def test_layer_of_a_pipe_depends_on_the_fluid(rheology, share):
    """A wall of speed 1 starts in a fluid of viscosity 1; ``share``: of it that carries motion away by t = 0.04."""
    sections = {"geometry": {"radius": 1.0, "length": 1.0}, "walls": {"outer": {"angular_velocity": 1.0}}}
    depth, place = pipe(rheology, 20, **sections).thinnest_layer(0.04)
    assert depth == pytest.approx(math.sqrt(share * 0.04), rel=1e-5)  # of least_rate: 1e-6/(1/d)
    assert place == "the layer at the wall"


TABLE = [0.02 * i for i in range(101)]
SINE = [math.sin(math.pi * time) for time in TABLE]  # with nu = 0.01 half the penetration depth is 0.04
FLOW = {"fluid": {"density": 1.0, "kinematic_viscosity": 0.01}, "time": {"end": 2.0}}
BETWEEN = {"inner_radius": 1.0, "outer_radius": 2.0}
CHANNEL = {**FLOW, "scene": "channel", "geometry": {"gap": 1.0, "length": 1.0}}


@pytest.mark.parametrize("scene", ["channel", "annulus", "eccentric_annulus"])
@pytest.mark.parametrize(("across", "resolved"), [(100, True), (30, False)])
def test_kinks_of_a_table_are_no_impulsive_starts(scene, across, resolved):
    moved = {"times": TABLE, "velocities" if scene == "channel" else "angular_velocities": SINE}
    between = BETWEEN | ({"eccentricity": 0.3} if scene.startswith("eccentric") else {})
    case = CHANNEL if scene == "channel" else {**FLOW, "scene": scene, "geometry": between}
    walls = {"top" if scene == "channel" else "outer": moved}
    flow = scenes.of(loaded({**case, "walls": walls, "discretisation": {"particles_across": across}}, {}))
    assert all(resolution(flow, time)[0] for time in (0.3, 0.71, 1.011, 1.5, 2.0)) == resolved


def test_a_jump_in_a_table_and_a_drive_are_starts():
    jump = {"times": [0.0, 0.5, 0.5, 2.0], "velocities": [0.0, 0.1, 1.0, 1.0]}
    channel = scenes.of(loaded({**CHANNEL, "walls": {"top": jump}}, {}))
    assert channel.thinnest_layer(0.54) == (pytest.approx(0.02, rel=1e-12), "the layer at the top wall")  # 1e-4^(1/2)
    slow = {"walls": {"top": {"times": [0.0, 2.0], "velocities": [0.0, 1e-3]}}, "drive": {"acceleration": 1.0}}
    driven = scenes.of(loaded({**CHANNEL, **slow}, {}))
    assert driven.thinnest_layer(0.04) == (pytest.approx(0.02, rel=1e-12), "the layer at each wall")


TWO_CIRCLES = {
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 1.0},
    "geometry": {"gap": 1.0, "length": 3.0},
    "drive": {"acceleration": 1.0},
    "bodies": [{"type": "circle", "centre": place, "radius": 0.2} for place in ([0.7, 0.25], [2.2, 0.744])],
    "discretisation": {"particles_across": 50},
    "time": {"end": 1.0},
}


@pytest.mark.parametrize(
    ("spacing", "body", "spacings"), [(0.02, "body 0 and wall bottom", 2.5), (0.005, "body 1 and wall top", 2.8)]
)
def test_a_gap_counts_in_the_spacing_between_its_walls(spacing, body, spacings):
    """One of 0.05, and one of 0.056 in which there are fewer particles when those at the first are finer."""
    scene = scenes.of(loaded(TWO_CIRCLES, {"bodies.0.spacing": spacing}))
    size, name, there = scene.narrowest(0.0)[1]
    assert name == f"the gap between {body}"
    assert size / there == pytest.approx(spacings, rel=1e-6)
    assert resolution(scene, 100.0)[1].startswith(name)


def test_a_layer_counts_in_the_spacing_at_its_wall():
    """In a developed stream layers start at the cylinder alone: 0.01 deep at t = 0.1, the spacing of the stream."""
    changes = ["discretisation.particles_across=41"]
    coarse, fine = (
        scenes.of(load(CONFIGS / "cylinder_in_stream.yaml", [*changes, *more]))
        for more in ([], ["bodies.0.spacing=0.004"])
    )
    assert resolution(coarse, 0.1)[1].startswith("the layer at bodies and walls is 1 spacings thin")
    assert resolution(fine, 0.1) == (True, None)  # 2.5 spacings
    assert not resolution(fine, 0.05)[0]  # 1.8 spacings
