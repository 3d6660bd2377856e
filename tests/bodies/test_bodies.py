"""The section ``bodies`` of a config: what bodies come of it, and what is refused with what would be possible."""

import math

import numpy as np
import pytest

from tisph import registry
from tisph.bodies._clearance import problems
from tisph.config import load
from tisph.errors import ConfigError
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.line import Line
from tisph.geometry.motion import REST, RigidMotion, WallMotion

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


BAD = {
    "type": ("{type: circel, centre: [0, 0], radius: 1}", ":7: bodies.0.type", "nearest: circle"),
    "key": ("{centre: [0, 0], radus: 1}", ":7: bodies.0.radus = 1: unknown key; nearest: radius", "allowed: "),
    "key of motion": (
        "{centre: [0, 0], radius: 1, motion: {angular_velocty: 1}}",
        "bodies.0.motion.angular_velocty = 1: unknown key; nearest: angular_velocity",
    ),
    "missing": ("{centre: [0, 0]}", "bodies.0.radius: is missing"),
    "radius": ("{centre: [0, 0], radius: -1}", "bodies.0.radius = -1: must be greater than 0"),
    "one half axis": ("{type: ellipse, centre: [0, 0], half_axes: [1]}", "bodies.0.half_axes.1: is missing"),
    "half axis": ("{type: ellipse, centre: [0, 0], half_axes: [1, 0]}", "bodies.0.half_axes.1 = 0"),
    "centre": ("{centre: [0, 0, 0], radius: 1}", "bodies.0.centre = [0, 0, 0]: must have at most 2 items"),
    "word": ("{centre: [0, 0], radius: 1, motion: loose}", "bodies.0.motion = \"loose\": must be 'fixed' or 'free'"),
    "no motion": ("{centre: [0, 0], radius: 1, motion: {}}", "bodies.0.motion: give velocity or angular_velocity"),
    "two motions": (
        "{centre: [0, 0], radius: 1, motion: {angular_velocity: 1, angular_amplitude: 1, angular_frequency: 1}}",
        "bodies.0.motion.angular_velocity = 1.0: is only for a body of constant velocity",
    ),
    "no frequency": (
        "{centre: [0, 0], radius: 1, motion: {angular_amplitude: 1}}",
        "bodies.0.motion.angular_frequency: is missing",
    ),
    "phase": (
        "{centre: [0, 0], radius: 1, motion: {angular_velocity: 1, phase: sin}}",
        'bodies.0.motion.phase = "sin": is only for a body that oscillates',
    ),
    "two corners": (
        "{type: polygon, corners: [[0, 0], [1, 0]]}",
        "bodies.0.corners",
        "three corners (x, y) or more, not 2",
    ),
    "crossing": ("{type: polygon, corners: [[0, 0], [1, 1], [1, 0], [0, 1]]}", "bodies.0.corners", "meets itself"),
    "too round": (
        "{type: polygon, corners: [[0, 0], [1, 0], [1, 1], [0, 1]], corner_radius: 0.6}",
        "do not fit: at most 0.5",
    ),
}


@pytest.mark.parametrize(("line", "texts"), [(line, texts) for line, *texts in BAD.values()], ids=BAD)
def test_bad_input_is_named_with_what_is_allowed(bodies, line, texts):
    with pytest.raises(ConfigError) as caught:
        bodies(line)
    for text in texts:
        assert text in str(caught.value)


def test_bodies_need_two_spacings_of_room():
    """At walls, among themselves and their copies, and on the way of those that move."""
    spacing, periods = 0.02, (1.0, math.inf)
    walls = {"the bottom wall": Body(Line((0, 0), (1, 0), 1.0)), "the top wall": Body(Line((0, 1), (-1, 0), 1.0))}

    def circle(x, y, radius=0.1, **more):
        return Body(Circle(radius), (x, y), periods=periods, **more)

    assert list(problems([circle(0.2, 0.5), circle(0.5, 0.5)], walls, spacing)) == []
    (low,) = problems([circle(0.2, 0.13)], walls, spacing)
    assert low == (
        "bodies.0.centre",
        "comes within 0.03 of the bottom wall: leave 2 spacings, 0.04, or take a spacing of at most 0.015",
    )
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
