"""Wall shear from the particles near a wall: exact where the profile is one that the fit has, and its orders."""

from functools import partial

import numpy as np
import pytest
from polymer_laws import oldroyd_b
from report_scene import unit_channel

from tisph.config import load
from tisph.geometry.motion import WallMotion
from tisph.measures.channel import wall_shear, wall_shear_error, wall_velocity
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot
from tisph.studies import suites, walls
from tisph.studies.expressions import merged
from tisph.studies.store import config_text

NEWTONIAN = ("poiseuille", "poiseuille_steady", "backflow", "oscillating_slow", "oscillating_fast", "stopped")
VISCOELASTIC = ("oldroyd_b_couette_explicit", "oldroyd_b_poiseuille_explicit")
CONFIGS = {
    **{name: walls.config_of((name, "consistent_image", "lattice"), 50) for name in ("couette", "oscillating")},
    **{name: suites.config_of("channel", name) for name in NEWTONIAN},
    **{name: suites.config_of("viscoelastic", name) for name in VISCOELASTIC},
}
TIMES = [(name, t) for name, config in CONFIGS.items() for t in config["time"]["samples"]]
make_channel = partial(unit_channel, 12)


def snapshot_of(channel, velocity, stress=None, t=1.8, jitter=0.2):
    """Jittered particles with ``velocity(y)`` and, where given, S_xy = ``stress(y)``."""
    x, y = channel.jittered(3, jitter)
    at_rest = np.zeros_like(x)
    stresses = {"stress_xx": at_rest, "stress_xy": stress(y), "stress_yy": at_rest} if stress else {}
    return Snapshot(t, 10, x, y, velocity(y), at_rest, at_rest + channel.density, at_rest, **stresses)


@pytest.mark.parametrize("walls", [(0.0, 0.5), (0.3, -0.2)])
def test_quartic_profiles_have_their_slopes(walls):
    """Any curvature at the walls, as a body acceleration or an accelerating wall gives."""
    bottom, top = walls
    channel = make_channel(bottom=WallMotion(bottom), top=WallMotion(top))

    def profile(y):
        return bottom + (top - bottom) * y + 0.7 * y * (1 - y) * (1 + y + 3 * y * y)

    slopes = (top - bottom + 0.7, top - bottom - 0.7 * 5)
    # viscosity 0.02 * slope; rounding 1e-16 times the condition number of the four columns, some 1e3
    expected = [0.02 * slope for slope in slopes]
    assert wall_shear(channel, snapshot_of(channel, profile)) == pytest.approx(expected, abs=1e-13)


def test_a_stress_controlled_wall_has_the_velocity_of_its_next_particles():
    channel = make_channel()
    snapshot = snapshot_of(channel, lambda y: 0.3 + y * (1.0 + y * (-2.0 + y * (1.5 - 0.4 * y))))
    # rounding times the condition number of the five columns, some 1e4
    found = [wall_velocity(channel, side, snapshot) for side in (0, 1)]
    assert found == pytest.approx([0.3, 0.3 + 1.0 - 2.0 + 1.5 - 0.4], abs=1e-12)


def test_the_slip_is_relative_to_the_wall_at_that_time():
    """Fluid that moves as one with an oscillating wall has no shear there, at any phase."""
    motion = WallMotion(0.4, -0.3, angular_frequency=2.0)
    channel = make_channel(bottom=motion, top=motion)
    for t in (0.3, 1.7):
        velocity = float(motion.velocity(t))
        snapshot = snapshot_of(channel, lambda y, u=velocity: np.full_like(y, u), t=t)
        assert wall_shear(channel, snapshot) == pytest.approx([0.0, 0.0], abs=1e-14)


def test_solvent_and_polymer_add_up():
    """mu_s du/dy with the solvent's share of the viscosity, plus S_xy at the wall, where no particle is."""
    channel = make_channel(**oldroyd_b(1.0, 0.25))
    snapshot = snapshot_of(channel, lambda y: 0.5 * y, lambda y: 0.3 - 0.8 * y + 1.4 * y**2)
    solvent = 2.0 * 0.01 * 0.25 * 0.5
    # rounding times the condition number of the columns, some 1e3
    assert wall_shear(channel, snapshot) == pytest.approx([solvent + 0.3, solvent + 0.9], abs=1e-12)


