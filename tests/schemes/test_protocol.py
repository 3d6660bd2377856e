"""Objects that schemes build have what the simulation asks of them, under the names and arguments of the protocol."""

import inspect
from pathlib import Path

import pytest

from tisph import runtime, scenes, schemes
from tisph.config import load
from tisph.schemes._protocol import Scheme

pytestmark = pytest.mark.taichi

CONFIGS = Path(__file__).parents[2] / "configs"
BUILT = [
    ("couette", "scheme={type: wcsph}"),
    ("couette", "scheme={type: implicit}"),
    ("taylor_green", "scheme={type: implicit}"),
    ("taylor_green", "scheme={type: wcsph}"),
    ("circular_couette", "scheme={type: implicit}"),
]


def members(protocol):
    """Public members of a protocol and of those that it extends, by name."""
    found = {}
    for cls in protocol.__mro__:
        names = {*vars(cls), *inspect.get_annotations(cls)} if getattr(cls, "_is_protocol", False) else ()
        found |= {name: getattr(protocol, name, None) for name in names if not name.startswith("_")}
    return found


def arguments(function):
    return [name.lstrip("_") for name in inspect.signature(function).parameters if name != "self"]


@pytest.mark.parametrize(("name", "override"), BUILT)
def test_schemes_have_what_the_simulation_asks_of_them(name, override):
    config = load(CONFIGS / f"{name}.yaml", [override, "discretisation.particles_across=24"])
    runtime.start(config.discretisation.precision, 1)
    scene = scenes.of(config).in_flow_frame()
    scheme = schemes.build(config, scene, [config.time.end], serial=True)
    for member, asked in members(Scheme).items():
        if member == "finished":  # from the start of the steps on
            continue
        given = getattr(scheme, member)
        if inspect.isfunction(asked):
            assert given.__doc__, member
            assert arguments(given) == arguments(asked), member
