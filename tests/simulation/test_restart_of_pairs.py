"""Checkpoint and restart where features meet: swirl, free bodies, contact, polymer, kept mean velocity, body force.

Every pair that a scene allows is in one of the cases: no scene has contact with swirl or with a kept mean velocity.
"""

import dataclasses

import numpy as np
import pytest

import tisph

pytestmark = pytest.mark.taichi

COMMON = {"initial": {"jitter": 0.1}, "runtime": {"threads": 1}}
OLDROYD_B = {"type": "oldroyd_b", "relaxation_time": 0.1, "solvent_fraction": 0.5}


def fluid(viscosity, **rheology):
    return {"density": 1.0, "kinematic_viscosity": viscosity, **rheology}


TUBE = {
    "scene": "sphere_in_tube",
    "fluid": fluid(1.0),
    "geometry": {"tube_radius": 1.0, "sphere_radius": 0.5, "length": 2.0},
    "sphere": {"free": True, "density": 2.0, "force": -0.5},
    "discretisation": {"particles_across": 10},
    "time": {"end": 0.1},
}
SPINNING = {"walls": {"tube": {"angular_velocity": 1.0}}}
KEPT = {"drive": {"mean_velocity": 0.5}}
TOUCHING = {
    "scene": "channel",
    "fluid": fluid(0.1),
    "geometry": {"gap": 1.0, "length": 1.0},
    "walls": {"top": {"velocity": 0.5}},
    "bodies": [
        {"centre": [0.3, 0.5], "radius": 0.15, "motion": "free"},
        {"centre": [0.72, 0.5], "radius": 0.15, "motion": "free", "density": 2.0},
    ],
    "contact": {"distance": 0.15},
    "discretisation": {"particles_across": 20},
    "time": {"end": 0.1, "tolerance": 1e-4},
}
CASES = {
    "swirl, free body, kept mean velocity": ({**TUBE, **SPINNING, **KEPT}, None, ("w", "velocity", "acceleration")),
    "swirl, free body, kept mean velocity, polymer, body force": (
        {**TUBE, **SPINNING, **KEPT, "fluid": fluid(1.0, rheology=OLDROYD_B)},
        lambda x, y, t: (np.sin(3.0 * x), 0.0 * y, 0.3 * y * (1.0 + t)),
        ("w", "velocity", "acceleration", "stress_xt"),
    ),
    "free bodies, contact, polymer, body force": (
        {**TOUCHING, "fluid": fluid(0.1, rheology=OLDROYD_B)},
        lambda x, y, t: (np.sin(6.0 * y) * (1.0 + t), np.cos(6.0 * x)),
        ("velocity", "contact_force", "stress_xy"),
    ),
    "free bodies, contact, no inertia": (
        {**TOUCHING, "fluid": fluid(0.1, inertia=False)},
        None,
        ("velocity", "contact_force"),
    ),
}
"""Config, body force, and numbers of a snapshot that are not 0 if the features are there."""


def numbers(snapshot):
    """All numbers of a snapshot and of its bodies, by name."""
    found = {}
    for part in (snapshot, snapshot.bodies):
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            if isinstance(value, (np.ndarray, float, int)):
                found[field.name] = np.asarray(value)
    return found


@pytest.mark.parametrize("name", CASES)
def test_a_resumed_run_with_several_features_has_the_same_bits(tmp_path, name):
    config, force, present = CASES[name]
    saved = tmp_path / "state.h5"
    with tisph.Simulation({**COMMON, **config}, body_force=force) as straight:
        for step in range(10):
            if step == 6:  # more than the multistep method remembers
                straight.save(saved)
            straight.step()
        expected, host = numbers(straight.scheme.snapshot()), straight.scheme.host_state()
    with tisph.Simulation.restore(saved, body_force=force) as resumed:
        for _ in range(4):
            resumed.step()
        found = numbers(resumed.scheme.snapshot())
        assert resumed.scheme.host_state() == host
    assert expected.keys() == found.keys()
    assert [key for key in expected if not np.array_equal(expected[key], found[key], equal_nan=True)] == []
    assert all(np.abs(expected[key]).max() > 0.0 for key in present)