def test_the_weights_choose_among_fits_that_are_not_exact():
    """(1 - f)^2 (1 + 2 f) at the part f of five spacings: what is left is orthogonal to all powers with that weight."""
    channel, random = make_channel(**oldroyd_b(1.0, 0.25)), np.random.default_rng(0)
    snapshot = snapshot_of(channel, lambda y: random.uniform(size=y.size), lambda y: random.uniform(size=y.size))
    part = snapshot.y[snapshot.y < 5 / 12] / (5 / 12)
    weight, found = (1 - part) ** 2 * (1 + 2 * part), []
    for powers, values in (([1, 2, 3, 4], snapshot.u), ([0, 1, 2], snapshot.stress_xy)):
        basis = part[:, None] ** np.array(powers)
        moments = basis.T @ (weight[:, None] * basis)
        found.append(np.linalg.solve(moments, basis.T @ (weight * values[snapshot.y < 5 / 12]))[0])
    expected = 2.0 * 0.01 * 0.25 * found[0] / (5 / 12) + found[1]
    assert wall_shear(channel, snapshot)[0] == pytest.approx(expected, rel=1e-9)  # normal equations: condition 1e6


def shear_errors(name, t, jitter, folder):
    errors = []
    for rows in (25, 50, 100):
        path = folder / "flow.yaml"
        size = {"discretisation": {"particles_across": rows}, "geometry": {"length": 0.4}}
        path.write_text(config_text("flow", merged(CONFIGS[name], size)), encoding="utf-8")
        channel = Channel.from_config(load(path))
        stress = channel.polymer and (lambda y, flow=channel: flow.exact_polymer_stress(y, t)[1])
        snapshot = snapshot_of(channel, lambda y, flow=channel: flow.exact_velocity(y, t), stress, t, jitter)
        measured, exact = wall_shear(channel, snapshot), map(float, channel.exact_wall_shear(t))
        keys = ("wall_shear_bottom", "wall_shear_top")
        sample = dict(zip((*keys, *(f"{key}_exact" for key in keys)), (*measured, *exact), strict=True))
        errors.append(wall_shear_error(sample))
    return errors


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize(("name", "t"), TIMES)
def test_exact_fields_give_the_exact_stress_in_every_flow(name, t, jitter, tmp_path):
    """What the fit adds at 50 across is a tenth of the 1 % to which the flows are held, and of fourth order."""
    errors = shear_errors(name, t, jitter, tmp_path)
    assert errors[1] <= 1e-3
    assert errors[2] <= 1e-3 / 16


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize(
    ("name", "power"),
    [("couette", 4), ("poiseuille", 4), ("backflow", 4), ("oscillating_slow", 4), ("oldroyd_b_couette_explicit", 3)],
)
def test_the_error_of_the_fit_falls_with_its_power_of_the_spacing(name, power, jitter, tmp_path):
    """Where 25 across resolve the layer at the wall: solvent and polymer, with and without curvature at the wall."""
    errors = shear_errors(name, CONFIGS[name]["time"]["end"], jitter, tmp_path)
    assert np.log2(errors[0] / errors[2]) / 2 > power - 0.3  # what higher orders take at 25 rows


def test_the_error_is_relative_to_the_larger_stress_if_known():
    """The flow has not reached the bottom wall: half of its stress is missing, and nothing is lost by that."""
    exact = {"wall_shear_bottom_exact": 2e-6, "wall_shear_top_exact": -0.02}
    sample = {"wall_shear_bottom": 1e-6, "wall_shear_top": -0.0198, **exact}
    assert wall_shear_error(sample) == pytest.approx(0.01, rel=1e-12)
    assert wall_shear_error({**sample, "wall_shear_bottom": 0.001}) == pytest.approx(0.0499, rel=1e-12)
    for missing in ("wall_shear_top", "wall_shear_bottom_exact"):  # of a flow that went wrong, of a wall that jumps
        assert wall_shear_error({**sample, missing: None}) is None
