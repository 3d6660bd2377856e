"""One flow seen from two frames, and from a reference velocity that its config says."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import make_channel, particles

from tisph import registry, scenes
from tisph.config.loader import load, loaded
from tisph.config.yaml_text import parse
from tisph.errors import ConfigError
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.measures.metrics import relative_error, sample_metrics
from tisph.schemes._forecast import estimates
from tisph.simulation.state import seen_from_config
from tisph.snapshot import Bodies

SPEED = 1.0
"""Of the frame: two hundred times that of the walls, whose digits are lost by as much (2e-16 * 200), and by ten times
more in differences of velocities near a wall."""
ROUNDING = 1e-12

DRIVEN = {"acceleration": 6e-4}  # mean speed g H^2 / (12 nu) = 0.005
FLOWS = {
    "couette": (WallMotion(0.0), WallMotion(0.005), {}),
    "started wall": (WallMotion(0.0, before=0.0), WallMotion(0.005, before=0.0), {}),
    "stopped wall": (WallMotion(0.0), WallMotion(0.0, before=0.005), {}),
    "reversed wall": (WallMotion(0.005, before=-0.001), WallMotion(0.0), {}),
    "both change": (WallMotion(0.0, before=0.001), WallMotion(-0.004, before=0.003), {}),
    "driven": (WallMotion(0.0), WallMotion(0.0), DRIVEN),
}


def seen_from_two_frames(flow):
    """A settled flow, and the same one seen from a frame that moves backwards."""
    bottom, top, changes = FLOWS[flow]
    channel = make_channel(bottom=bottom, top=top, initial_state="developed", **changes)
    return channel, replace(channel, bottom=bottom.relative_to(-SPEED), top=top.relative_to(-SPEED))


@pytest.mark.parametrize("flow", FLOWS)
def test_the_scales_of_a_flow_are_those_of_every_frame(flow):
    channel, moved = seen_from_two_frames(flow)
    assert moved.frame_velocity == pytest.approx(SPEED + channel.frame_velocity, rel=ROUNDING)
    for name in ("wall_speed", "reference_velocity", "peak_velocity", "reynolds"):
        assert getattr(moved, name) == pytest.approx(getattr(channel, name), rel=ROUNDING), name
    for wall in ("bottom", "top"):
        own, other = (getattr(seen.in_flow_frame(), wall) for seen in (channel, moved))
        assert vars(other) == pytest.approx(vars(own), abs=1e-15)  # SPEED's last digit
    if flow != "both change":  # a wall that stays at rest is the frame
        assert channel.frame_velocity == 0.0
        assert channel.in_flow_frame() == channel
        assert channel.reference_velocity == pytest.approx(0.005, rel=1e-15)
    if flow == "started wall":  # a fluid at rest has no relative error in any frame
        for seen in (channel, moved):
            x, y = seen.lattice()
            u = seen.exact_velocity(y, 0.0)
            assert relative_error(seen, particles(seen, 0.0, x, y, u)) is None
            assert relative_error(seen, particles(seen, 1.0, x, y, u)) == pytest.approx(1.0, rel=ROUNDING)


@pytest.mark.parametrize("bottom", [0.5, 1.0, -1.0])
def test_the_frame_of_a_fluid_that_starts_from_rest_is_its_rest(bottom):
    channel = make_channel(bottom=WallMotion(bottom), top=WallMotion(1.0))
    assert (channel.frame_velocity, channel.reference_velocity) == (0.0, 1.0)


@pytest.mark.parametrize("flow", FLOWS)
def test_errors_are_the_same_in_every_frame(flow):
    channel, moved = seen_from_two_frames(flow)
    x, y = channel.lattice()
    t = 2.0
    noise = 1e-5 * np.random.default_rng(1).uniform(-1.0, 1.0, len(x))
    u = channel.exact_velocity(y, t) + noise
    heights = np.linspace(0.0, channel.gap, 7)
    one, other = (
        sample_metrics(scene, particles(scene, t, x, y, u + speed), (heights, 3.0 * heights + speed))
        for scene, speed in ((channel, 0.0), (moved, SPEED))
    )
    for name in ("l2", "rms", "linf", "slope", "wall_shear_bottom", "wall_shear_top"):
        assert other[name] == pytest.approx(one[name], rel=1e-9)  # 1e-5 of noise on a velocity of 1 is left
    assert other["centreline"] == pytest.approx(one["centreline"] + SPEED, rel=ROUNDING)


def test_bodies_move_with_the_fluid_around_them():
    """What stands in the frame of the flow goes 3 times 0.5 as the config sees it."""
    falling = RigidMotion(y=WallMotion(-0.1))
    bodies = Body(Circle(0.1), (0.5, 0.2)), Body(Circle(0.1), (0.5, 0.7), motion=falling)
    channel = make_channel()
    snapshot = particles(channel, 3.0, [0.5], [0.4], [0.0])
    snapshot = replace(snapshot, bodies=Bodies.at(3.0, bodies))
    seen = seen_from_config(snapshot, SimpleNamespace(frame_velocity=0.5, start_time=0.0, extent=(1.0, 1.0)))
    assert seen.x.tolist() == [0.0]
    assert np.allclose(seen.bodies.centre, [[2.0, 0.2], [2.0, 0.4]], rtol=0, atol=1e-15)  # they are followed, not boxed
    assert seen.bodies.velocity.tolist() == [[0.5, 0.0], [0.5, -0.1]]


def walls(bottom, top, before=None):
    text = "" if before is None else f", velocity_before: {before}"
    return [f"walls.bottom={{velocity: {bottom}}}", f"walls.top={{velocity: {top}{text}}}"]


@pytest.mark.parametrize("scheme", ["implicit", "wcsph"])
@pytest.mark.parametrize("before", [None, 0.0])
def test_check_says_the_same_in_every_frame(case, scheme, before):
    developed = ("initial.state=developed", f"scheme={{type: {scheme}}}")
    moved = None if before is None else before + SPEED
    one = estimates(case(*developed, *walls(0.0, 0.005, before)))
    other = estimates(case(*developed, *walls(SPEED, SPEED + 0.005, moved)))
    (first,), (second,) = one.pop("samples"), other.pop("samples")
    assert second.steps == first.steps
    if scheme == "wcsph":  # no error is predicted
        assert (second.l2, second.rms, first.l2, first.rms) == (None,) * 4
    else:  # a small difference of velocities: rounding counts for more, in the smallest, 2e-13, for a thousandth
        assert (second.l2, second.rms) == pytest.approx((first.l2, first.rms), rel=1e-2)
    assert other.pop("error") == second.l2
    del one["error"]
    for key, value in one.items():
        assert other[key] == (pytest.approx(value, rel=ROUNDING) if isinstance(value, float) else value), key
    assert one["reynolds"] == pytest.approx(0.5)


def test_walls_and_fluid_that_move_together_do_not_move(case):
    """Refused like a flow at rest, which it is."""
    with pytest.raises(ConfigError, match="nothing moves"):
        case("initial.state=developed", *walls(0.5, 0.5))
    with pytest.raises(ConfigError, match="nothing moves"):
        case("initial={state: exact, time: 0.1}", *walls(0.5, 0.5, 0.5))
    assert case(*walls(0.5, 0.5)).initial.state == "rest"
    assert case("initial={state: exact, time: 0.1}", *walls(0.5, 0.5)).start_time == 0.1
    assert case("initial.state=developed", "drive.acceleration=1", *walls(0.5, 0.5)).drive.acceleration == 1.0


def test_a_state_is_shown_in_the_frame_of_the_config():
    channel, moved = seen_from_two_frames("couette")
    x, y = channel.lattice()
    snapshot = particles(channel, 2.5, x, y, channel.exact_velocity(y, 2.5))
    shown = seen_from_config(snapshot, moved)
    assert np.allclose(shown.u, snapshot.u + SPEED, rtol=ROUNDING, atol=0)
    # 2.5 s at speed 1 are 125 periods of 0.02: everything is where it was, to rounding of the path
    across = np.abs((shown.x - x + 0.5 * channel.length) % channel.length - 0.5 * channel.length)
    assert across.max() < ROUNDING * SPEED * 2.5
    assert seen_from_config(snapshot, channel) is snapshot


CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = parse((Path(__file__).parent / "data" / "scenes.yaml").read_text(encoding="utf-8")).data
REST = {
    "name": "still",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.1},
    "discretisation": {"particles_across": 20},
    "time": {"end": 0.1},
}


@pytest.mark.parametrize("name", registry.names("scenes"))
def test_numbers_refer_to_the_given_velocity_and_references_to_the_flow(name):
    path = CONFIGS / f"{SCENES[name]['config']}.yaml"
    own = scenes.of(load(path))
    for factor in (1e-2, 1e2):
        velocity = factor * own.reference_velocity
        scene = scenes.of(load(path, [f"reference.velocity={velocity!r}"]))
        assert scene.reference_velocity == velocity
        assert scene.reynolds == pytest.approx(factor * own.reynolds, rel=1e-12)
        assert scene.peak_velocity >= max(own.peak_velocity, velocity)
        assert f"{velocity:.6g}" in " ".join(text for _, text in scene.parameters())
        assert scene.in_flow_frame().reference_velocity == velocity


@pytest.mark.parametrize("scene", [name for name, row in SCENES.items() if "still" in row])
def test_a_fluid_that_nothing_moves_needs_a_velocity(scene):
    config = {**REST, "scene": scene, **SCENES[scene]["still"]}
    with pytest.raises(ConfigError, match=r"nothing moves: .* or a reference\.velocity"):
        loaded(config, {})
    still = scenes.of(loaded({**config, "reference": {"velocity": 3.0}}, {}))
    assert still.reference_velocity == 3.0
    assert still.time_series(**({"count": 3} if scene == "channel" else {})).columns
