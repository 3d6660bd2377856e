"""Any valid config runs with finite numbers, or is refused by name, or stops with an error that says why."""

import collections
import json
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tisph import config, registry, runtime, schemes
from tisph.errors import ConfigError, DivergedError
from tisph.measures.metrics import sample_metrics
from tisph.observers.guard import Guard
from tisph.scenes.channel import Channel
from tisph.schemes._forecast import estimates
from tisph.simulation.state import start_values

pytestmark = pytest.mark.taichi

STEPS = {"wcsph": 50, "implicit": 5}
"""How far a config is run, by the scheme that it means."""

speeds = st.floats(-1.0, 1.0).map(lambda share: share or 0.5)
scales = st.integers(-6, 6).map(lambda exponent: 10.0**exponent)
"""Of length, density and time: a flow is the same in any units, its numbers are not."""


IMAGES = ["comoving_image", "consistent_image", "virtual_image"] * 3
"""Wall treatments that every scheme has, often enough to make the others rare."""


@st.composite
def walls(draw, scale, swinging):
    """A wall of constant velocity, with or without one before, or an oscillating one."""
    velocity = {"velocity": scale * draw(speeds)}
    kind = draw(st.sampled_from(["constant", "constant", "stopped", "swinging" if swinging else "constant"]))
    if kind == "stopped":
        return {**velocity, "velocity_before": scale * draw(speeds)}
    if kind == "swinging":
        amplitude = {"amplitude": scale, "angular_frequency": draw(st.floats(0.1, 100.0)) * scale}
        return {**amplitude, "phase": draw(st.sampled_from(["cos", "sin"]))}
    return velocity


@st.composite
def equations_of_state(draw, scale):
    """Stiffness of any kind, with or without a limit of the tension."""
    sound_speed = scale * draw(st.sampled_from([3.0, 10.0, 40.0]))
    stiffness = draw(st.sampled_from([{}, {"sound_speed": sound_speed}, {"bulk_modulus": 100.0 * scale**2}]))
    return {**stiffness, "gamma": draw(st.integers(1, 9)), **draw(st.sampled_from([{}, {"pressure_cutoff": -scale}]))}


@st.composite
def chosen_schemes(draw, scale, polymer):
    """Parameters of a scheme, and what of the config's ``time`` goes with it; it seldom does not suit the liquid."""
    kind = draw(st.sampled_from(["wcsph"] * 5 + ["auto"] + ["implicit"] * (1 if polymer else 4)))
    if kind == "wcsph":
        operators = draw(st.sampled_from(["consistent"] * (9 if polymer else 2) + ["standard"]))
        own = {"operators": operators, "artificial_viscosity": draw(st.sampled_from([0.0, 0.1]))}
        cfl = draw(st.sampled_from(["auto", 0.1, 0.25, 0.5]))
        return {"type": kind, **own, "equation_of_state": draw(equations_of_state(scale))}, {"cfl": cfl}
    if kind == "implicit":
        own = {"operators": {"order": draw(st.sampled_from([2, 4]))}, "largest_strain": draw(st.floats(0.1, 1.0))}
        return {"type": kind, **own}, {"tolerance": draw(st.sampled_from(["auto", 1e-6, 1e-3]))}
    return {"type": kind, "accuracy": draw(st.sampled_from(["fast", "balanced", "high"]))}, {}


