"""Every reference is used by those configs alone that meet its assumptions: inertia, fluid, walls, ends, bodies."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tisph import registry, scenes
from tisph.config import load
from tisph.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"
FLUIDS = {
    "thins": "{type: power_law, index: 0.5, reference_rate: 1.0, least_rate: 0.01}",
    "yields": "{type: herschel_bulkley, yield_stress: 0.1, index: 1.0, regularisation: 100.0}",
    "polymer": "{type: oldroyd_b, relaxation_time: 0.1, solvent_fraction: 0.5}",
    "thinning polymer": "{type: giesekus, relaxation_time: 0.1, solvent_fraction: 0.5, mobility: 0.2}",
}
NAMES = ["couette", "circular_couette", "pipe", "taylor_green", "cavity", "cavity_regular", "eccentric_annulus"]
NAMES += ["taylor_vortices", "falling_ball", "cylinder_lattice", "cylinder_in_stream", "free_cylinder"]
NAMES += ["cylinder_in_channel", "turned_box", "rotating_end", "shear_layer"]
VARIANTS = [(), ("fluid.inertia=false",), *((f"fluid.rheology={law}",) for law in FLUIDS.values())]


def scene_of(name, *overrides):
    return scenes.of(load(CONFIGS / f"{name}.yaml", overrides))


def references(scene):
    """Names of the references that a run draws, or measures its errors against."""
    series = scene.time_series(3) if scene.parallel else scene.time_series()
    shown = {profile.reference for profile in scene.profiles() if profile.exact}
    return shown | ({series.level_name} if np.isfinite(series.levels).any() else set())


def residual(scene, flow, x, y, step):
    """Return inertia (u dw/dx + v dw/dy) - nu lap w at places, by central differences of the vorticity w."""
    shifts = ((step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step))
    east, west, north, south = (flow.vorticity(x + a, y + b) for a, b in shifts)
    (u, v), middle = flow.velocity(x, y), flow.vorticity(x, y)
    carried = scene.inertia * (u * (east - west) + v * (north - south)) / (2.0 * step)
    return carried - scene.kinematic_viscosity * (east + west + north + south - 4.0 * middle) / step**2


def test_no_scene_is_left_out():
    assert {load(CONFIGS / f"{name}.yaml").scene for name in NAMES} == set(registry.names("scenes"))


@pytest.mark.parametrize("name", NAMES)
def test_references_in_other_fluids_and_without_inertia(name):
    """A reference of all times knows the fluid and has inertia; others state assumptions that the config meets."""
    for overrides in VARIANTS:
        try:
            scene = scene_of(name, *overrides)
        except ConfigError:
            continue
        if scene.fields:
            assert scene.inertia  # start_up.py and taylor_green.py; the former has all fluids
            assert scene.rheology is None or hasattr(scene, "_flow") or hasattr(scene, "_flows")
        elif references(scene) - {"exact, when steady"}:  # of a body that bears the whole drive, in any fluid
            assert scene.reference.applies
            assert scene.rheology is None


@pytest.mark.parametrize("overrides", [(), ("fluid.inertia=false",)], ids=["inertia", "none"])
@pytest.mark.parametrize("name", ["cavity_regular", "eccentric_annulus"])
def test_the_reference_satisfies_the_equations_of_the_config(name, overrides):
    """Vorticity is carried as far as the config has inertia, and diffuses."""
    scene = scene_of(name, *overrides)
    if name == "cavity_regular":
        flow, lowest = replace(scene._exact, order=28), (0.25, 0.25)
        wide, tolerance = 0.5, 5e-2  # measured 2e-2: degree 28, and differences of second order
    else:
        flow, lowest = scene.stokes(scene.inner.velocity(0.0), scene.outer.velocity(0.0)), (-2.0, -0.2)
        wide, tolerance = 0.3, 0.1  # the Reynolds number up to which inertia is negligible
    x, y = np.add(lowest, wide * np.random.default_rng(1).uniform(size=(200, 2))).T
    if name == "eccentric_annulus":
        x, y = 0.5 * (scene.outer_radius + scene.inner_radius) * np.stack([np.cos(3.0 + y), np.sin(3.0 + y)])
    rates = scene.kinematic_viscosity * np.abs(flow.vorticity(x, y)).max() / scene.reference_length**2
    assert np.abs(residual(scene, flow, x, y, 0.005 * scene.reference_length)).max() < tolerance * rates
    names = {"Stokes flow", "exact, when steady"} if name == "eccentric_annulus" else {"steady"}
    assert references(scene) == ({"Stokes flow"} if name == "cavity_regular" and overrides else names)


def test_a_torque_is_compared_with_that_of_the_motion_that_goes_on():
    """A r + B/r has no slip at both cylinders at all times of the run, or is no reference."""
    for inner in ("{angular_velocity: 2.0}", "{amplitude: 2.0, angular_frequency: 1.0}"):
        scene = scene_of("taylor_vortices", "initial={}", f"walls.inner={inner}")
        a, b = scene.laminar
        slips = [
            abs(radius * body.spin.velocity(t) - (a * radius + b / radius))
            for t in (0.0, 0.3, 1.7)
            for body, radius in zip(scene.bodies, (scene.inner_radius, scene.outer_radius), strict=False)
        ]
        assert references(scene) == (set() if max(slips) > 1e-12 else {"laminar"})


@pytest.mark.parametrize(
    ("overrides", "known"),
    [
        ((), True),
        (("fluid.kinematic_viscosity=0.1",), False),  # Re = U a/nu = 0.45
        (("fluid={density: 1.0, kinematic_viscosity: 0.1, inertia: false}",), True),
        (("geometry.length=1.9",), False),  # 0.9 of the tube's radius between a sphere and the next
        (("sphere.angular_velocity=0.5",), False),  # W a^2/nu = 0.125
        (("walls.tube.velocity=0.1",), False),
        (("geometry.half_length=0.4",), False),
    ],
)
def test_a_ball_is_compared_with_stokes_flow_where_that_is_its_flow(overrides, known):
    scene = scene_of("falling_ball", *overrides)
    assert references(scene) == ({"Stokes flow in this tube (Bohlin)"} if known else set())
    (text,) = (text for label, text in scene.parameters() if label == "reference")
    assert text.startswith("none: ") != known


def test_heights_tables_and_oscillations_outside_the_assumptions_have_no_reference():
    """Tall cavities have none: at Re = 400 polynomials of this degree miss 2e-5 of the speed at twice the width."""
    slow = scene_of("cavity_regular", "fluid.inertia=false")
    assert slow._exact.reynolds == 0.0
    assert references(scene_of("cavity_regular", "geometry.height=3.0")) == set()
    assert references(scene_of("cavity", "fluid.kinematic_viscosity=0.003")) == set()  # no table
    turning = "walls.inner={amplitude: 1.0e-3, angular_frequency: 1.0}"
    assert references(scene_of("eccentric_annulus", turning)) == set()
    slow = scene_of("eccentric_annulus", turning, "fluid.inertia=false")
    assert [(each.reference, each.steady) for each in slow.profiles()] == [("Stokes flow", False)]
