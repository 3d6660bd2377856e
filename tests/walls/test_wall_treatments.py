"""Where wall particles stand, and what each wall treatment gives them, against the formula that defines it."""

from types import SimpleNamespace

import numpy as np
import pytest
from rates import LINEAR_EOS, impose, slots_in_use

from tisph import registry
from tisph.schemes.wcsph.walls.virtual_image import SMALLEST_DETERMINANT

pytestmark = pytest.mark.taichi

DRIVEN = "drive.acceleration=0.02"
TREATMENTS = ("adami", "comoving_image", "consistent_image", "fixed_image", "virtual_image")


def walls_of(scheme):
    """Return mid-step position, velocity and pressure of the wall particles."""
    particles, now = scheme.particles, scheme.now
    used = slots_in_use(scheme)[particles.fluid :]
    fields = (particles.mid_position, particles.mid_velocity, particles.mid_pressure)
    return [field.to_numpy()[now][used] for field in fields]


def first_layers(places):
    """Tell which wall particles are near enough to the fluid that all treatments have fluid in reach."""
    return np.abs(places[:, 1] - 0.5) < 0.5 + 1.6 / 12


@pytest.mark.parametrize("treatment", ["comoving_image", "consistent_image"])
def test_every_particle_near_a_wall_has_its_image_at_every_step(make, treatment):
    # u_I = 2 u_W - u_F, for consistent images + d^2 (dU/dt - g)/nu, here with both terms
    oscillation = "walls.top={amplitude: 0.5, angular_frequency: 3.0, phase: sin}"
    scheme = make(f"walls.treatment.type={treatment}", DRIVEN, oscillation, "walls.bottom.velocity=-0.2", jitter=0.3)
    particles, bends, rebuilds = scheme.particles, treatment == "consistent_image", []
    for _ in range(30):
        scheme.advance()
        rebuilds.append(scheme.rebuilds)
        t, (images, image_velocities, image_pressures) = scheme.middle, walls_of(scheme)
        fields = (particles.mid_position, particles.mid_velocity, particles.mid_pressure)
        places, velocities, pressures = (field.to_numpy()[scheme.now][: particles.fluid] for field in fields)
        for wall, speed, acceleration in ((0.0, -0.2, 0.0), (1.0, 0.5 * np.sin(3.0 * t), 1.5 * np.cos(3.0 * t))):
            distance = np.abs(places[:, 1] - wall)
            near = np.flatnonzero(distance < scheme.lists.cutoff)
            mirrored = places[near] * [1, -1] + [0, 2 * wall]
            found = np.argmin(np.hypot(*(images - mirrored[:, None]).transpose(2, 0, 1)), axis=1)
            assert np.allclose(images[found], mirrored, atol=1e-14)
            bend = bends * distance[near] ** 2 * (acceleration - 0.02) / 0.01
            expected = np.stack([2 * speed - velocities[near, 0] + bend, -velocities[near, 1]], 1)
            # rounding of numbers below 1
            assert np.allclose(image_velocities[found], expected, atol=1e-13 if bends else 1e-14)
            assert bends or np.array_equal(image_pressures[found], pressures[near])
    assert 1 < len(set(rebuilds)) < 30


@pytest.mark.parametrize("rows", [25, 100])
def test_there_is_room_for_the_images_of_both_walls(rows):
    lattice = SimpleNamespace(rows=rows, columns=2 * rows, spacing=1 / rows)
    of_a_cell = rows / int(rows / 3.9)
    _, images = registry.load("walls", "comoving_image").treatments().channel.wall_slots(lattice, 3.9 / rows)
    assert 2 * of_a_cell * lattice.columns <= images <= 2 * rows * lattice.columns


def test_dummy_particles_move_with_their_wall(make):
    scheme = make("walls.treatment.type=adami", "walls.bottom.velocity=-0.3", "time.end=0.7")
    start = np.sort(walls_of(scheme)[0][:, 0]) % (1 / 12)
    assert np.allclose(start, start[0], atol=0.05 / 12)
    while not scheme.finished:
        scheme.advance()
    places = walls_of(scheme)[0]
    for below, speed in ((True, -0.3), (False, 0.5)):
        x = places[(places[:, 1] < 0) == below, 0]
        offset = (x - speed * scheme.time - 0.5 / 12) * 12
        assert np.allclose(offset, np.round(offset), atol=1e-9)


