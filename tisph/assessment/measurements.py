"""Measurements to which ``tisph fit`` fits a fluid: velocities at places and times, or columns of a rheometer.

Velocities are read as ``tisph compare`` reads them. Columns of a rheometer have a heading each, with the unit in
brackets, such as ``shear rate [1/s]``; one of them says what the others depend on:

* ``angular frequency`` or ``frequency``, in cycles: storage modulus G' and loss modulus G'' of small oscillations;
* ``shear rate``: viscosity or stress, and N1, in steady shear;
* ``time``: stress, torque, force or speed, or a column of the history of the flow that the config describes;
* ``angular velocity``: torque on the cylinder that turns with it, at the end of the flow of the config.

Over a rate or a frequency values extend over decades, and their noise is a part of each value; otherwise it is a part
of the largest value of a column, or of all velocities.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tisph.assessment import alignment, columns, judge, readers
from tisph.config.schema import Config
from tisph.errors import ConfigError
from tisph.scenes._scene import Scene

QUANTITIES = {
    "time": ("t|time", "time"),
    "shear_rate": ("(shear_?|strain_?)?rate|gamma_?dot", "rate"),
    "angular_frequency": ("angular_frequency|omega", "rate"),
    "frequency": ("f|frequency", "rate"),
    "angular_velocity": ("angular_velocity|rotational_speed", "rate"),
    "viscosity": ("(shear_|dynamic_)?viscosity|eta", "viscosity"),
    "stress": ("(shear_)?stress|tau", "pressure"),
    "n1": ("n1|(first_)?normal_stress(_difference)?", "pressure"),
    "storage_modulus": ("g_storage|g_prime|storage_modulus", "pressure"),
    "loss_modulus": ("g_loss|g_double_prime|loss_modulus", "pressure"),
    "torque": ("torque|moment", "torque"),
    "force": ("force", "force"),
    "speed": ("speed|velocity", "velocity"),
}
"""Column of a rheometer -> pattern of its heading, in lower case with ``_`` for other signs, and its kind of unit."""

PRIMES = {"''": "_loss", '"': "_loss", "\N{DOUBLE PRIME}": "_loss", "'": "_storage", "\N{PRIME}": "_storage"}

RELATIVE = ("rate", "frequency")
"""Kinds of measurements whose noise is a part of each value."""

CONSTANT = 1e-3
"""Variation of a shear rate over its largest value that counts as none."""

OUTSIDE = 0.01
"""Distance of a place from the fluid, over the reference length, above which it is an error: the walls are others."""


@dataclass(frozen=True)
class Measurements:
    """Measured values: name -> column (rows,), and ``at``, the columns (rows,) on which they depend.

    ``kind``: velocity (``at`` is t, x, y), time, speed, rate or frequency. ``notes``: how the data were read, in words.
    """

    kind: str
    at: dict[str, np.ndarray]
    measured: dict[str, np.ndarray]
    notes: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of measured values."""
        return sum(map(len, self.measured.values()))

    @property
    def scales(self) -> list[float]:
        """Largest measured value of each column; components of a velocity have a common one."""
        largest = [float(np.abs(values).max()) for values in self.measured.values()]
        return [max(largest)] * len(largest) if self.kind == "velocity" else largest

    def residuals(self, predicted: dict[str, np.ndarray]) -> np.ndarray:
        """Return the differences (size,) of predicted from measured values, as parts; infinite without prediction."""
        pairs = [(predicted[name], values) for name, values in self.measured.items()]
        with np.errstate(all="ignore"):
            if self.kind in RELATIVE:
                parts = [np.log(found / values) for found, values in pairs]
            else:
                parts = [(found - values) / scale for (found, values), scale in zip(pairs, self.scales, strict=True)]
        return np.where(np.isfinite(whole := np.concatenate(parts)), whole, np.inf)


def read(
    config: Config, scene: Scene, paths: Sequence[Path], question: judge.Question, names: Sequence[str]
) -> Measurements:
    """Return the measurements in the files ``paths``, in the units of the ``config``.

    ``names``: columns of the history of the flow. ConfigError where a file cannot be used.
    """
    first = readers.frames(paths[0], question.select)[0].columns
    plain = {name: match[1] if (match := columns.UNIT.fullmatch(name)) else name for name in first}
    if question.columns or any(columns.recognised(axis, plain) for axis in ("x", "y", "r")):
        found = _velocities(scene, paths, question)
    else:
        found = _rheometer(scene, paths, names)
    for name, values in (found.at | found.measured).items():
        if not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0]) + 1
            raise ConfigError(f"{paths[0]}: {name} of row {row} is no number: leave out rows without one")
        if found.kind in RELATIVE and values.min() <= 0:
            raise ConfigError(f"{paths[0]}: {name} of row {int(np.argmin(values)) + 1} must be greater than 0")
        if name in found.measured and not values.any():
            raise ConfigError(f"{paths[0]}: {name} is 0 everywhere")
    times = found.at.get("t", found.at.get("time", np.ones(1)))
    start = getattr(scene, "start_time", 0.0)
    if times.min() <= start:
        row = int(np.argmin(times)) + 1
        raise ConfigError(f"{paths[0]}: row {row} is at t = {times.min():g}, not after the start of the flow {start:g}")
    return found


