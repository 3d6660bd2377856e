"""What a config says of a liquid's rheology, and what is refused of it."""

import pytest

from tisph.errors import ConfigError

RHEOLOGIES = {
    "giesekus": "{type: giesekus, relaxation_time: 1.0, solvent_fraction: 0.5, mobility: 0.2}",
    "phan_thien_tanner": "{type: phan_thien_tanner, relaxation_time: 1.0, solvent_fraction: 0.5, extensibility: 0.1}",
    "fene_p": "{type: fene_p, relaxation_time: 1.0, solvent_fraction: 0.5, maximum_extension: 100.0}",
}


def refusal(case, *overrides):
    with pytest.raises(ConfigError) as caught:
        case(*overrides)
    return str(caught.value)


@pytest.mark.parametrize("scheme", ["auto", "implicit", "wcsph"])
@pytest.mark.parametrize("name", RHEOLOGIES)
def test_no_scheme_runs_a_liquid_that_it_does_not_have(case, name, scheme):
    text = refusal(case, f"fluid.rheology={RHEOLOGIES[name]}", f"scheme={{type: {scheme}}}")
    assert "scheme.type" in text
    assert f"no {name} liquid" in text


@pytest.mark.parametrize(
    ("name", "change", "expected"),
    [
        ("giesekus", "mobility=1.1", "must be at most 1"),
        ("giesekus", "mobility=-0.1", "must be at least 0"),
        ("giesekus", "solvent_fraction=0", "must be greater than 0 and at most 1"),
        ("phan_thien_tanner", "extensibility=2", "must be at most 1"),
        ("phan_thien_tanner", "form=cubic", "must be 'linear' or 'exponential'"),
        ("fene_p", "maximum_extension=3", "must be greater than 3"),
        ("fene_p", "relaxation_time=0", "must be greater than 0"),
    ],
)
def test_ranges(case, name, change, expected):
    text = refusal(case, f"fluid.rheology={RHEOLOGIES[name]}", f"fluid.rheology.{change}")
    assert f"fluid.rheology.{change.partition('=')[0]}" in text
    assert expected in text
