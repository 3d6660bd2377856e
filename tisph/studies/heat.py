"""Measures of temperature and dissolved substances: differences from exact solutions, lines, modes and entrances."""

import cmath
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tisph import scenes
from tisph.exact.convection import growth_rate
from tisph.exact.heat import rotating_mode
from tisph.exact.heated_shear import HeatedShear, StartUp, Wall
from tisph.exact.passive_scalar import Dispersion, Entrance, parabola
from tisph.measures.fits import interpolated, local_fits, periodic_tree, with_walls
from tisph.measures.flow import FlowInBox
from tisph.measures.heat import integral, sheared, wall_of_shear, walls_of
from tisph.measures.substance import TEMPERATURE, Substance
from tisph.results import open_run
from tisph.scenes import annulus
from tisph.snapshot import Snapshot
from tisph.studies.processes import Result

NODES = 48
"""Gauss-Legendre nodes across a channel or a pipe."""

LINE_NODES = 801
"""Points of a line on which the largest value of a field is sought."""


def sheared_off(result: Result, *, t: float) -> float:
    """Return the larger of the errors of temperature and velocity between two walls, over their exact ranges.

    The flow starts from rest and a uniform temperature between plates, cylinders, or in a pipe (``heated_shear``).
    """
    scene, snapshot = _sample(result, t)
    flow, x, y = _sheared(scene), snapshot.x.astype(float), snapshot.y.astype(float)
    place, speed = y, snapshot.u
    if flow.geometry == "around":
        place = np.hypot(x, y)
        speed = (x * snapshot.v - y * snapshot.u) / place
    exact = StartUp(flow, float(scene.substances[0].initial(0.0, 0.0, 0.0))).at(t)
    errors = []
    for found, expected in ((snapshot.field(TEMPERATURE), exact.temperature), (speed, exact.velocity)):
        size = np.ptp(expected(np.linspace(*flow.ends, LINE_NODES)))
        if size > 0.0:  # fluid at rest has no range
            errors.append(float(np.abs(found - expected(place)).max() / size))
    return max(errors)


def rotating_mode_off(result: Result, *, t: float) -> float:
    """Return the largest error of T = J1(k r) cos(theta - Omega t) in a circle with T = 0 at its wall, over its range.

    ``heat.rotating_mode``; the run starts from it.
    """
    scene, snapshot = _sample(result, t)
    (circle,) = scene.bodies
    radius = np.hypot(snapshot.x, snapshot.y)
    exact, start = (
        rotating_mode(
            radius,
            np.arctan2(snapshot.y, snapshot.x),
            time,
            radius=0.5 * scene.extent[0],
            diffusivity=scene.substances[0].diffusivity,
            angular_velocity=float(circle.velocity(np.array([[1.0, 0.0]]), t)[0, 1]),
        )
        for time in (t, 0.0)
    )
    return float(np.abs(snapshot.field(TEMPERATURE) - exact).max() / np.ptp(start))


def largest_on_line(result: Result, *, field: int, line: Sequence[Sequence[float]], t: float) -> float:
    """Return the largest velocity component, ``field`` 0 or 1, between the two ends of a ``line``."""
    scene, snapshot = _sample(result, t)
    first, last = np.array(line, dtype=float)
    points = np.linspace(first, last, LINE_NODES)
    return float(interpolated(scene, *with_walls(scene, snapshot), points)[:, field].max())


def hot_wall_nusselt(result: Result, *, t: float, largest: bool) -> float:
    """Return the largest or the smallest local Nusselt number of the wall x = 0, by fits to T and its wall values."""
    scene, snapshot = _sample(result, t)
    points = np.stack([np.zeros(LINE_NODES), np.linspace(0.0, scene.extent[1], LINE_NODES)], axis=1)
    _, slopes = _at_wall(scene, snapshot, points)
    difference = np.ptp([wall.given(t)[0] for wall in walls_of(scene, scene.substances[0], t) if wall.condition.value])
    found = -slopes[:, 0] * scene.extent[0] / difference
    return float(found.max() if largest else found.min())


