"""Coordinates, time levels and walls of two-dimensional flow: each number that they return against Cartesian tensors.

Velocities and stresses are given as polynomials of x and s = r^2/2, made to vectors and tensors in space, and
differentiated there in the complex plane, which leaves rounding alone.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from case_from_text import started
from flows import flow_text

from tisph import scenes
from tisph.config import load
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.runtime import real, ti, view
from tisph.schemes._local_newton import SMALL
from tisph.schemes.implicit.planar.time_levels import VELOCITIES, PlanarCoordinates
from tisph.schemes.implicit.planar.wall_points import WallPoints, WallsOfRevolution

pytestmark = pytest.mark.taichi

PIPE = flow_text("wide_pipe")
ROUNDING = 1e-12


@dataclass
class Axisymmetric:
    """Unknowns (3, n) and numbers of a stress (6, n) as polynomials of x and s, and what they are in space."""

    x: np.ndarray
    r: np.ndarray

    @staticmethod
    def unknowns(x, s):
        return 1.0 + 2.1 * x + 3.0 * s + 0.5 * x * s, -0.7 + 1.5 * x + 2.2 * s, 1.3 - 1.9 * x + 0.8 * s

    @staticmethod
    def numbers(x, s):
        return 1.0 + x - s, 0.3 + 2.0 * x * s, 2.0 + s - x, -1.0 + 3.0 * x, 0.4 - s + x, 0.6 + x * s

    @classmethod
    def velocity(cls, x, y, z):
        u, v, w = cls.unknowns(x, 0.5 * (y**2 + z**2))
        return np.stack([u, v * y - w * z, v * z + w * y])

    @classmethod
    def stress(cls, x, y, z):
        r = np.sqrt(y**2 + z**2)
        xx, xr, rr, tt, xt, rt = cls.numbers(x, 0.5 * r**2)
        along, out, around = (
            np.stack(way) for way in ((r / r, 0 * r, 0 * r), (0 * r, y / r, z / r), (0 * r, -z / r, y / r))
        )
        product = lambda a, b: a[:, None] * b + b[:, None] * a  # noqa: E731
        own = 0.5 * (xx * product(along, along) + rr * product(out, out) + tt * product(around, around))
        return own + r * (xr * product(along, out) + xt * product(along, around)) + r**2 * rt * product(out, around)

    def in_space(self, field):
        """Values (..., n) of a ``field`` at z = 0, and its derivatives (3, ..., n) along x, y = r, and z."""
        place = np.stack([self.x, self.r, 0.0 * self.r]).astype(complex)
        steps = SMALL * 1j * np.eye(3)
        return field(*place).real, np.stack([field(*(place + step[:, None])).imag / SMALL for step in steps])

    def slopes(self, function):
        """Values (numbers, n) of a ``function`` of x and s, and its derivatives by x and by s."""
        s = 0.5 * self.r**2
        parts = (0.0, 0.0), (SMALL * 1j, 0.0), (0.0, SMALL * 1j)
        value, by_x, by_s = (np.stack(function(self.x + a, s + b)) for a, b in parts)
        return value.real, by_x.imag / SMALL, by_s.imag / SMALL


@ti.data_oriented
class Evaluated:
    """What ``coordinates`` make of velocities, stresses and their derivatives (numbers, n), at the first n points."""

    def __init__(self, coordinates, velocity, stress):
        self.coordinates, count = coordinates, len(velocity[0].T)
        given = []
        for values in (*velocity, *stress):
            field = ti.field(ti.types.vector(len(values), real()), count)
            view(field)[...] = values.T
            given.append(field)
        self.velocity, self.d_dx, self.d_dy, self.stress, self.by_x, self.by_y = given
        self.found = ti.field(ti.types.vector(4, real()), count)
        self.divergence = ti.field(ti.types.vector(coordinates.components, real()), count)
        self.run()

    @ti.kernel
    def run(self):
        for i in self.found:
            own, d_dx, d_dy = self.velocity[i], self.d_dx[i], self.d_dy[i]
            self.found[i] = ti.Vector(
                [
                    self.coordinates.gradient_square(i, self.velocity, d_dx, d_dy),
                    self.coordinates.gradient_product(i, self.velocity, d_dx, d_dy),
                    self.coordinates.squared(i, own),
                    d_dx[0] + self.coordinates.radius(i) ** 2 * d_dy[1] + self.coordinates.hoop(own[1]),
                ]
            )
            self.divergence[i] = self.coordinates.divergence(i, self.stress, 0, self.by_x[i], self.by_y[i])


def assert_those_of_space(found, velocity, gradient, divergence):
    """Numbers for ``gradient`` (derivative, component, points) of a ``velocity``, ``divergence`` of the stress."""
    square, product, squared, trace = view(found.found).T
    assert square == pytest.approx((gradient**2).sum(axis=(0, 1)), rel=ROUNDING)
    assert product == pytest.approx(np.einsum("abn,ban->n", gradient, gradient), rel=ROUNDING, abs=1e-10)
    assert squared == pytest.approx((velocity**2).sum(axis=0), rel=ROUNDING)
    assert trace == pytest.approx(np.einsum("aan->n", gradient), rel=ROUNDING, abs=1e-10)
    of_stress = view(found.divergence).T
    assert of_stress == pytest.approx(divergence, rel=1e-10, abs=1e-10)


@pytest.fixture(scope="module")
def pipe(tmp_path_factory):
    """Scheme of a pipe at its start."""
    return started(tmp_path_factory.mktemp("pipe"), PIPE, [])[1]


def places(scheme):
    """Place along the axis and distance from it of the fluid."""
    x, y = view(scheme.points.position)[: scheme.problem.n_fluid].T.astype(float)
    return x, y + scheme.problem.origin[1]


def test_axisymmetric_coordinates_are_those_of_space(pipe):
    flow = Axisymmetric(*places(pipe))
    velocity, gradient = flow.in_space(flow.velocity)
    divergence = np.einsum("aabn->bn", flow.in_space(flow.stress)[1]) / [1.0 + 0 * flow.r, flow.r, flow.r]
    found = Evaluated(pipe.levels.coordinates, flow.slopes(flow.unknowns), flow.slopes(flow.numbers))
    assert_those_of_space(found, velocity, gradient, divergence)


def test_planar_coordinates_are_those_of_space(pipe):
    draw = np.random.default_rng(1).normal
    velocity, gradient = draw(size=(2, 100)), draw(size=(2, 2, 100))
    stress, by_x, by_y = draw(size=(3, 3, 100))
    divergence = np.stack([by_x[0] + by_y[1], by_x[1] + by_y[2]])
    found = Evaluated(PlanarCoordinates(pipe.operators), (velocity, *gradient), (stress, by_x, by_y))
    assert_those_of_space(found, velocity, gradient, divergence)


def test_a_step_moves_all_levels_on_along_the_path(pipe):
    """Along it r v/r is a velocity and r^2 w/r a circulation; pressures stay as they are."""
    levels, fluid, draw = pipe.levels, slice(pipe.problem.n_fluid), np.random.default_rng(2).normal
    r = places(pipe)[1]
    view(levels.position)[fluid] = view(pipe.points.position)[fluid] + 0.05
    fields = view(levels.fields)[fluid]
    fields[...] = before = draw(size=fields.shape)
    velocity, pressure = (ti.field(kind, pipe.points.slots + 1) for kind in (ti.types.vector(3, real()), real()))
    view(velocity)[fluid], view(pressure)[fluid] = newest = draw(size=(len(r), 3)), draw(size=len(r))
    levels.store(velocity, pressure)
    ratio = (r + 0.05) / r
    expected = [newest[0]]
    for level in range(VELOCITIES - 1):
        u, v, w = before[:, 3 * level : 3 * level + 3].T
        expected.append(np.stack([u, v * ratio, w * ratio**2], axis=1))
    expected += [newest[1][:, None], before[:, [levels.first_pressure]]]
    assert view(levels.fields)[fluid] == pytest.approx(np.concatenate(expected, axis=1), rel=ROUNDING)


def test_uniform_flow_has_no_slope_and_no_fastest_particle(pipe):
    """Along the axis; what moves across it is the fastest, and what turns around it is the largest only."""
    levels, fluid = pipe.levels, slice(pipe.problem.particles)
    r = places(pipe)[1]
    for velocity, largest, fastest in (
        ((2.0, 0.0, 0.0), 0.0, 0.0),
        ((2.0, 0.0, -3.0), 3.0 * r.max(), 0.0),
        ((2.0, 0.5, 3.0), np.hypot(0.5, 3.0) * r.max(), 0.5 * r.max()),
    ):
        view(levels.fields)[fluid, :3] = velocity
        levels.measure()
        found = [float(view(field)) for field in (levels.largest, levels.fastest, levels.largest_gradient)]
        slope = np.sqrt(2.0 * (velocity[1] ** 2 + velocity[2] ** 2))
        assert found == pytest.approx([largest, fastest, slope], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", ["sphere_in_tube", "rotating_end"])
def test_walls_of_revolution_have_the_strain_of_space(name):
    scene = scenes.of(load(Path(__file__).parents[2] / "configs" / f"{name}.yaml"))
    walls = WallsOfRevolution(scene.bodies, scene.spacing, scene.origin)
    x, y = walls.at(0.0)[0].T
    flow = Axisymmetric(x, y + scene.origin[1])
    gradient = flow.in_space(flow.velocity)[1]
    twice = gradient + np.swapaxes(gradient, 0, 1)
    expected = [twice[a, b] for a, b in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2))]
    assert walls.strain(*flow.slopes(flow.unknowns)) == pytest.approx(np.stack(expected), rel=ROUNDING, abs=1e-10)
    assert np.concatenate([np.arange(walls.count)[part] for part in walls.parts]).tolist() == list(range(walls.count))
    tractions = np.tile([1.0, 5.0, 2.0], (2, walls.count, 1))
    loads = walls.sums(tractions, 0.0)[1]
    for number, part in enumerate(walls.parts):
        area = 2.0 * np.pi * flow.r[part] * walls.length[part]
        assert loads[number] == pytest.approx([area.sum(), 0.0, 2.0 * area @ flow.r[part], 0.0], rel=ROUNDING)


def test_planar_walls_have_strain_and_loads_of_a_constant_stress():
    """Of a stress S on a circle with the area A: no force, the torque A (S_xy - S_yx), their mean times A."""
    bodies = [Body(Circle(radius), (x, 1.0)) for radius, x in ((0.4, 1.0), (0.3, 3.0))]
    walls = WallPoints(bodies, 0.05, (0.0, 0.0))
    (xx, yx), (xy, yy) = gradient = np.random.default_rng(3).normal(size=(2, 2, walls.count))  # du_b/dx_a
    strain = walls.strain(np.zeros((2, walls.count)), *gradient)
    assert strain == pytest.approx(np.stack([2.0 * xx, yx + xy, 2.0 * yy]), rel=ROUNDING)
    stress = np.array([[1.0, 0.7], [-0.4, 2.0]])  # traction t_b = n_a S_ab
    loads = walls.sums((walls.at(0.0)[1] @ stress)[None], 0.0)[0]
    for found, body in zip(loads, bodies, strict=True):
        assert found == pytest.approx(body.shape.area * np.array([0.0, 0.0, 0.7 + 0.4, 0.5 * (0.7 - 0.4)]), abs=1e-12)
