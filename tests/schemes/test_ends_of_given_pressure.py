"""Channels that the pressures of their two ends drive, against exact start-up between parallel walls."""

import numpy as np
import pytest
from finished_run import finished
from flows import flow_config

from tisph import scenes
from tisph.config.loader import loaded

pytestmark = pytest.mark.taichi

DRIVEN = flow_config("channel_between_pressures")

OLDROYD_B = {"type": "oldroyd_b", "relaxation_time": 0.5, "solvent_fraction": 0.5}


def exact(snapshot, rheology=None):
    """Velocity of the same fluid in the periodic channel that an acceleration drives."""
    fluid = {**DRIVEN["fluid"], **({"rheology": rheology} if rheology else {})}
    others = {key: value for key, value in DRIVEN.items() if key != "ends"}
    scene = scenes.of(loaded({**others, "fluid": fluid, "drive": {"acceleration": 1.2}}, {}))
    return scene.exact("u", snapshot.x, snapshot.y, snapshot.t)


@pytest.mark.parametrize(
    "rheology", [pytest.param(None, id="Newtonian"), pytest.param(OLDROYD_B, id="Oldroyd-B", marks=pytest.mark.slow)]
)
def test_start_up_is_that_between_parallel_walls(rheology):
    """The bound of the issue that brought this feature; both ends have the given pressures and one flow rate."""
    fluid = {**DRIVEN["fluid"], **({"rheology": rheology} if rheology else {})}
    _, snapshot, found = finished({**DRIVEN, "fluid": fluid})
    error = np.hypot(snapshot.u - exact(snapshot, rheology), snapshot.v)
    assert np.sqrt(np.mean(error**2)) < 1e-4
    assert found["pressure_drop"] == pytest.approx(4.8, rel=1e-3)
    assert found["mass_imbalance"] == pytest.approx(0.0, abs=1e-4)
    assert snapshot.passages.sum() > 0
    assert found["backflow"] == 0.0


def test_steady_flow_goes_on_as_it_is():
    """A parabola, at either end the higher pressure, without inertia, too: exact but for residuals and steps."""
    for changes in ({"initial": {"state": "developed"}}, {"fluid": {**DRIVEN["fluid"], "inertia": False}}):
        ends = {"left": {"type": "outlet"}, "right": {"pressure": 4.8}}
        _, snapshot, _ = finished({**DRIVEN, **changes, "ends": ends, "time": {"end": 0.3}})
        assert np.abs(snapshot.u + 6.0 * snapshot.y * (1.0 - snapshot.y)).max() < 1e-4
        assert np.abs(snapshot.v).max() < 1e-4


def test_a_cylinder_between_two_pressures_bears_what_the_walls_do_not():
    """Without inertia: pressures times the gap are the drag and the friction on both walls."""
    config = {**DRIVEN, "fluid": {**DRIVEN["fluid"], "inertia": False}, "time": {"end": 0.05}}
    config |= {"bodies": [{"type": "circle", "centre": [1.0, 0.5], "radius": 0.2}]}
    _, _, found = finished(config)
    assert found["drag"] + found["drag_bottom"] + found["drag_top"] == pytest.approx(4.8, rel=2e-2)