def rolls_off(result: Result, *, waves: int, between: Sequence[float]) -> float:
    """Return the relative error of the growth rate of rolls between a warm bottom and a cold top.

    From the amplitude of T with this number of ``waves`` at the times ``between`` (``convection.growth_rate``).
    """
    scene, _ = _sample(result, between[0])
    wavenumber = 2.0 * math.pi * waves / scene.extent[0]
    each, height = scene.substances[0], scene.extent[1]
    top, bottom = (condition.value(0.0, 0.0, 0.0) for condition in (each.conditions[1], each.conditions[0]))
    diffusivity, viscosity = each.diffusivity, scene.kinematic_viscosity
    rayleigh = each.buoyancy[1] * float(bottom - top) * height**3 / (viscosity * diffusivity)
    expected = growth_rate(wavenumber * height, rayleigh, viscosity / diffusivity) * diffusivity / height**2

    def base(y: Any) -> Any:
        return bottom + (top - bottom) * y / height

    return abs(_wave_rate(result, TEMPERATURE, wavenumber, between, expected, base) / expected - 1.0)


def dispersion_off(result: Result, *, name: str, waves: int, between: Sequence[float]) -> float:
    """Return the relative error of the complex rate of the slowest mode of a substance in developed flow.

    From its amplitude with this number of ``waves`` at the times ``between``. An acceleration drives the flow between
    plates or in a pipe at rest (``passive_scalar.Dispersion``).
    """
    scene, _ = _sample(result, between[0])
    wavenumber = 2.0 * math.pi * waves / scene.extent[0]
    width, pipe = scene.extent[1], scene.axisymmetric
    mean = scene.acceleration * width**2 / ((8.0 if pipe else 12.0) * scene.kinematic_viscosity)
    diffusivity = next(each.diffusivity for each in scene.substances if each.name == name)
    exact = Dispersion(width, parabola(mean, width, pipe), diffusivity, pipe).rate(wavenumber)
    return abs(_wave_rate(result, name, wavenumber, between, exact) / exact - 1.0)


def entrance_off(result: Result, *, t: float, at: float, axial_conduction: bool = False) -> float:
    """Return the relative error of the local Nusselt number at x = ``at`` * Dh Pe behind the inlet of a heated channel.

    Plates a gap apart, or a pipe, with a uniform temperature or flux. Exact: ``passive_scalar.Entrance``, or, with
    ``axial_conduction``, its developed value.
    """
    scene, snapshot = _sample(result, t)
    each, width, pipe = scene.substances[0], scene.extent[1], scene.axisymmetric
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    y = width * (nodes + 1.0) / 2.0
    weights = weights * y if pipe else weights
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    fields = np.stack([snapshot.u, snapshot.field(each.name)], axis=1).astype(float)
    mean = scene.reference_velocity
    diameter = 2.0 * width
    place = at * diameter**2 * mean / each.diffusivity
    u, values = interpolated(scene, positions, fields, np.stack([np.full(NODES, place), y], axis=1)).T
    bulk = weights @ (u * values) / (weights @ u)
    wall, slope = (found[0] for found in _at_wall(scene, snapshot, np.array([[place, width]])))
    condition = walls_of(scene, each, t)[-1].condition
    flux = condition.flux and float(condition.flux(place, width, t)) / (each.capacity * each.diffusivity)
    nusselt = diameter * (slope[1] if flux is None else flux) / (wall - bulk)
    exact = Entrance(width, parabola(mean, width, pipe), each.diffusivity, pipe, flux=flux is not None)
    expected = exact.developed_nusselt(True) if axial_conduction else exact.nusselt(place)
    return float(abs(nusselt / expected - 1.0))


