"""Readings at the end of a run: viscometers around an axis, and the viscosity of a suspension sheared by walls.

* Couette: the stress at the inner cylinder is its torque over 2 pi R1^2 L, the rate there 2 W R2^2/(R2^2 - R1^2) with
  the difference W of the angular velocities. Assumed: laminar flow, and a constant viscosity.
* Falling ball: force = 6 pi mu a U K. Assumed: no inertia, a constant viscosity, a tube closed far away and so long
  that the period has no effect. K of a ratio x = a/R by T. Bohlin, Trans. R. Inst. Technol. Stockholm 155 (1960), for
  x <= 0.6; it is 0.4 % below the exact 5.9474 at x = 0.5.
* Capillary: the stress at the wall is the force on it over its area, the apparent rate 4 Q/(pi R^3), which is the rate
  at the wall if the viscosity is constant. For other fluids ``rabinowitsch`` combines several runs: L. B. Rabinowitsch,
  Z. phys. Chem. A 145 (1929) 1-26.
* Suspension: a mean over a run whose bodies never come to rest. The stress is correlated in time; therefore the
  statistical error of its mean is computed from batch means. The values, evenly spaced in time, are divided into ten
  consecutive batches, whose means are assumed to be independent. The error of the mean is their standard deviation over
  the square root of ten. Ten batches are enough (B. Schmeiser, Oper. Res. 30 (1982) 556-568), and long ones are less
  correlated. Where a batch is shorter than the time in which bodies pass each other, a strain of about one, the error
  is too small. Einstein's 1 + 2 phi is for circles in slow flow of a Newtonian fluid, and shown for these alone.

All readings, in ``rheometry`` too, are a ``Reading``: title, lines of text, numbers, curves.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np

from tisph.errors import ConfigError
from tisph.exact.taylor_vortices import coefficients
from tisph.geometry.circle import Circle
from tisph.geometry.motion import FreeMotion
from tisph.measures.steadiness import Followed, steadiness
from tisph.scenes._axisymmetric import AxisymmetricScene
from tisph.scenes._cell import Cell
from tisph.scenes._scene import Scene
from tisph.scenes.pipe import Scene as Pipe
from tisph.scenes.sphere_in_tube import LARGEST_RATIO, wall_factor

SHOWN = 9
"""Number of lines of a table over time."""


Table: TypeAlias = Mapping[str, np.ndarray]
"""Columns (times,) of a history by name."""


class Axes(NamedTuple):
    """Labels of both axes, kinds of their units as in ``report/labels.py``, and whether both are logarithmic."""

    x: str
    y: str
    units: tuple[str, str]
    logarithmic: bool = False


@dataclass
class Reading:
    """Title, ``lines`` of text, ``numbers`` by name, and ``curves`` of a run.

    A curve is (``Axes``, name, abscissae, ordinates, style), with a style of ``report/plots.py: STYLES``.
    """

    title: str
    lines: list[str]
    numbers: dict[str, float]
    curves: list[tuple[Any, ...]] = field(default_factory=list)


NORMALS = (
    ("n1_mean", "run, mean of the gap", "."),
    ("n1", "run, at the wall that moves", "."),
    ("n1_exact", "reference", "-"),
)
"""Column, name and style of N1: in a channel the mean over the gap, between cylinders at the moving cylinder."""


def normal_stress(table: Table) -> np.ndarray | None:
    """Return N1 of the run; None without a polymer."""
    return table.get("n1", table.get("n1_mean"))


def normal_curves(
    table: Table, axis: Axes, abscissae: np.ndarray, rows: slice | np.ndarray, scale: float = 1.0
) -> list[tuple[Any, ...]]:
    """Return curves of each N1 over a ``scale``, in the ``rows`` of the ``table``."""
    return [(axis, words, abscissae, table[name][rows] / scale, kind) for name, words, kind in NORMALS if name in table]


def over_time(t: np.ndarray, columns: Table, resolved: np.ndarray | None = None) -> list[str]:
    """Return lines of a table of ``columns`` by name at some of the times, more densely at the start.

    ``resolved`` (times,): whether the run is resolved at a time; lines of others say so.
    """
    chosen = np.unique(np.geomspace(1, len(t), SHOWN).astype(int)) - 1
    head, *lines = at_rows(t, columns, chosen)
    marks = [resolved is None or resolved[row] for row in chosen]
    return [head, *(line if good else f"{line}  not resolved" for line, good in zip(lines, marks, strict=True))]


def at_rows(t: np.ndarray, columns: Table, chosen: np.ndarray) -> list[str]:
    """Return lines of a table of ``columns`` by name at the ``chosen`` indices of the times."""
    return [
        f"  {'t':>10} " + " ".join(f"{name:>12}" for name in columns),
        *(f"  {t[k]:10.4g} " + " ".join(f"{values[k]:12.6g}" for values in columns.values()) for k in chosen),
    ]


VISCOMETERS = ("taylor_couette", "pipe", "sphere_in_tube")
"""Scenes that are viscometers."""

NEAR = 0.1
"""Largest difference of drawn viscosities from the viscosity at the end, over the latter."""

LAMINAR = 1e-6
"""Largest ratio of radial to azimuthal kinetic energy in laminar flow; above, vortices carry a part of the torque."""


def read_viscometer(scene_name: str, scene: Scene, table: Table, last: Any) -> Reading:
    """Return the reading of a run of the scene; ``table``: columns of its history, ``last``: its last sample.

    ConfigError where the run is not the flow of the instrument.
    """
    if last is None:
        raise ConfigError("it has no sample: it has not ended")
    read: Any = {"taylor_couette": _couette, "pipe": _capillary, "sphere_in_tube": _falling_ball}[scene_name]
    return read(scene, {name: values[1:] for name, values in table.items()}, last)


def rabinowitsch(readings: Sequence[Reading]) -> list[str]:
    """Return lines of stress, rate and viscosity at the wall of three or more capillaries with one fluid; else none.

    The rate is (3 + n)/4 times the apparent rate, with n = d ln(apparent rate) / d ln(stress).
    """
    pairs = [(each.numbers["wall_stress"], each.numbers["apparent_rate"]) for each in readings]
    if len(pairs) < 3:
        return []
    stress, apparent = np.abs(np.array(pairs)).T
    order = np.argsort(stress)
    stress, apparent = stress[order], apparent[order]
    slope = np.gradient(np.log(apparent), np.log(stress))
    rate = apparent * (3.0 + slope) / 4.0
    rows = zip(stress, rate, stress / rate, strict=True)
    title = "Rabinowitsch: stress, rate and viscosity at the wall"
    return [title, *("  " + "  ".join(f"{value:.6g}" for value in row) for row in rows)]


def _couette(scene: AxisymmetricScene, table: Table, last: Any) -> Reading:
    if not scene.periodic[0]:
        raise ConfigError("a Couette viscometer has no end plates here: the torque at them has no limit")
    outer, inner = (float(body.spin.velocity(table["t"][-1])) for body in reversed(scene.bodies))
    if any(body.spin.oscillates for body in scene.bodies) or inner == outer:
        raise ConfigError("a Couette viscometer has cylinders of different, constant angular velocities")
    square = scene.inner_radius**2
    rate = 2.0 * coefficients((scene.inner_radius, scene.outer_radius), (inner, outer))[1] / square
    stress = -table["torque_inner"] / (2.0 * np.pi * square * scene.length)
    numbers = {"wall_stress": float(stress[-1]), "rate": rate}
    lines = [f"at the inner cylinder: shear stress {stress[-1]:.6g}, nominal rate {rate:.6g}"]
    if table["kinetic_energy_radial"][-1] > LAMINAR * table["kinetic_energy_azimuthal"][-1]:
        lines.append("vortices carry a part of the torque: this is no viscosity of the fluid")
    return _reading("Couette viscometer", scene, table["t"], stress / rate, lines, numbers)


def _capillary(scene: Pipe, table: Table, last: Any) -> Reading:
    moving = any(body.motion.x.largest_speed or body.spin.largest_speed for body in scene.bodies)
    if scene.inner_radius or scene.pulsation or moving or not scene.acceleration:
        raise ConfigError("a capillary is one pipe at rest with a constant acceleration")
    radius = scene.outer_radius
    stress = table["force_outer"] / (2.0 * np.pi * radius * scene.length)
    flow = np.pi * radius**2 * last["mean_velocity"]
    apparent, driven = 4.0 * flow / (np.pi * radius**3), 0.5 * scene.density * scene.acceleration * radius
    lines = [
        f"shear stress at the wall {stress[-1]:.6g}, by the pressure gradient of steady flow {driven:.6g}",
        f"flow rate {flow:.6g}, apparent rate 4 Q/(pi R^3) = {apparent:.6g}",
    ]
    numbers = {"wall_stress": float(stress[-1]), "flow_rate": flow, "apparent_rate": apparent}
    return _reading("capillary", scene, table["t"], stress / apparent, lines, numbers)


def _falling_ball(scene: AxisymmetricScene, table: Table, last: Any) -> Reading:
    sphere, tube = scene.bodies
    if not sphere.free or not isinstance(sphere.shape, Circle) or tube.motion.x.largest_speed:
        raise ConfigError("a falling ball is a free sphere in a tube at rest")
    if scene.kept_mean_velocity != 0.0:
        raise ConfigError("a falling ball needs a closed tube: closure no_flux, without a mean_velocity")
    radius, force = scene.reference_length, float(cast(FreeMotion, sphere.motion).inertia.load[0])
    ratio, speed = radius / scene.outer_radius, table["velocity"]
    if not force or ratio > LARGEST_RATIO:
        raise ConfigError(f"a falling ball has a force, and at most {LARGEST_RATIO:g} of the radius of the tube")
    factor = wall_factor(ratio)
    viscosity = force / (6.0 * np.pi * radius * factor * np.where(speed == 0.0, np.nan, speed))
    reynolds = scene.density * abs(speed[-1]) * radius / viscosity[-1]
    lines = [
        f"velocity {speed[-1]:.6g} under the force {force:.6g}, Reynolds number U a/nu {reynolds:.3g}",
        f"assumed: K = {factor:.6g} of a sphere of {ratio:.4g} of the radius of a closed tube (Bohlin), no inertia",
    ]
    numbers = {"velocity": float(speed[-1]), "wall_factor": float(factor), "reynolds": float(reynolds)}
    return _reading("falling ball", scene, table["t"], viscosity, lines, numbers)


def _reading(
    title: str, scene: Scene, t: np.ndarray, viscosity: np.ndarray, lines: list[str], numbers: dict[str, float]
) -> Reading:
    """Return the viscosity at the end, beside the config's where it is constant, and over time.

    The curve contains only values near the last one: during the start-up they may be twenty times as large.
    """
    end, given = float(viscosity[-1]), scene.dynamic_viscosity
    words = f" (of the config: {given:.6g}, off by {end / given - 1.0:+.2e})" if scene.rheology is None else ""
    lines = [*lines, f"viscosity {end:.6g}{words}"]
    judged = steadiness(scene, float(t[-1]), Followed(t, viscosity[:, None], {"viscosity": abs(end)}))
    if not judged.steady:
        lines.append(f"unsteady: {judged.reason}")
    axis = Axes("time", "viscosity", ("time", "viscosity"))
    near = np.abs(viscosity / end - 1.0) < NEAR
    curves: list[tuple[Any, ...]] = [(axis, "run", t[near], viscosity[near], ".")]
    if scene.rheology is None:
        curves.append((axis, "config", t[[0, -1]], [given, given], "--"))
    return Reading(title, lines, {**numbers, "viscosity": end}, curves)


BATCHES = 10
LEAST_STRAIN = 1.0
"""Least strain of a batch for a reliable error."""

WAYS = {"walls": "by the stress on the walls", "bodies": "by the stresses of the bodies"}


def batch_means(values: np.ndarray) -> tuple[float, float]:
    """Return the mean of ``values`` (n,) and its standard error; the first n modulo ``BATCHES`` of them are ignored.

    ConfigError where there are fewer than ``BATCHES``.
    """
    if len(values) < BATCHES:
        raise ConfigError(f"its history has {len(values)} lines to average over; there must be {BATCHES} at least")
    means = values[len(values) % BATCHES :].reshape(BATCHES, -1).mean(axis=1)
    return float(means.mean()), float(means.std(ddof=1) / np.sqrt(BATCHES))


def read_suspension(channel: Cell, table: Table, contacts: int | None = None) -> Reading:
    """Return the reading of a run with bodies that the flow carries between walls: means over its second half.

    ``table`` has the columns of its history by name; ``contacts`` is the number of contacts of bodies, if known.
    """
    walls = dict(channel.walls)
    rate = float(walls["top"].cosine - walls["bottom"].cosine) / channel.extent[1]
    if any(wall.oscillates for wall in walls.values()) or not rate or "shear_stress_walls" not in table:
        raise ConfigError(
            "the viscosity of a suspension needs walls of different, constant velocities, without a drive"
        )
    strain = abs(rate) * table["t"]
    late = strain > 0.5 * strain[-1]
    viscosity = channel.dynamic_viscosity * rate
    relative = {way: table[f"shear_stress_{way}"] / viscosity for way in WAYS if f"shear_stress_{way}" in table}
    found = {way: batch_means(values[late]) for way, values in relative.items()}
    solid = sum(body.shape.area for body in channel.bodies[: channel.count])
    fraction = solid / float(np.prod(channel.extent))
    circles = all(isinstance(body.shape, Circle) for body in channel.bodies[: channel.count])
    dilute = 1.0 + 2.0 * fraction if circles and channel.rheology is None else None
    numbers = {"area_fraction": fraction, "strain": float(strain[-1]), "shear_rate": rate}
    for way, (mean, error) in found.items():
        numbers |= {f"relative_viscosity_{way}": mean, f"relative_viscosity_{way}_error": error}
    if "shear_stress_contacts" in table:
        numbers["relative_viscosity_contacts"] = float(np.mean(table["shear_stress_contacts"][late])) / viscosity
    if contacts is not None:
        numbers["contacts"] = contacts
    quantity = f"viscosity over that of the {'config' if channel.rheology else 'fluid'}"
    axis = Axes("strain", quantity, ("number", "number"))
    styles = {"walls": ".", "bodies": "-"}
    curves: list[tuple[Any, ...]] = [(axis, WAYS[way], strain, values, styles[way]) for way, values in relative.items()]
    if dilute:
        curves.append((axis, "Einstein, 1 + 2\N{GREEK SMALL LETTER PHI}", strain[[0, -1]], [dilute, dilute], "--"))
    return Reading("suspension in shear", _lines(quantity, numbers, found, dilute), numbers, curves)


def _lines(
    quantity: str, numbers: dict[str, float], found: dict[str, tuple[float, float]], dilute: float | None
) -> list[str]:
    """Return the text; ``quantity`` names the ratio.

    Viscosity of ``dilute`` suspensions: J. F. Brady, Int. J. Multiphase Flow 10 (1984) 113-114.
    """
    strain = numbers["strain"]
    lines = [
        f"area fraction phi = {numbers['area_fraction']:.4g}, shear rate {numbers['shear_rate']:.6g}",
        f"{quantity}, mean from strain {0.5 * strain:.4g} to {strain:.4g}:",
    ]
    lines += [f"  {WAYS[way]:32} {mean:.5g} +- {error:.2g}" for way, (mean, error) in found.items()]
    if "relative_viscosity_contacts" in numbers:
        lines.append(f"  {'part by contacts':32} {numbers['relative_viscosity_contacts']:.3g}")
    if dilute:
        lines.append(f"  {'Einstein, dilute: 1 + 2 phi':32} {dilute:.5g}")
    if "contacts" in numbers:
        lines.append(f"contacts in the whole run: {numbers['contacts']}")
    batch = 0.5 * strain / BATCHES
    if batch < LEAST_STRAIN:
        lines.append(
            f"uncertain: each of the {BATCHES} batches that give the error has a strain of {batch:.2g}, less than "
            f"{LEAST_STRAIN:g}; run to a strain of {BATCHES * 2:g}"
        )
    return lines
