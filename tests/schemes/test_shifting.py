"""The shift towards an even arrangement: what an explicit step can follow, and what keeps particles off the walls."""

import numpy as np
import pytest
from rates import RatesOf

from tisph import registry
from tisph.runtime import view
from tisph.schemes.wcsph._time_step import SHIFT, shift_speed, stiffness

pytestmark = pytest.mark.taichi

KERNELS = ["quintic_spline", "wendland_c2"]


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("cfl", ["auto", 0.1, 0.25, 0.5])
@pytest.mark.parametrize("diffusion", [1e-3, 0.02, 1.0, 50.0])
def test_the_longest_step_shifts_as_much_whatever_binds_it(kernel, cfl, diffusion):
    """3/8 of the stiffest wave; no more at a larger CFL number, less at a smaller."""
    module, length, sound = registry.load("kernels", kernel), 0.1, 2.0
    speed = shift_speed(module, 1.3, sound, cfl, diffusion)
    number = 0.25 if cfl in ("auto", 0.1) else cfl
    step = min(number * length / sound, 0.125 * length / diffusion)
    # h sum V grad W, of which a step takes away speed * step / h * stiffness
    assert speed * step / length * stiffness(module, 1.3) == pytest.approx(0.375, rel=1e-14)


@pytest.mark.parametrize(("kernel", "ratio"), list(zip(KERNELS, (1.0, 1.5), strict=True)))
def test_no_small_displacement_of_the_lattice_relaxes_faster_than_the_stiffest_wave(make, kernel, ratio):
    # linear in the displacements xi, and symmetric: 0 <= -(xi, du) <= SHIFT c/h (xi, xi), nearly reached by waves
    overrides = f"discretisation.kernel={kernel}", f"discretisation.smoothing_ratio={ratio}", "geometry.length=2.0"
    scheme = make("discretisation.particles_across=24", *overrides)
    rate = SHIFT * scheme.sound_speed / (ratio / 24)
    now, fluid, spacing = scheme.now, scheme.particles.fluid, 1 / 24
    lattice = scheme.particles.mid_position.to_numpy()
    x, y = lattice[now, :fluid].T
    inside = np.abs(y - 0.5) < 0.3
    random = np.random.default_rng(0).uniform(-1, 1, (fluid, 2))
    waves = [np.stack([np.sin(np.pi * k / 24 * x / spacing), 0 * x], 1) for k in range(1, 25)]
    rates, largest = RatesOf(scheme), 0.0
    for shape in [random * inside[:, None], *waves]:
        displaced = 1e-4 * spacing * shape
        places = lattice.copy()
        places[now, :fluid] += displaced
        scheme.particles.mid_position.from_numpy(places)
        relaxed = -np.sum(displaced[inside] * rates.arrays()[2][inside])
        found = relaxed / np.sum(displaced[inside] ** 2)
        largest = max(largest, found)
        # the table of weights is piecewise linear: its slopes, unlike its values, are off by 1 %
        assert -0.01 * rate < found < 1.02 * rate
    assert largest > 0.95 * rate


def test_the_implicit_scheme_tells_that_points_moved_however_little(make):
    # discs of 0.9 spacings that overlap by 4e-4 spacings, on a lattice that has no overlap: one sweep is enough
    scheme = make("scheme={type: implicit}")
    scheme.particles.arrange(0.0)
    assert not scheme.particles.shifting.shift()
    place = view(scheme.points.position)
    place[66, 0] += (0.1 + 4e-4) / 12
    before = place[:144].copy()
    assert scheme.particles.shifting.shift()
    moved = 12 * (view(scheme.points.position)[:144] - before)
    assert np.flatnonzero(np.abs(moved).max(axis=1) > 1e-12).tolist() == [66, 67]
    assert moved[66:68, 0] == pytest.approx([-2e-4, 2e-4], rel=1e-9)  # half of the overlap each


def test_no_particle_crosses_a_wall_at_high_cell_reynolds_number(make):
    # U dx/nu = 83; shifted by 2 U h sum V grad W instead of c h sum V grad W, a particle crosses after 780 steps
    overrides = "fluid.kinematic_viscosity=5e-4", "geometry.length=2.0", "time.end=100.0"
    scheme = make(*overrides, jitter=0.3)
    nearest = np.inf
    for _ in range(1500):
        scheme.advance()
        if scheme.steps % 20 == 0:
            y = scheme.snapshot().y * 12
            nearest = min(nearest, y.min(), 12 - y.max())
    # a particle starts 0.2 spacings from the wall at least; it is not pushed closer by more than a twentieth
    assert nearest > 0.15
    assert np.abs(scheme.snapshot().v).max() < 0.1 * 0.5