def balance_off(result: Result, *, amount: str, wall: str, between: Sequence[float]) -> float:
    """Return the difference of what the fluid gains and receives between two times, over the flow through a ``wall``.

    ``amount``: heat, or the name of a substance.
    """
    first, last = (result.sample(time, "t") for time in between)
    assert first
    assert last
    gained, received = (last[f"{amount}_{word}"] - first[f"{amount}_{word}"] for word in ("gained", "received"))
    return abs((gained - received) / (last[f"{amount}_flow_{wall}"] * (between[1] - between[0])))


def _sample(result: Result, t: float) -> tuple[Any, Snapshot]:
    """Return the scene of a run, and its snapshot at the time ``t``."""
    run = open_run(result.folder)
    snapshot = next(each for each in run.snapshots() if math.isclose(each.t, t, rel_tol=1e-9))
    return scenes.of(run.config), snapshot


def _wave_rate(
    result: Result,
    name: str,
    wavenumber: float,
    between: Sequence[float],
    expected: complex,
    base: Callable[[Any], Any] = np.zeros_like,
) -> complex:
    """Return the complex rate of growth of the integral of (T - base(y)) exp(-i k x) over the fluid.

    Its phase differs by less than half a turn from that of the ``expected`` rate.
    """
    amplitudes = []
    for time in between:
        scene, snapshot = _sample(result, time)
        values = snapshot.field(name) - base(snapshot.y)
        parts = [integral(scene, snapshot, values * wave(wavenumber * snapshot.x)) for wave in (np.cos, np.sin)]
        amplitudes.append(complex(parts[0], -parts[1]))
    time = between[1] - between[0]
    return expected + cmath.log(amplitudes[1] / amplitudes[0] * cmath.exp(-expected * time)) / time


def _sheared(scene: FlowInBox) -> HeatedShear:
    """Return the exact flow of a ``scene`` with two walls, or with the wall of a pipe."""
    each: Substance = scene.substances[0]
    geometry = "along" if scene.axisymmetric else "around" if isinstance(scene, annulus.Scene) else "plates"
    walls, ends = [], []
    for wall in walls_of(scene, each, 0.0):
        point: Any = wall.points[:1]
        ends.append(float(np.hypot(*point[0]) if geometry == "around" else point[0, 1]))
        u, v = scene.bodies[wall.number].velocity(point, 1.0)[0]
        speed = (point[0, 0] * v - point[0, 1] * u) / ends[-1] if geometry == "around" else u
        walls.append(wall_of_shear(wall.condition, point[0], 0.0, float(speed)))
    if len(walls) == 1:
        walls, ends = [Wall(), *walls], [0.0, *ends]
    viscosity = scene.density * scene.kinematic_viscosity

    def factor(temperature: Any, rate: Any) -> Any:
        return viscosity * each.factor(temperature)

    order = np.argsort(ends)
    (low, high), (first, second) = sorted(ends), (walls[place] for place in order)
    return sheared(each, (low, high), (first, second), factor, scene.density, scene.acceleration, geometry)


def _at_wall(scene: FlowInBox, snapshot: Snapshot, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the temperature (n,) and its gradient (n, 2) at ``points`` (n, 2) of walls.

    By fits of degree 4 to the particles and to points on walls with a given temperature.
    """
    positions = [np.stack([snapshot.x, snapshot.y], axis=1).astype(float)]
    values = [snapshot.field(TEMPERATURE).astype(float)]
    for wall in walls_of(scene, scene.substances[0], snapshot.t):
        if wall.condition.value:
            positions.append(wall.points)
            values.append(wall.given(snapshot.t))
    tree, _ = periodic_tree(scene, np.concatenate(positions))
    fits, radius = local_fits(tree, points, np.concatenate(values)[:, None], 4)
    return fits[:, 0, 0], fits[:, 1:3, 0] / radius


MEASURES: dict[str, Callable[..., float]] = {
    function.__name__: function
    for function in (
        sheared_off,
        rotating_mode_off,
        largest_on_line,
        hot_wall_nusselt,
        rolls_off,
        dispersion_off,
        entrance_off,
        balance_off,
    )
}
"""Measures by their names in suites."""
