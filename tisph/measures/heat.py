"""Numbers of temperature and dissolved substances in a sample: means, flows through walls, balance, mixing.

The heat flow of a wall comes from fits at the wall. The mean over the fluid of the flux u T - kappa dT/dx, from a hot
plane wall to a cold one, is the mean of the flow through all sections: it has no derivative at a wall, so that the
difference of the two Nusselt numbers estimates their error.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.exact import heated_shear
from tisph.measures.fits import periodic_tree, velocity_gradients
from tisph.measures.flow import FAINT, FlowInBox, Size
from tisph.measures.substance import TEMPERATURE, Condition, Substance
from tisph.snapshot import Snapshot

NEAREST = 7
"""Particles, the particle itself included, among which its steepest slope is found."""


@dataclass(frozen=True)
class Wall:
    """A wall with a ``suffix`` of names: ``points`` (n, 2) on it, the ``areas`` (n,) that they stand for, and T."""

    suffix: str
    points: np.ndarray
    areas: np.ndarray
    condition: Condition
    number: int

    @property
    def insulated(self) -> bool:
        """Whether the wall lets nothing through."""
        return self.condition.flux is not None and self.condition.flux.given == 0.0

    def given(self, t: float) -> np.ndarray:
        """Return the values that the condition gives at the points, none for a flux."""
        x, y = self.points.T
        return self.condition.value(x, y, t) if self.condition.value else np.empty(0)


def walls_of(scene: FlowInBox, each: Substance, t: float) -> list[Wall]:
    """Return the walls and bodies of a flow with their conditions, per length in planar flow."""
    places: list[tuple[str, np.ndarray, np.ndarray]] = []
    if scene.parallel:
        for name, y in (("_bottom", 0.0), ("_top", scene.extent[1])):
            places.append((name, np.array([[0.0, y]]), np.array(scene.extent[:1])))
    else:
        for name, body in zip(getattr(scene, "names", ()), scene.bodies, strict=False):
            boundary = body.boundary_points(scene.wanted_spacing.smallest, t)
            around = 2.0 * np.pi * boundary.point[:, 1] if scene.axisymmetric else 1.0
            suffix = name if name[:1] in ("", "_") else f"_{name}"
            places.append((suffix, boundary.point, boundary.length * around))
    found = [Wall(*place, each.conditions[number], number) for number, place in enumerate(places)]
    return [wall for wall in found if scene.parallel or scene.bodies[wall.number].solid]


def wall_of_shear(condition: Condition, place: np.ndarray, t: float, speed: Any) -> heated_shear.Wall:
    """Return a wall of ``exact.heated_shear`` at a ``place`` (2,) with the ``condition`` there at time ``t``."""
    x, y = place[:1], place[1:]
    if condition.value:
        return heated_shear.Wall(float(condition.value(x, y, t)[0]), speed=speed)
    return heated_shear.Wall(None, float(condition.flux(x, y, t)[0]) if condition.flux else 0.0, speed=speed)


def sheared(
    heat: Substance,
    ends: tuple[float, float],
    walls: tuple[heated_shear.Wall, heated_shear.Wall],
    viscosity: Callable[[Any, Any], Any],
    density: float,
    acceleration: float = 0.0,
    geometry: str = "plates",
) -> heated_shear.HeatedShear:
    """Return the exact flow of a fluid with the temperature ``heat`` between ``walls`` at the coordinates ``ends``.

    ``viscosity``: dynamic, a function of temperature and shear rate. ``acceleration`` along x drives the flow.
    """
    return heated_shear.HeatedShear(
        ends,
        walls,
        viscosity,
        heat.capacity * heat.diffusivity,
        density=density,
        heat_capacity=heat.capacity / density,
        pressure_gradient=density * acceleration,
        buoyancy=density * float(heat.buoyancy[0]),
        reference=heat.reference,
        heating=bool(heat.heating),
        geometry=geometry,
    )


def integral(scene: FlowInBox, snapshot: Snapshot, values: Any) -> float:
    """Return the integral of ``values`` (particles,) over the fluid, around an axis over its volume."""
    around = 2.0 * np.pi * snapshot.y if scene.axisymmetric else np.ones(len(snapshot.x))
    return scene.fluid_area * scene.mean(snapshot, values * around)


def flow_quantities(scene: FlowInBox, names: Iterable[str]) -> list[str]:
    """Return those of the ``names`` in a sample that are quantities of the flow of its substances, and no errors."""
    found = []
    for each in scene.substances:
        amount = "heat" if each.name == TEMPERATURE else each.name
        let_through = [wall for wall in walls_of(scene, each, scene.start_time) if not wall.insulated]
        found += [f"{each.name}_mean", *(f"{amount}_flow{wall.suffix}" for wall in let_through)]
    return [name for name in names if name in found or name.startswith("nusselt_")]


def substance_errors(scene: FlowInBox, snapshot: Snapshot) -> dict[str, float | None]:
    """Return ``NAME_error`` = max |T - T_exact| over the scale of T, where the scene has an exact solution."""
    exact, found = snapshot.reference or {}, {}
    for each in scene.substances:
        if each.name in exact and snapshot.substances:
            found[f"{each.name}_error"] = np.abs(snapshot.field(each.name) - exact[each.name]).max() / each.scale
    return found


def substance_measures(scene: FlowInBox, snapshot: Snapshot) -> dict[str, float | None]:
    """Return the numbers of all substances of a flow in a ``snapshot``, by names that begin with the substance.

    ``NAME_mean``, ``NAME_min``, ``NAME_max``. Of heat, or of a substance NAME: ``heat_flow_top`` from each wall into
    the fluid; ``heat_gained``, the change of the content since the start, and ``heat_received`` through walls, from
    sources and by heating. Of a dissolved substance ``NAME_variance`` and ``NAME_dissipation`` = 2 D mean |grad T|^2.
    Nusselt numbers, where walls have different given temperatures.
    """
    found: dict[str, float | None] = {}
    for number, each in enumerate(scene.substances if snapshot.substances else ()):
        values = (snapshot.substances or {})[each.name].astype(float)
        amount = "heat" if each.name == TEMPERATURE else each.name
        volume = integral(scene, snapshot, 1.0)
        average = integral(scene, snapshot, values) / volume
        found |= {f"{each.name}_mean": average, f"{each.name}_min": values.min(), f"{each.name}_max": values.max()}
        walls = walls_of(scene, each, snapshot.t)
        flows = None if snapshot.flows is None else snapshot.flows[number]
        found |= {f"{amount}_flow{wall.suffix}": None if flows is None else flows[wall.number] for wall in walls}
        found |= _balance(scene, snapshot, each, values, amount, number)
        if amount == "heat":
            found |= _nusselt(scene, snapshot, each, values - average, walls, flows)
        else:
            slopes = velocity_gradients(scene, replace(snapshot, u=values))[:2]
            squares = integral(scene, snapshot, np.square(slopes).sum(axis=0)) / volume
            found[f"{each.name}_variance"] = integral(scene, snapshot, np.square(values - average)) / volume
            found[f"{each.name}_dissipation"] = 2.0 * each.diffusivity * squares
    return found


def _balance(
    scene: FlowInBox, snapshot: Snapshot, each: Substance, values: np.ndarray, amount: str, number: int
) -> dict[str, float | None]:
    """Return change of the content and amount received since the start; nothing where fluid enters or bodies move."""
    if scene.flows_through or (scene.changes_shape and isinstance(each.initial.given, str)):
        return {}
    rise = values - each.initial(snapshot.x, snapshot.y, scene.start_time)
    received = None if snapshot.received is None else float(snapshot.received[number])
    return {f"{amount}_gained": each.capacity * integral(scene, snapshot, rise), f"{amount}_received": received}


def _nusselt(
    scene: FlowInBox, snapshot: Snapshot, each: Substance, excess: np.ndarray, walls: list[Wall], flows: Any
) -> dict[str, float | None]:
    """Return Nusselt numbers, reference length * flux/(k * largest difference of the given temperatures of walls).

    ``excess`` (particles,): temperature less its mean. ``nusselt_top`` by the mean flux of each wall with a given
    temperature. ``nusselt_sections`` by the mean flux between two plane walls, without sources: 1 + mean (u T)
    distance/(kappa * difference) over the distance.
    """
    held = [(wall, given) for wall in walls if len(given := wall.given(snapshot.t))]
    temperatures = np.concatenate([given for _, given in held]) if held else np.zeros(1)
    difference, found = float(np.ptp(temperatures)), {}
    if len(held) < 2 or not difference:
        return {}
    conduction = each.capacity * each.diffusivity * difference / scene.reference_length
    for wall, _ in held:
        flow = None if flows is None else abs(flows[wall.number]) / np.sum(wall.areas)
        found[f"nusselt{wall.suffix}"] = None if flow is None else flow / conduction
    (cold, _), *_, (hot, _) = sorted(held, key=lambda pair: float(pair[1].mean()))
    apart = cold.points.mean(axis=0) - hot.points.mean(axis=0)
    axis = int(np.argmax(np.abs(apart)))
    plane = len(held) == 2 and np.ptp(np.concatenate([hot.points, cold.points])[:, axis]) <= abs(apart[axis]) * (
        1.0 + 1e-9
    )
    even = all(np.ptp(given) == 0.0 for _, given in held)
    sources = each.heating or each.has_source or any(wall.condition.flux and not wall.insulated for wall in walls)
    if plane and even and not (sources or scene.parallel or scene.axisymmetric or scene.flows_through):
        carried = scene.mean(snapshot, (snapshot.u, snapshot.v)[axis] * excess) * apart[axis]
        part = scene.reference_length / abs(apart[axis])
        found["nusselt_sections"] = part * (1.0 + carried / (each.diffusivity * difference))
    return found


def thinnest_layer(scene: FlowInBox, t: float) -> Size:
    """Return the depth sqrt(kappa t) of the layer at a wall whose given value is another one than at the start.

    Of several layers it is the one that is the thinnest in spacings; infinite if there is none.
    """
    layers = []
    for each in scene.substances:
        for number in each.jumps:
            spacing = scene.wall_spacings[number] if scene.bodies else scene.spacing
            layers.append((math.sqrt(each.diffusivity * (t - scene.start_time)), f"the layer of {each.words}", spacing))
    return min(layers, key=lambda layer: layer[0] / layer[2], default=(math.inf, ""))


def steepest(scene: FlowInBox, snapshot: Snapshot) -> tuple[float, str]:
    """Return the shortest length, in spacings, in which a substance changes by its whole range, and its name.

    The length is the range over the slope to a neighbour that half a row of particles exceed: at corners between walls
    of different values the slope is infinite.
    """
    found = [(math.inf, "")]
    for each in scene.substances:
        values, places = snapshot.field(each.name), np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
        if values is None or not (np.ptp(values) > FAINT * each.scale and np.isfinite(places).all()):
            continue
        tree, positions = periodic_tree(scene, places)
        distance, others = (each[:, 1:] for each in tree.query(positions, NEAREST))
        slopes = np.abs(values[others] - values[:, None]) / distance
        changes = slopes.max(axis=1) * snapshot.widths(scene.spacing)
        row = max(1, round(0.5 * math.sqrt(len(changes))))
        found.append((float(np.ptp(values) / np.partition(changes, -row)[-row]), each.words))
    return min(found)


def dimensionless_numbers(scene: FlowInBox) -> list[tuple[str, str]]:
    """Return pairs (label, text) about the substances of a flow, for ``tisph check``."""
    lines: list[tuple[str, str]] = []
    length, viscosity, unit = scene.reference_length, scene.kinematic_viscosity, scene.units.length
    for each in scene.substances:
        kappa, heat = each.diffusivity, each.name == TEMPERATURE
        symbol, of, number = ("kappa", "", "Prandtl number") if heat else ("D", f" of {each.words}", "Schmidt number")
        lines.append((f"diffusivity{of}", f"{kappa:.6g} {unit}^2/{scene.units.time}  ({symbol})"))
        lines.append((f"{number}{of}", f"{viscosity / kappa:.4g}  (nu/{symbol})"))
        numbers, layer = {}, 0.0
        if scene.velocity_scale:
            peclet = scene.reference_velocity * length / kappa
            numbers["Peclet number"], layer = (peclet, f"U L/{symbol}"), length * peclet**-0.5
        power = each.heating * viscosity * scene.reference_velocity**2 / kappa  # a difference of temperatures
        if power and each.law:
            numbers["Nahme number"] = abs(each.sensitivity) * power, "a mu U^2/k, a the change of ln mu with T"
        given = [wall.given(scene.start_time) for wall in walls_of(scene, each, scene.start_time)]
        if power and (difference := np.ptp(np.concatenate([*given, np.zeros(0 if any(map(len, given)) else 1)]))):
            numbers["Brinkman number"] = power / difference, "mu U^2/(k dT)"
        if each.expansion:
            drive = float(np.hypot(*each.buoyancy)) * each.scale
            rayleigh = drive * length**3 / (viscosity * kappa)
            numbers["Rayleigh number"], layer = (rayleigh, "g beta dT L^3/(nu kappa)"), length * rayleigh**-0.25
        lines += [(name + of, f"{value:.4g}  ({meaning})") for name, (value, meaning) in numbers.items()]
        if 0.0 < layer < length and not scene.parallel:
            formula = "L Ra^(-1/4)" if each.expansion else "L Pe^(-1/2)"
            text = (
                f"{layer:.4g} {unit}, {layer / scene.wall_spacing:.2g} spacings  (about {formula}, where fluid passes)"
            )
            lines.append((f"thin layer{of}" if of else "thermal layer", text))
    return lines
