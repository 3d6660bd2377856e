"""Spacing that varies, from a config: its sources, its errors with their ways out, and coarser runs."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tisph import scenes
from tisph.config import load
from tisph.config.sections import Refinement
from tisph.errors import ConfigError
from tisph.scenes._spacing import parts_of
from tisph.schemes._forecast import described, forecast
from tisph.studies.error_estimate import Coarser

CONFIGS = Path(__file__).parents[2] / "configs"

SLIPS = "bodies.0.slip_length=0.01"

TOO_NEAR = [
    ("cylinder_in_channel", "bodies.0.spacing=0.02", "bodies.0.motion=free", "bodies.0.centre=[1.0, 0.35]", SLIPS),
    ("cylinder_in_channel", "discretisation.refine=[{at: [1.0, 0.8], spacing: 0.02, within: 0.05}]", SLIPS),
    ("cylinder_in_stream", "discretisation.particles_across=20", "bodies.0.spacing=0.004"),
    ("cavity", "discretisation.refine=[{at: [0.5, 0.8], spacing: 0.005, within: 0.1}]"),
]
"""Config and changes: a smaller spacing reaches a wall of another one, an end, or the corner of a lid."""

WAYS = {
    r"give discretisation\.growth (\S+), ": "discretisation.growth={0}",
    r"give a spacing of (\S+) or more": "{key}={0}",
    r"give (\S+) the spacing (\S+), too": "{0}.spacing={1}",
}
"""Way out in an error -> the change that it means."""


@pytest.mark.parametrize("case", TOO_NEAR, ids=" ".join)
def test_each_way_out_of_an_error_works(case):
    path, changes = CONFIGS / f"{case[0]}.yaml", list(case[1:])
    with pytest.raises(ConfigError) as refused:
        load(path, changes)
    (line,) = str(refused.value).splitlines()
    key = re.search(r": ([\w.]+\.spacing) = ", line).group(1)
    found = [(pattern, change) for pattern, change in WAYS.items() if re.search(pattern, line)]
    assert len(found) >= 2
    for pattern, change in found:
        load(path, [*changes, change.format(*re.search(pattern, line).groups(), key=key)])


@pytest.mark.parametrize(
    ("config", "names"),
    [
        ("cylinder_in_channel", "bodies.0 walls.bottom walls.top"),
        ("drafting_kissing_tumbling", "bodies.0 bodies.1 walls.bottom walls.top"),
        ("eccentric_annulus", "walls.inner walls.outer"),
        ("cavity_regular", "walls.bottom walls.right walls.lid walls.left"),
        ("sphere_in_tube", "sphere walls.tube"),
        ("taylor_vortices", "walls.inner walls.outer"),
        ("pipe", "walls.outer"),
        ("cylinder_in_stream", "bodies.0 walls.bottom walls.top"),
        ("sphere_in_stream", "bodies.0 walls.top"),
    ],
)
def test_bodies_and_walls_have_the_names_of_their_keys(config, names):
    """Each is a source where it is named, and its distance is 0 at its own points."""
    whole = load(CONFIGS / f"{config}.yaml")
    parts = parts_of(scenes.of(whole))
    assert list(parts) == names.split()
    for name, part in parts.items():
        place = Refinement(near=name, spacing=0.5 * whole.spacing)
        refined = whole.discretisation.model_copy(update={"refine": (place,)})
        flow = scenes.of(whole.model_copy(update={"discretisation": refined}))
        points = part.boundary_points(0.1 * part.shape.length).point
        assert np.allclose(flow.wanted_spacing.at(points), 0.5 * whole.spacing)


def test_points_on_walls_without_slip_may_come_closer():
    config, *changes, _ = TOO_NEAR[0]
    flow = scenes.of(load(CONFIGS / f"{config}.yaml", changes))
    wall = flow.bodies[1].boundary_points(0.05).point
    assert flow.wanted_spacing.at(wall).min() < 0.9 * flow.spacing


GAPS = ["bodies.1.centre=[0.6, 0.75]", "discretisation.refine=[{near: gaps, spacing: 0.01}]"]


def test_gaps_have_a_share_of_their_width():
    """A quarter of it, but at least the given spacing; where bodies are later by their places then."""
    flow = scenes.of(load(CONFIGS / "drafting_kissing_tumbling.yaml", GAPS))
    assert flow.wanted_spacing.between(*flow.bodies[:2], 0.0) == pytest.approx(0.25 * 0.05, rel=1e-4)  # of 1000 places
    nothing = np.zeros((len(flow.bodies), 2))
    centre = np.array([[0.9, 0.75], [0.62, 0.75], [0.0, 0.0], [0.0, 0.0]])
    bodies = SimpleNamespace(centre=centre, velocity=nothing, angle=nothing[:, 0], angular_velocity=nothing[:, 0])
    later = flow.seen(SimpleNamespace(t=1.0, bodies=bodies))
    assert later.wanted_spacing.between(*later.bodies[:2], 1.0) == pytest.approx(0.01)
    assert flow.contact_distance == pytest.approx(2 * 0.01)


def test_places_and_circles_of_a_suspension_have_periods():
    vortices = load(CONFIGS / "taylor_green.yaml", ["discretisation.refine=[{at: [0.0, 0.5], spacing: 0.01}]"])
    flow = scenes.of(vortices)
    near, far = flow.wanted_spacing.at(np.array([[0.95 * flow.extent[0], 0.5], [0.05 * flow.extent[0], 0.5]]))
    assert near == pytest.approx(far)
    assert near < flow.spacing
    suspension = scenes.of(load(CONFIGS / "suspension.yaml", ["bodies.spacing=0.015"]))
    assert [source.body for source in suspension.spacing_sources] == list(suspension.bodies[:8])


def test_the_smaller_spacing_is_around_a_free_body_where_it_is_then():
    flow = scenes.of(load(CONFIGS / "free_cylinder.yaml", ["bodies.0.spacing=0.02"]))
    nothing = np.zeros((len(flow.bodies), 2))
    centre, angle = np.array([[1.3, 0.5]] + 2 * [[0.0, 0.0]]), nothing[:, 0]
    bodies = SimpleNamespace(centre=centre, velocity=nothing, angle=angle, angular_velocity=angle)
    wanted = flow.seen(SimpleNamespace(t=1.0, bodies=bodies)).wanted_spacing
    radius = flow.bodies[0].shape.radius
    assert np.allclose(wanted.at(np.array([[1.3 + radius, 0.5], [1.3 + radius + 0.05, 0.5]]), 1.0), [0.02, 0.025])


def test_coarser_runs_have_the_same_ratios_of_spacings(tmp_path):
    changes = ["bodies.0.spacing=0.02", "discretisation.refine=[{at: [0.3, 0.3], spacing: 0.03}]"]
    config = load(CONFIGS / "cylinder_in_channel.yaml", ["discretisation.particles_across=32", *changes])
    for coarser in Coarser(config, tmp_path).configs:
        ratio = 32 / coarser["discretisation"]["particles_across"]
        assert coarser["bodies"][0]["spacing"] == pytest.approx(0.02 * ratio)
        assert coarser["discretisation"]["refine"][0]["spacing"] == pytest.approx(0.03 * ratio)


def test_check_states_spacings_and_the_particles_that_one_spacing_needs():
    config = load(
        CONFIGS / "cylinder_in_stream.yaml", ["discretisation.particles_across=41", "bodies.0.spacing=0.0025"]
    )
    numbers, _ = forecast(config)
    assert numbers["particles_if_finest"] == round((2.2 * 0.41 - np.pi * 0.05**2) / 0.0025**2)
    text = "\n".join(described(config, numbers, ()))
    assert "0.0025 to 0.01 m (41 across where it is largest)" in text
    assert f"{numbers['particles']}; {numbers['particles_if_finest']} with the smallest spacing everywhere" in text


def test_check_says_that_a_first_run_decides_and_what_follows():
    config = load(CONFIGS / "cylinder_in_stream.yaml", ["discretisation={particles_across: 32, refine: auto}"])
    text = "\n".join(described(config, *forecast(config)))
    least = f"{config.spacing / 8:.4g}"
    words = f"a first run; the run that follows has about 2 times the particles, spacings of {least} m or more"
    assert words in text
    assert "up to 8 times the steps" in text