@st.composite
def configs(draw):
    """Raw data of a config that is valid as far as each key goes; ``end`` is in units of length / velocity."""
    gap, density, scale = draw(scales), draw(scales), draw(scales)
    rows, columns = draw(st.integers(6, 12)), draw(st.integers(10, 24))
    reynolds = 10.0 ** draw(st.floats(-2.0, 4.0))
    polymer = draw(st.sampled_from([False, False, True]))
    liquid = {"type": "oldroyd_b", "relaxation_time": gap / scale * 10.0 ** draw(st.floats(-1.0, 1.0))}
    scheme, time = draw(chosen_schemes(scale, polymer))
    treatments = registry.names("walls") + (IMAGES if scheme["type"] == "implicit" else [])
    return {
        "scene": "channel",
        "fluid": {
            "density": density,
            "kinematic_viscosity": scale * gap / reynolds,
            **({"rheology": {**liquid, "solvent_fraction": draw(st.floats(0.05, 1.0))}} if polymer else {}),
        },
        "geometry": {"gap": gap, "length": columns * gap / rows},
        "walls": {
            "treatment": {"type": draw(st.sampled_from(treatments))},
            "bottom": draw(walls(scale, not polymer)),
            "top": draw(walls(scale, not polymer)),
        },
        "drive": {"acceleration": draw(st.sampled_from([0.0, 0.0, 1.0])) * scale**2 / gap * draw(speeds)},
        "initial": {
            "jitter": draw(st.floats(0.0, 0.4)),
            "seed": draw(st.integers(0, 9)),
            **draw(st.sampled_from([{}, {"state": "developed"}, {"state": "exact", "time": 0.1 * gap / scale}])),
        },
        "discretisation": {
            "particles_across": rows,
            "kernel": draw(st.sampled_from(registry.names("kernels"))),
            "smoothing_ratio": draw(st.sampled_from([0.8, 1.0, 1.0, 1.2, 1.5])),
            "precision": draw(st.sampled_from(["f64", "f64", "f32"])),
        },
        "scheme": scheme,
        "time": {"end": 10.0 * gap / scale, **time},
        "output": {"video": None},
        "runtime": {"threads": 1},
    }


def loaded(path, data):
    """The config of ``data``, which ends after the steps that it is to be run for."""
    path.write_text(json.dumps(data))  # JSON is YAML 1.2
    settings = config.load(path)
    resolved, _ = schemes.resolve(settings)
    if resolved.scheme.type == "wcsph":
        duration = 1.01 * STEPS["wcsph"] * estimates(settings)["time_step"]
        path.write_text(json.dumps({**data, "time": {**data["time"], "end": settings.start_time + duration}}))
    return config.load(path)


def run(settings):
    """Run some steps; raise DivergedError where the guard would, and fail for a number that is none."""
    channel = Channel.from_config(settings)
    runtime.start(settings.discretisation.precision, 1)
    resolved, _ = schemes.resolve(settings)
    scheme = schemes.build(resolved, channel, [settings.time.end], True)
    scheme.start(*start_values(channel, settings.initial))
    while scheme.steps < STEPS[resolved.scheme.type] and not scheme.finished:
        scheme.advance()
    snapshot = scheme.snapshot()
    Guard(channel).check(snapshot)
    for name in ("x", "y", "u", "v", "density", "pressure"):
        assert np.isfinite(getattr(snapshot, name)).all(), name
    heights = channel.probe_positions(4)[1]
    metrics = sample_metrics(channel, snapshot, (heights, channel.exact_velocity(heights, snapshot.t)))
    assert metrics["linf"] is not None
    balance = scheme.momentum_balance()
    assert all(value is None or math.isfinite(value) for value in balance.values())


def outcome(path, data):
    """Tell what comes of ``data``: done, or the name of the error; its message where that does not say where."""
    try:
        settings = loaded(path, data)
    except ConfigError as error:
        return "refused" if str(path) in str(error) else str(error)
    try:
        run(settings)
    except DivergedError as error:
        return "diverged" if "step" in str(error) else str(error)
    return "done"


def outcomes(examples, path):
    """Run ``examples`` configs; return how often each outcome came."""
    found = collections.Counter()

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck))
    @given(configs())
    def each(data):
        found[outcome(path, data)] += 1

    each()
    assert found.keys() <= {"done", "refused", "diverged"}
    return found


@pytest.mark.parametrize(("examples", "least"), [(4, 1), pytest.param(120, 50, marks=pytest.mark.slow)])
def test_any_config_runs_or_is_refused_or_stops_with_an_error(tmp_path, examples, least):
    assert outcomes(examples, tmp_path / "case.yaml")["done"] > least
