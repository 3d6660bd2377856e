"""Scheme auto: what it takes, and why; what check says of the implicit scheme."""

from pathlib import Path

import pytest

from tisph import schemes
from tisph.config import load
from tisph.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"


@pytest.fixture
def resolved(case):
    """Return config and reason that the scheme of the case with overrides stands for."""

    def run(*overrides):
        return schemes.resolve(case(*overrides))

    return run


def test_a_config_without_a_scheme_gets_the_implicit_one_at_balanced_accuracy(resolved):
    assert resolved("time.tolerance=1e-3")[0].time.tolerance == 1e-3  # goes before that of the scheme
    config, reason = resolved()
    assert (config.scheme.type, config.scheme.operators.order) == ("implicit", 4)
    assert reason.startswith("implicit, order 4: balanced accuracy")


STEPS = [  # as docs/theory/implicit.md and two-dimensional.md say them
    ("couette", (), "fast", "tolerance 0.0003 and strain 1.5"),
    ("couette", (), "balanced", "tolerance 3e-05 and strain 0.7"),
    ("couette", (), "high", "tolerance 3e-07 and strain 0.5"),
    ("couette", (POLYMER,), "fast", "tolerance 0.0001 and strain 1.5"),
    ("couette", (POLYMER,), "balanced", "tolerance 1e-05 and strain 0.7"),
    ("couette", (POLYMER,), "high", "tolerance 3e-07 and strain 0.5"),
    ("taylor_green", (), "fast", "tolerance 9.6e-06 and Courant number 2"),
    ("taylor_green", (), "balanced", "tolerance 9.6e-07 and Courant number 1"),
    ("taylor_green", (), "high", "tolerance 3e-07 and Courant number 0.15"),
]


@pytest.mark.parametrize(("name", "liquid", "accuracy", "steps"), STEPS)
def test_the_steps_are_those_of_the_documentation(name, liquid, accuracy, steps):
    chosen = (*liquid, f"scheme={{type: auto, accuracy: {accuracy}}}")
    _, reason = schemes.resolve(load(CONFIGS / f"{name}.yaml", chosen))
    assert reason.endswith(f"accuracy, {steps} a step")


def test_balanced_steps_of_two_dimensional_flow_follow_the_error_of_the_spacing():
    def error_ratio(name, *overrides):
        return schemes.resolve(load(CONFIGS / f"{name}.yaml", overrides))[0].scheme.error_ratio

    assert error_ratio("taylor_green") == error_ratio("cylinder_in_stream") == 2 / 3
    chosen = "time.tolerance=1e-6", "scheme={type: auto, accuracy: fast}", "scheme={type: auto, accuracy: high}"
    assert [error_ratio("taylor_green", override) for override in chosen] == [None, None, None]
    assert error_ratio("free_cylinder") is error_ratio("couette") is None


@pytest.mark.parametrize(("liquid", "tolerance"), [((), 3e-5), ((POLYMER,), 1e-5)])
def test_steps_of_free_bodies_do_not_depend_on_particles_across(liquid, tolerance):
    """As docs/theory/two-dimensional.md says: errors of the spacing are those of the bodies."""
    for number in (32, 64):
        finer = (f"discretisation.particles_across={number}", "initial.state=rest", *liquid)
        config, _ = schemes.resolve(load(CONFIGS / "free_cylinder.yaml", finer))
        assert config.time.tolerance == tolerance


@pytest.mark.parametrize(
    ("override", "reason"),
    [
        ("walls.treatment={type: adami}", "no adami walls"),
        ("walls.treatment={type: fixed_image}", "no fixed_image walls"),
        ("time.cfl=0.2", "time.cfl gives a Courant number"),
    ],
)
def test_where_the_implicit_scheme_cannot_serve_the_explicit_one_is_taken(resolved, override, reason):
    config, words = resolved(override)
    assert config.scheme.type == "wcsph"
    assert words.startswith("wcsph, since")
    assert reason in words
    with pytest.raises(
        ConfigError, match=r"time\.tolerance = 1e-05: is for scheme implicit, which cannot be taken here"
    ):
        resolved(override, "time.tolerance=1e-5")


def test_a_given_scheme_is_kept(resolved):
    assert resolved("scheme={operators: standard}")[0].scheme.operators == "standard"  # that is wcsph, too
    config, reason = resolved("scheme={type: wcsph}")
    assert (config.scheme.type, reason) == ("wcsph", "wcsph")
    with pytest.raises(ConfigError, match=r"time\.tolerance = 1e-05: is for scheme implicit"):
        resolved("scheme={type: wcsph}", "time.tolerance=1e-5")