@pytest.mark.parametrize("treatment", ["comoving_image", "adami"])
def test_a_fluid_that_moves_with_both_walls_stays_as_it_is(make, treatment):
    moving = f"walls.treatment.type={treatment}", "initial.state=developed", "time.end=0.5"
    scheme = make(*moving, jitter=0.3, together=0.5)
    while not scheme.finished:
        scheme.advance()
    snapshot = scheme.snapshot()
    # differences of equal numbers vanish; what is left is rounding times the number of steps
    assert np.abs(snapshot.u - 0.5).max() < 1e-12
    assert np.abs(snapshot.v).max() < 1e-12


@pytest.mark.parametrize("treatment", ["fixed_image", "virtual_image"])
def test_extrapolation_continues_a_linear_profile(make, treatment):
    # on any arrangement (no particle nearer to the wall than the cap): U_W + a d is linear along every line through it
    scheme = make(LINEAR_EOS, f"walls.treatment.type={treatment}", "walls.bottom.velocity=-0.1", jitter=0.2)
    impose(scheme, lambda x, y: (-0.1 + 0.6 * y, 0 * y), lambda x, y: 0 * y)
    scheme.walls.refresh(scheme.now)
    places, velocities, _ = walls_of(scheme)
    near = first_layers(places)
    assert near.sum() == 2 * 2 * 12
    assert np.allclose(velocities[near, 0], -0.1 + 0.6 * places[near, 1], atol=1e-12)
    assert np.allclose(velocities[near, 1], 0.0, atol=1e-14)


def test_fixed_images_take_the_nearest_particle_and_cap_its_distance(make):
    # with least_distance 1 every particle nearer than a spacing counts as one spacing away
    scheme = make("walls.treatment={type: fixed_image, least_distance: 1.0}", jitter=0.3)
    velocity = lambda x, y: (np.sin(2 * np.pi * x) + y, 0.1 * y)  # noqa: E731 (different at every particle)
    x, y = impose(scheme, velocity, lambda x, y: 0 * y)
    scheme.walls.refresh(scheme.now)
    places, velocities, _ = walls_of(scheme)
    own = np.stack(velocity(x, y), 1)
    for place, found in zip(places[first_layers(places)], velocities[first_layers(places)], strict=True):
        apart = x - place[0] - np.round(x - place[0])
        i = int(np.argmin(np.hypot(apart, y - place[1])))
        wall, speed = (0.0, 0.0) if place[1] < 0 else (1.0, 0.5)
        ratio = 1.0 + abs(place[1] - wall) / max(abs(y[i] - wall), 1 / 12)
        assert np.allclose(found, own[i] + ratio * (np.array([speed, 0.0]) - own[i]), atol=1e-12)


def test_virtual_images_reflect_the_weighted_fit_at_their_mirror_point(make):
    # a velocity different at every particle: c0 of the fit c0 + c1 x + c2 y with the kernel of 0.75 cutoffs for weight
    scheme = make(LINEAR_EOS, "walls.treatment.type=virtual_image", jitter=0.3)
    field = lambda x, y: (np.sin(2 * np.pi * x) + y**2, np.cos(2 * np.pi * x) * y)  # noqa: E731
    x, y = impose(scheme, field, lambda x, y: 0.01 * np.sin(2 * np.pi * x))
    scheme.walls.refresh(scheme.now)
    places, velocities, pressures = walls_of(scheme)
    kernel = registry.load("kernels", "quintic_spline")
    radius, near = 0.75 * scheme.lists.cutoff, first_layers(places)
    for place, velocity, pressure in zip(places[near], velocities[near], pressures[near], strict=True):
        mirrored, speed = (-place[1], 0.0) if place[1] < 0 else (2.0 - place[1], 0.5)
        across, along = y - mirrored, x - place[0] - np.round(x - place[0])
        q = kernel.SUPPORT / radius * np.hypot(along, across)
        root = np.sqrt([kernel.value(one) if one < kernel.SUPPORT else 0.0 for one in q])
        values = np.stack([*field(x, y), 25.0 * 0.01 * np.sin(2 * np.pi * x)], 1)
        basis = np.stack([np.ones_like(x), along, across], 1)
        u, v, p = np.linalg.lstsq(root[:, None] * basis, root[:, None] * values, rcond=None)[0][0]
        assert np.allclose([*velocity, pressure], [2 * speed - u, -v, p], atol=1e-12)


