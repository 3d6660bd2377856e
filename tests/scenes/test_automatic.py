"""Places to refine, from flows that are fine in one place: the rules for spacings accept them in every kind of flow."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from tisph import scenes
from tisph.config import load
from tisph.config.loader import loaded
from tisph.scenes._automatic import MORE, _Demand, places_of
from tisph.scenes._spacing import parts_of
from tisph.snapshot import STRESSES, Bodies, Snapshot

CONFIGS = Path(__file__).parents[2] / "configs"


def state(config, depth, near=(0.0, 0.0), part=None):
    """Snapshot of a flow whose velocity decays over ``depth`` from a ``part`` of its boundary, or from a point."""
    flow = scenes.of(config)
    (x, y), t = flow.jittered(0, 0.2), flow.start_time
    places = np.stack([x, y], axis=1)
    bodies = Bodies.at(t, flow.bodies) if flow.bodies else None
    away = parts_of(flow)[part].nearest(places, t).distance if part else np.hypot(*(places - near).T)
    stress = {name: np.exp(-away / depth) for name in STRESSES} if flow.polymer else {}
    still = {"v": 0 * x, "w": 0 * x if flow.axisymmetric else None, "density": 1 + 0 * x, "pressure": 0 * x}
    speed = flow.reference_velocity * np.exp(-away / depth)
    return Snapshot(t=t, step=1, x=x, y=y, u=speed, bodies=bodies, **still, **stress)


def refined(name, *changes, **given):
    """The config with its places, and the flow of each."""
    config = load(CONFIGS / f"{name}.yaml", [*changes, "discretisation.refine=auto"])
    coarse = scenes.of(config)
    places = places_of(config, coarse, [state(config, 1.5 * coarse.spacing, **given)])
    fine = loaded(config, {"discretisation.refine": [each.model_dump(exclude_none=True) for each in places]})
    return fine, scenes.of(fine), coarse


@pytest.mark.parametrize(
    ("name", "part", "across"),
    [
        ("cylinder_in_channel", "bodies.0", 16),  # below a wall that moves
        ("cylinder_in_stream", "bodies.0", 28),  # between open ends
        ("cavity", "walls.bottom", 24),  # with a sharp lid
        ("cavity_regular", "walls.lid", 24),
        ("eccentric_annulus", "walls.inner", 12),
        ("taylor_vortices", "walls.inner", 12),
        ("sphere_in_tube", "sphere", 20),
        ("confined_cylinder_oldroyd_b", "bodies.0", 24),
        ("free_cylinder", "bodies.0", 24),
    ],
)
def test_particles_are_closer_at_the_part_with_the_layer(name, part, across):
    config, fine, coarse = refined(name, f"discretisation.particles_across={across}", part=part)
    assert fine.particles == pytest.approx(MORE * coarse.particles, rel=0.2)
    at = parts_of(fine)[part].boundary_points(0.1 * parts_of(fine)[part].shape.length).point
    assert np.median(fine.wanted_spacing.at(at)) < coarse.spacing / 1.5
    assert any(place.near == part for place in config.discretisation.refine)


def test_a_point_in_a_periodic_box_is_refined_across_its_edge():
    _, fine, coarse = refined("taylor_green", near=(0.5, 0.5))
    assert fine.particles == pytest.approx(MORE * coarse.particles, rel=0.2)
    assert fine.wanted_spacing.at(np.array([[0.5, 0.5]]))[0] < coarse.spacing / 1.5


def test_free_circles_have_one_spacing_together():
    config, fine, _ = refined("suspension", part="bodies.0")
    assert "bodies" in [place.near for place in config.discretisation.refine]
    bodies = [body for body in fine.bodies if body.free]
    at_walls = [fine.wanted_spacing.at(body.boundary_points(0.1).point) for body in bodies]
    assert np.ptp(np.concatenate(at_walls)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("apart", "free", "expected"),
    [
        (0.3, np.inf, {"body": 0.02, "wall": 0.05}),  # the wall lies where the spacing has grown to 0.05
        (1.0, np.inf, {"body": 0.02, "wall": 0.1}),
        (0.3, 0.6, {"body": 0.04, "wall": 0.07}),  # at 0.6 from the body the spacing must be 0.1
        (0.3, 0.0, {"body": 0.1, "wall": 0.1}),
    ],
)
def test_a_moving_wall_is_as_fine_as_a_body_near_it_asks(apart, free, expected):
    pairs = {("body", "wall"): apart, ("wall", "body"): apart}
    sizes = {"largest": 0.1, "growth": 0.1, "moving": {"body": free, "wall": np.inf}, "apart": pairs}
    away = {"body": np.array([0.1, 0.1, 1.0, 1.0]), "wall": np.array([1.0, 1.0, 0.1, 0.1])}
    demand = _Demand(**dict.fromkeys([each.name for each in fields(_Demand)]) | sizes | {"away": away})
    assert demand.of_moving(np.array([0.02, 0.02, 0.1, 0.1])) == pytest.approx(expected)


def test_a_fluid_at_rest_gets_no_places():
    config = load(CONFIGS / "taylor_green.yaml", ["discretisation.refine=auto"])
    moving = state(config, 1.0)
    assert places_of(config, scenes.of(config), [replace(moving, u=0 * moving.u)]) == ()


def test_no_place_is_coarser_than_the_config_says():
    _, fine, coarse = refined("cylinder_in_channel", "bodies.0.spacing=0.02", part="bodies.0")
    points = np.random.default_rng(0).uniform(0.0, [2.0, 1.0], (1000, 2))
    assert (fine.wanted_spacing.at(points) <= coarse.wanted_spacing.at(points)).all()