def _velocities(scene: Scene, paths: Sequence[Path], question: judge.Question) -> Measurements:
    names = ("u",) if scene.parallel else ("u", "v", "w") if scene.axisymmetric else ("u", "v")
    axes = alignment.orientation(question.orientation) if question.orientation else None
    parts: list[dict[str, np.ndarray]] = []
    notes: list[str] = []
    for path, frame, t in judge.frames(paths, question, scene):
        found, centre = frame.columns, getattr(scene, "centre", None)
        if "r" in found and "u_theta" in found and centre and not scene.axisymmetric:  # on the line of y = 0
            along = {"u": found["u_r"]} if "u_r" in found else {}
            found = {"x": centre[0] + found["r"], "y": centre[1] + 0 * found["r"], "v": found["u_theta"], **along}
        found = alignment.oriented(found, scene, axes, question.origin)
        found = {name: found[name] for name in ("x", "y", *names) if name in found}
        if scene.parallel and "y" in found and "u" in found:
            found.setdefault("x", np.full(len(found["y"]), scene.origin[0] + 0.5 * scene.extent[0]))
        if not {"x", "y"} <= found.keys() or not found.keys() & set(names):
            raise ConfigError(f"{path}: this flow needs x, y and one of {', '.join(names)}; say which with --columns")
        parts.append({"t": np.full(len(found["x"]), t), **found})
        notes += frame.notes
    if len({frozenset(part) for part in parts}) > 1:
        raise ConfigError(f"{paths[0]}: some times have other columns than others")
    table = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    for t in np.unique(table["t"]):
        now = table["t"] == t
        _check_places(scene, np.stack([table["x"][now], table["y"][now]], axis=1), float(t), paths[0])
    at = {name: table.pop(name) for name in ("t", "x", "y")}
    return Measurements("velocity", at, table, tuple(dict.fromkeys(notes)))


def _check_places(scene: Scene, points: np.ndarray, t: float, path: Path) -> None:
    """Raise ConfigError where a place lies outside the fluid: the unit or the geometry is another one."""
    low, high = np.array(scene.origin), np.add(scene.origin, scene.extent)
    beyond = np.where(scene.periodic, 0.0, np.maximum(low - points, points - high)).max(initial=0.0)
    if scene.bodies and np.isfinite(points).all():
        beyond = max(beyond, float(-scene.distance(points, t).min()))
    if beyond > OUTSIDE * scene.reference_length:
        text = f"places lie up to {beyond:.4g} outside the fluid at t = {t:g}"
        raise ConfigError(f"{path}: {text}: another geometry, or give --unit, --origin or --orientation")


def _rheometer(scene: Scene, paths: Sequence[Path], names: Sequence[str]) -> Measurements:
    tables, notes = [], []
    for path in paths:
        for frame in readers.frames(path):
            table, own = _named(scene, frame, path, names)
            tables.append(table)
            notes += own
    if len({frozenset(table) for table in tables}) > 1:
        raise ConfigError(f"{paths[0]}: its parts have different columns")
    table = {name: np.concatenate([each[name] for each in tables]) for name in tables[0]}
    if "frequency" in table:
        table["angular_frequency"] = 2 * np.pi * table.pop("frequency")
    rate = table.get("shear_rate")
    swept = rate is not None and np.ptp(rate) > CONSTANT * np.abs(rate).max()
    known = [name for name in table if name in names]
    kinds = (
        ("frequency", "angular_frequency", ["storage_modulus", "loss_modulus"]),
        ("rate", "shear_rate", ["viscosity" if "viscosity" in table else "stress", "n1"] if swept else []),
        ("time", "time", ["stress", "torque", "force", "speed", *known]),
        ("speed", "angular_velocity", ["torque"]),
        ("rate", "shear_rate", ["viscosity" if "viscosity" in table else "stress", "n1"]),
    )
    for kind, along, wanted in kinds:
        if along in table and (found := {name: table[name] for name in wanted if name in table}):
            return Measurements(kind, {along: table[along]}, found, tuple(dict.fromkeys(notes)))
    text = f"{', '.join(table) or 'no column'} and {', '.join(notes) or 'nothing else'}"
    raise ConfigError(
        f"{paths[0]}: is read as {text}; it needs places and velocities, or columns such as "
        "shear rate [1/s] and viscosity [Pa s], angular frequency [rad/s], G' [Pa] and G'' [Pa], "
        "time [s] and stress [Pa], torque, force or speed"
    )


def _named(
    scene: Scene, frame: columns.Frame, path: Path, names: Sequence[str]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return the columns of a rheometer by name, in the units of the config, and notes in words."""
    found: dict[str, np.ndarray] = {}
    notes = []
    for heading, values in frame.columns.items():
        match = columns.UNIT.fullmatch(heading)
        plain, unit = (match[1], match[2] or match[3]) if match else (heading, frame.units.get(heading))
        if plain in names:
            found[plain] = values
            continue
        for sign, word in PRIMES.items():
            plain = plain.replace(sign, word)
        plain = re.sub("[^a-z0-9]+", "_", plain.lower()).strip("_")
        name = next((name for name, (pattern, _) in QUANTITIES.items() if re.fullmatch(pattern, plain)), None)
        if name is None:
            notes.append(f"{path}: {heading} is not read")
            continue
        if name in found:
            raise ConfigError(f"{path}: has two columns of {name.replace('_', ' ')}")
        quantity = QUANTITIES[name][1]
        if not scene.axisymmetric:  # of plane flow, by length across the plane
            quantity = {"force": "force per length", "torque": "force"}.get(quantity, quantity)
        if not unit:
            notes.append(f"{path}: {heading} has no unit: it is taken in that of the config")
        text = re.sub(r"\brad\b", "1", unit or "1").replace("Hz", "1/s")
        size = columns.factor(quantity, text, scene.units, f"{path}: {heading}")
        found[name] = values * size
    return found, notes
