"""Wall treatments: where wall particles stand and what they carry."""

from types import SimpleNamespace

import numpy as np
import pytest
from rates import slots_in_use

from tisph import registry

pytestmark = pytest.mark.taichi


def middle(scheme):
    """Return mid-step position, velocity and pressure of fluid and of wall particles."""
    particles, now = scheme.particles, scheme.now
    fluid, walls = particles.fluid, slots_in_use(scheme)[particles.fluid :]
    fields = (particles.mid_position, particles.mid_velocity, particles.mid_pressure)
    arrays = [field.to_numpy()[now] for field in fields]
    return [array[:fluid] for array in arrays], [array[walls] for array in arrays]


def test_every_particle_near_a_wall_has_its_mirror_image(make):
    scheme = make("walls.bottom.velocity=-0.3", "time.end=0.5", jitter=0.3)
    for _ in range(20):
        scheme.advance()
    (places, velocities, pressures), (images, image_velocities, image_pressures) = middle(scheme)
    for wall, speed in ((0.0, -0.3), (1.0, 0.5)):
        near = np.flatnonzero(np.abs(places[:, 1] - wall) < scheme.lists.cutoff)
        for i in near:
            mirrored = [places[i, 0], 2 * wall - places[i, 1]]
            k = int(np.argmin(np.hypot(*(images - mirrored).T)))
            assert np.allclose(images[k], mirrored, atol=1e-14)
            expected = [2 * speed - velocities[i, 0], -velocities[i, 1]]
            assert np.allclose(image_velocities[k], expected, atol=1e-14)
            assert image_pressures[k] == pressures[i]


@pytest.mark.parametrize("rows", [25, 100])
def test_there_is_room_for_the_images_of_both_walls(rows):
    lattice = SimpleNamespace(rows=rows, columns=2 * rows, spacing=1 / rows)
    of_a_cell = rows / int(rows / 3.9)
    _, images = registry.load("walls", "comoving_image").treatments().channel.wall_slots(lattice, 3.9 / rows)
    assert 2 * of_a_cell * lattice.columns <= images <= 2 * rows * lattice.columns


def test_images_follow_their_particles_between_two_builds(make):
    scheme = make("initial.state=developed", "time.end=1.0")
    scheme.advance()
    rebuilds = scheme.rebuilds
    scheme.advance()
    assert scheme.rebuilds == rebuilds
    (places, _, _), (images, _, _) = middle(scheme)
    below = images[images[:, 1] < 0]
    lowest = places[places[:, 1] < 1 / 12]
    for place in lowest:
        assert np.min(np.hypot(*(below - [place[0], -place[1]]).T)) < 1e-14


def test_dummy_particles_reflect_a_uniform_flow_about_the_wall(make):
    # Shepard averages of a constant are that constant: u_w = 2 U_W - u_f where fluid is in reach
    scheme = make("walls.treatment.type=adami", jitter=0.2, velocity=lambda x, y: np.stack([0 * x + 0.2, 0 * y], 1))
    _, (places, velocities, _) = middle(scheme)
    first = np.abs(places[:, 1] - 0.5) < 0.5 + 1 / 12
    expected = np.where(places[first, 1] < 0, -0.2, 2 * 0.5 - 0.2)
    # the particles have taken half a step from the uniform state: dt nu lap u / 2, below 0.03 here
    assert np.allclose(velocities[first, 0], expected, atol=0.03)


def test_dummy_particles_move_with_their_wall(make):
    scheme = make("walls.treatment.type=adami", "walls.bottom.velocity=-0.3", "time.end=0.7")
    start = np.sort(middle(scheme)[1][0][:, 0].reshape(-1)) % (1 / 12)
    assert np.allclose(start, start[0], atol=0.05 / 12)
    while not scheme.finished:
        scheme.advance()
    places = middle(scheme)[1][0]
    for below, speed in ((True, -0.3), (False, 0.5)):
        x = places[(places[:, 1] < 0) == below, 0]
        offset = (x - speed * scheme.time - 0.5 / 12) * 12
        assert np.allclose(offset, np.round(offset), atol=1e-9)


@pytest.mark.parametrize("treatment", ["comoving_image", "adami"])
def test_a_fluid_that_moves_with_both_walls_stays_as_it_is(make, treatment):
    scheme = make(
        f"walls.treatment.type={treatment}",
        "initial.state=developed",
        "time.end=0.5",
        jitter=0.3,
        together=0.5,
    )
    while not scheme.finished:
        scheme.advance()
    snapshot = scheme.snapshot()
    # differences of equal numbers vanish; what is left is rounding times the number of steps
    assert np.abs(snapshot.u - 0.5).max() < 1e-12
    assert np.abs(snapshot.v).max() < 1e-12
