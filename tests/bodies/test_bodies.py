"""The section ``bodies`` of a config: bodies and suspensions that it means, and what is refused."""

import math

import numpy as np
import pytest

from tisph import registry, scenes
from tisph.bodies._clearance import problems
from tisph.config import load
from tisph.errors import ConfigError
from tisph.geometry.body import Body, smallest_gap
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.line import Line
from tisph.geometry.motion import REST, RigidMotion, WallMotion
from tisph.geometry.wanted_spacing import NearBody, WantedSpacing

SCENE = """\
\"\"\"A scene of a test, with bodies.\"\"\"

from tisph.config.fields import Bodies
from tisph.scenes import taylor_green


class Config(taylor_green.Config):
    bodies: Bodies = ()
"""

CASE = """\
scene: full
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {length: 1.0}
initial: {velocity: 1.0}
time: {end: 1.0}
bodies:
"""


@pytest.fixture
def bodies(tmp_path, monkeypatch):
    """Return a function from the lines of the section to the models of its bodies."""
    package = tmp_path / "scenes_of_a_test"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "full.py").write_text(SCENE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(registry.FAMILIES, "scenes", package.name)
    path = tmp_path / "case.yaml"

    def read(*lines):
        path.write_text(CASE + "".join(f"  - {line}\n" for line in lines))
        config = load(path)
        again = tmp_path / "again.yaml"
        again.write_text(config.resolved_yaml())
        assert load(again).bodies == config.bodies
        return config.bodies

    return read


def test_every_shape_makes_its_body(bodies):
    circle, ellipse, square, curve = bodies(
        "{type: circle, centre: [0.2, 0.3], radius: 0.1}",
        "{type: ellipse, centre: [0.2, 0.7], angle: 0.3, half_axes: [0.1, 0.05]}",
        "{type: polygon, centre: [0.7, 0.3], angle: 0.5, corners: [[0, 0], [0.1, 0], [0.1, 0.1]], corner_radius: 0.01}",
        "{type: curve, points: [[0.5, 0.4], [0.6, 0.5], [0.5, 0.6], [0.4, 0.5]]}",
    )
    assert circle.body() == Body(Circle(0.1), (0.2, 0.3))
    assert circle.body().motion is REST
    assert ellipse.body() == Body(Ellipse((0.1, 0.05)), (0.2, 0.7), 0.3)
    assert square.body((1.0, math.inf)).periods == (1.0, math.inf)
    assert (square.body().angle, square.shape().corner_radius) == (0.5, 0.01)
    assert np.abs(curve.body().nearest(np.array([[0.6, 0.5]])).distance).max() < 1e-12


def test_motions(bodies):
    fixed, moving, rotation, swinging = (
        one.body().motion
        for one in bodies(
            "{centre: [0, 0], radius: 0.1, motion: fixed}",
            "{centre: [0, 0], radius: 0.1, motion: {velocity: [0.1, -0.2], angular_velocity: 3.0}}",
            "{centre: [0, 0], radius: 0.1, motion: {angular_velocity: 3}}",
            "{centre: [0, 0], radius: 0.1, motion: {amplitude: [0, 0.5], angular_frequency: 2.0, phase: sin}}",
        )
    )
    assert fixed is REST
    assert moving == RigidMotion(WallMotion(0.1), WallMotion(-0.2), WallMotion(3.0))
    assert rotation == RigidMotion(rotation=WallMotion(3.0))
    assert swinging.y == WallMotion(0.0, 0.5, 2.0)
    assert not swinging.rotation.velocity(0.3)


def test_bodies_need_two_spacings_of_room():
    """At walls, among themselves and their copies, and on the way of those that move."""
    spacing, periods = WantedSpacing(0.02), (1.0, math.inf)
    walls = {"the bottom wall": Body(Line((0, 0), (1, 0), 1.0)), "the top wall": Body(Line((0, 1), (-1, 0), 1.0))}

    def circle(x, y, radius=0.1, **more):
        return Body(Circle(radius), (x, y), periods=periods, **more)

    assert list(problems([circle(0.2, 0.5), circle(0.5, 0.5)], walls, spacing)) == []
    (low,) = problems([circle(0.2, 0.13)], walls, spacing)
    assert low == (
        "bodies.0.centre",
        "comes within 0.03 of the bottom wall: leave 2 spacings, 0.04, or take a spacing of at most 0.015",
    )
    assert list(problems([close := circle(0.2, 0.13)], walls, WantedSpacing(0.02, (NearBody(close, 0.01),)))) == []
    (outside,) = problems([circle(0.2, 1.05)], walls, spacing)
    assert outside[1].startswith("overlaps the top wall, by 0.15")
    ((key, text, other),) = problems([circle(0.05, 0.5), circle(0.9, 0.5)], walls, spacing)
    assert (key, other) == ("bodies.1.centre", "bodies.0.centre")
    assert text.startswith("overlaps bodies.0, by 0.05")
    (wide,) = problems([circle(0.5, 0.5, 0.49)], {}, spacing)
    assert "its own periodic copy" in wide[1]
    rising = circle(0.5, 0.5, motion=RigidMotion(y=WallMotion(0.1)))
    assert list(problems([rising], walls, spacing)) == []
    assert "the top wall at time 4:" in next(problems([rising], walls, spacing, times=(0.0, 2.0, 4.0)))[1]


FLUID = "fluid: {density: 1.0, kinematic_viscosity: 1.0}\ntime: {end: 1.0}\n"
CIRCLES = "bodies: {type: random_circles, radius: 0.08, fraction: 0.2, seed: 4}\n"
TEXTS = {
    "lattice": "geometry: {length: 1.5, height: 1.0}\ndrive: {acceleration: 1.0}\n",
    "channel": "geometry: {length: 1.5, gap: 1.0}\nwalls: {top: {velocity: 1.0}}\n",
    "region": "walls: {around: {type: circle, centre: [3.0, 1.0], radius: 0.7, motion: {angular_velocity: 1.0}}}\n",
}
AREAS = {"lattice": 1.5, "channel": 1.5, "region": math.pi * 0.49}
ACROSS = "discretisation.particles_across=60"


@pytest.fixture
def read(tmp_path):
    """Return a function from a scene and overrides to its config with circles."""

    def read(scene, *changes):
        path = tmp_path / "case.yaml"
        path.write_text(f"scene: {scene}\n{FLUID}{CIRCLES}{TEXTS[scene]}")
        return load(path, [ACROSS, *changes])

    return read


def circles(config):
    """Rows x, y, radius of the bodies in the fluid."""
    scene = scenes.of(config)
    return np.array([(*body.centre, body.shape.radius) for body in scene.bodies[: scene.count]])


@pytest.mark.parametrize("scene", TEXTS)
def test_circles_fill_the_fraction_and_keep_the_gap(read, scene):
    config = read(scene)
    assert len(circles(config)) == round(0.2 * AREAS[scene] / (math.pi * 0.08**2))
    assert config.bodies.least_gap == 2.5 * config.spacing
    # 1e-6 of the walls is what gaps are good to
    assert smallest_gap(scenes.of(config).bodies)[0] >= config.bodies.least_gap - 1e-6 * 0.5


@pytest.mark.parametrize("scene", TEXTS)
def test_the_resolved_config_is_short_and_gives_the_same_circles(read, scene, tmp_path):
    config, again = read(scene), tmp_path / "config.resolved.yaml"
    again.write_text(config.resolved_yaml())
    assert str(config.bodies.least_gap) in again.read_text()
    assert set(config.resolved()["bodies"]) == {"type", "motion", "radius", "fraction", "seed", "least_gap"}
    assert load(again) == config
    assert circles(load(again)).tobytes() == circles(config).tobytes()


def test_a_seed_and_a_gap_give_the_same_circles_at_any_spacing(read):
    first, again, other = (
        circles(read("lattice", "bodies.least_gap=0.05", f"bodies.seed={seed}", f"discretisation.particles_across={n}"))
        for seed, n in ((4, 48), (4, 96), (5, 48))
    )
    assert first.tobytes() == again.tobytes()
    assert np.abs(first - other).max() > 0.1


def test_all_circles_have_the_motion_and_the_density(read):
    scene = scenes.of(read("lattice", "bodies.motion={angular_velocity: 2.0}"))
    motions = {(float(body.motion.rotation.velocity(0.5)), float(body.motion.x.velocity(0.5))) for body in scene.bodies}
    assert motions == {(2.0, 0.0)}
    scene = scenes.of(read("channel", "bodies.motion=free", "bodies.density=2.0"))
    masses = [body.motion.inertia.mass[0] for body in scene.bodies[: scene.count]]
    assert masses == pytest.approx([2.0 * math.pi * 0.08**2] * scene.count, rel=1e-14)  # of a product of three


@pytest.mark.parametrize(("shares", "parts"), [("null", (0.5, 0.5)), ("[0.25, 0.75]", (0.25, 0.75))])
def test_radii_of_a_mixture_share_the_area(read, shares, parts):
    found = circles(read("lattice", "bodies.radius=[0.06, 0.12]", f"bodies.shares={shares}", "bodies.fraction=0.25"))
    counts = [np.count_nonzero(found[:, 2] == radius) for radius in (0.06, 0.12)]
    solid = [part * 0.25 * 1.5 for part in parts]
    assert counts == [round(area / (math.pi * r**2)) for area, r in zip(solid, (0.06, 0.12), strict=True)]


def test_a_fraction_that_is_too_large_names_one_that_fits(read):
    with pytest.raises(ConfigError, match=r"bodies.fraction = 0.7: no places .* circles, 52; .* is ") as refused:
        read("channel", "bodies.fraction=0.7")
    fits = float(str(refused.value).rpartition(" ")[2])
    assert 0.4 < fits < 0.7
    assert len(circles(read("channel", f"bodies.fraction={fits}"))) == round(fits * 1.5 / (math.pi * 0.08**2))