def test_dummy_particles_carry_the_kernel_averages_of_the_fluid(make):
    # fields different at every particle, whose averages are those of no other smoothing length
    scheme = make(LINEAR_EOS, "walls.treatment.type=adami", jitter=0.3)
    field = lambda x, y: (np.sin(2 * np.pi * x) + y**2, np.cos(2 * np.pi * x) * y)  # noqa: E731
    x, y = impose(scheme, field, lambda x, y: 0.01 * np.sin(2 * np.pi * x))
    scheme.walls.refresh(scheme.now)
    kernel, places = registry.load("kernels", "quintic_spline"), walls_of(scheme)[0]
    near, values = first_layers(places), np.stack([*field(x, y), 25.0 * 0.01 * np.sin(2 * np.pi * x)], 1)
    for place, *found in zip(*(part[near] for part in walls_of(scheme)), strict=True):
        along = x - place[0] - np.round(x - place[0])
        q = kernel.SUPPORT / scheme.lists.cutoff * np.hypot(along, y - place[1])
        u, v, p = np.average(values, axis=0, weights=[kernel.value(one) if one < kernel.SUPPORT else 0.0 for one in q])
        speed = 0.0 if place[1] < 0 else 0.5
        assert np.allclose([*found[0], found[1]], [2 * speed - u, -v, p], atol=1e-12)


@pytest.mark.parametrize(("part", "fitted"), [(1.25, True), (0.8, False)])
def test_virtual_images_fit_what_is_not_on_a_line(make, part, fitted):
    # three particles around a mirror point, (-r, 0), (r/2, 0) and (0, e) from it, whose moments have a determinant of
    # w1 w2 w3 (1.5 r e)^2: a fit gives the value of u = x there, 0, and an average does not
    scheme = make(LINEAR_EOS, "walls.treatment.type=virtual_image", "walls.bottom.velocity=-0.1")
    k = next(k for k in slots_in_use(scheme) if scheme.particles.mid_position[scheme.now, k].y < 0.0)
    kernel, radius = registry.load("kernels", "quintic_spline"), 0.75 * scheme.lists.cutoff
    weights = [kernel.value(kernel.SUPPORT * q) for q in (0.6, 0.3, 0.0)]
    height = np.sqrt(part * SMALLEST_DETERMINANT * sum(weights) ** 3 / np.prod(weights)) / (1.5 * 0.6)
    places = scheme.particles.mid_position.to_numpy()
    offsets = radius * np.array([[-0.6, 0.0], [0.3, 0.0], [0.0, height]])
    places[scheme.now, :3] = places[scheme.now, k] * [1, -1] + offsets
    scheme.particles.mid_position.from_numpy(places)
    impose(scheme, lambda x, y: (x - places[scheme.now, k, 0], 0 * y), lambda x, y: 0 * y)
    scheme.lists.count[k] = 3
    for n in range(3):
        scheme.lists.table[k, n] = n
    scheme.walls.refresh(scheme.now)
    weights[2] = kernel.value(kernel.SUPPORT * height)
    average = np.average(offsets[:, 0], weights=weights)
    assert average > 0.01
    found = scheme.particles.mid_velocity.to_numpy()[scheme.now, k, 0]
    # rounding over the determinant
    assert found == pytest.approx(2 * -0.1 - (0.0 if fitted else average), abs=1e-9)


@pytest.mark.parametrize("treatment", ["adami", "fixed_image", "virtual_image"])
def test_wall_particles_without_fluid_in_reach_move_with_their_wall(make, treatment):
    scheme = make(LINEAR_EOS, f"walls.treatment.type={treatment}", "walls.bottom.velocity=-0.1")
    impose(scheme, lambda x, y: (1.0 + x, 1.0 + y), lambda x, y: 1.0 + 0 * y)
    scheme.lists.count.fill(0)
    scheme.walls.refresh(scheme.now)
    places, velocities, pressures = walls_of(scheme)
    assert np.array_equal(velocities[:, 0], np.where(places[:, 1] < 0, -0.1, 0.5))
    assert not velocities[:, 1].any()
    assert not pressures.any()


@pytest.mark.parametrize("treatment", TREATMENTS)
def test_walls_and_drive_balance_the_momentum_of_the_fluid(make, treatment):
    # closure counts what is not exchanged in pairs; on a lattice only the shear of its rows disturbs the symmetry
    scheme = make(f"walls.treatment.type={treatment}", DRIVEN, "walls.bottom.velocity=-0.2", "time.end=2.0")
    while not scheme.finished:
        scheme.advance()
    balance = scheme.momentum_balance()
    assert balance["drive"] == pytest.approx(0.02 * 2.0, rel=1e-12)
    snapshot = scheme.snapshot()
    assert balance["change"] == pytest.approx(snapshot.u.sum() / 144, rel=1e-12)
    assert balance["bottom_wall"] < 0 < balance["top_wall"]
    assert balance["closure"] < 2e-3
