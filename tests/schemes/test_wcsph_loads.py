"""Force and torque on bodies as the explicit scheme reads them of particles, in flows for which its fits are exact."""

import numpy as np
import pytest
from flows import flow_text

from tisph import config, scenes
from tisph.schemes.wcsph._bodies import Loads
from tisph.simulation.state import start_values
from tisph.snapshot import Snapshot

CELL = flow_text("cylinder_in_a_cell")


@pytest.fixture
def lattice(tmp_path):
    """The scene of a cylinder at rest in the middle of a cell, and its particles."""
    (tmp_path / "case.yaml").write_text(CELL)
    settings = config.load(tmp_path / "case.yaml")
    scene = scenes.of(settings)
    return scene, start_values(scene, settings.initial)[0]


def loads(scene, places, u, v, pressure):
    """Force and torque (3,) of all, and of the pressure, from fields as functions of x and y from the centre."""
    x, y = places.T
    fields = [np.broadcast_to(np.asarray(field(x - 0.5, y - 0.5), dtype=float), x.shape) for field in (u, v, pressure)]
    density = np.full(x.shape, scene.density)
    return Loads(scene).of(Snapshot(0.0, 0, x, y, fields[0], fields[1], density, fields[2]))[:, 0]


def nothing(x, y):
    return 0.0 * x


def test_a_falling_pressure_pushes_by_its_slope_times_the_area(lattice):
    every, pressed = loads(*lattice, nothing, nothing, lambda x, y: 7.0 - 3.0 * x + 5.0 * y)
    area = np.pi * 0.2**2
    # the sum over 38 points around a circle is exact for this, but for rounding
    assert pressed == pytest.approx([3.0 * area, -5.0 * area, 0.0, 0.0], abs=1e-9)
    assert every == pytest.approx(pressed, abs=1e-9)


def test_fluid_rotating_faster_outside_rotates_the_body_along(lattice):
    beyond = lambda x, y: x * x + y * y - 0.2**2  # noqa: E731 (of the speed over the distance)
    fields = (lambda x, y: -beyond(x, y) * y, lambda x, y: beyond(x, y) * x, nothing)
    every, pressed = loads(*lattice, *fields)
    stress = 20.0 * 2.0 * 0.2**2  # dynamic viscosity times the slope of the speed less that of a solid
    assert every == pytest.approx([0.0, 0.0, stress * 2.0 * np.pi * 0.2**2, 0.0], abs=1e-9)
    assert pressed == pytest.approx([0.0] * 4, abs=1e-12)
