"""Whole states in files: samples at exact times in ``samples.h5``, frames of the movie in ``frames.h5``.

Snapshots are HDF5 groups: attributes ``t`` and ``step``, a dataset for each field, and a group for the bodies. A
``Description`` has software, flow, units, and the config that made a file.
"""

import contextlib
import math
import os
import shutil
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tisph.folder import hdf5_file, partial, readable, replaced, spare
from tisph.measures.metrics import with_reference
from tisph.observers.protocol import StateObserver, Times
from tisph.scenes._scene import Scene
from tisph.snapshot import OPTIONAL, STRESSES, STRESSES_AROUND, Bodies, Snapshot
from tisph.version import __version__


@dataclass(frozen=True)
class Description:
    """Description of a run in its files: the same for the same ``config``, whenever it runs."""

    config: Any
    scene: Scene

    @cached_property
    def resolved(self) -> str:
        """The config as YAML; writing it takes longer than everything else here."""
        return self.config.resolved_yaml()

    def attributes(self, content: str) -> dict[str, Any]:
        """Return the attributes of a file with this ``content``: texts, and numbers in the units of the config."""
        scene, units = self.scene, self.config.units
        return {
            "content": content,
            "name": self.config.name,
            "tisph_version": __version__,
            "scene": self.config.scene,
            "units": f"length {units.length}, mass {units.mass}, time {units.time}",
            **scene.description(),
            "spacing": scene.spacing,
            "density": scene.density,
            "kinematic_viscosity": scene.kinematic_viscosity,
            "rheology": self.config.fluid.rheology.type,
            **(vars(scene.polymer) if scene.polymer else {}),
            "reference_velocity": scene.reference_velocity,
            "frame_velocity": scene.frame_velocity,
            "config": self.resolved,
        }

    @property
    def units(self) -> dict[str, str]:
        """Unit of each field by its name."""
        length, mass, time = (getattr(self.config.units, name) for name in ("length", "mass", "time"))
        carried = self.scene.substances
        fields = {"x": length, "y": length, "u": f"{length}/{time}", "v": f"{length}/{time}", "w": f"{length}/{time}"}
        stresses = ("pressure", *STRESSES, *STRESSES_AROUND, "normal_stress")
        fields |= {"centre": length, "velocity": f"{length}/{time}", "angle": "rad", "angular_velocity": f"rad/{time}"}
        loads = {"force": f"{mass}/{time}^2", "torque": f"{mass} {length}/{time}^2"}  # per length across the plane
        if self.config.axisymmetric:
            loads = {"force": f"{mass} {length}/{time}^2", "torque": f"{mass} {length}^2/{time}^2"}
        fields |= {"contact_force": loads["force"], "t": time}
        fields |= dict.fromkeys(("stresslet", "contact_torque", "contact_stresslet"), loads["torque"])
        fields |= dict.fromkeys(("load_scatter", "load_size"), "{force}, {force}, {torque}".format(**loads))
        fields |= {f"{part}{name}": unit for name, unit in loads.items() for part in ("", "pressure_")}
        fields |= {"vorticity": f"1/{time}", "area": f"{length}^2", **{each.name: each.unit for each in carried}}
        return {**fields, "density": f"{mass}/{length}^3", **dict.fromkeys(stresses, f"{mass}/({length} {time}^2)")}

    def comment(self, content: str) -> str:
        """Return the attributes as lines that begin with ``#``."""
        lines = []
        for name, value in self.attributes(content).items():
            first, *more = str(value).splitlines() if name != "config" else ["", *value.splitlines()]
            lines += [f"# {name}: {first}".rstrip(), *(f"#   {line}" for line in more)]
        return "".join(f"{line}\n" for line in lines)


FIELDS = ("x", "y", "u", "v", "density", "pressure")

STATE = (
    *("divergence", "steepest", "added_power", "load_scatter", "velocity_scatter"),
    *("acceleration", "flow_rates", "backflow", "flows", "received"),
)
"""Attributes of a group beside ``t`` and ``step`` that only some schemes have: see ``Snapshot``."""

BODIES = "bodies"
"""Name of the group with a dataset for each field of the bodies."""

SUBSTANCE = "substance"
"""Attribute of a dataset that is a temperature or a dissolved substance."""

EXACT = "_exact"
"""End of the name of a dataset of the exact solution."""


class Storage:
    """A file of snapshots in groups, which can be read at any time and survives any end of the process.

    ``name`` formats the name of a group from its number. The existing ``fields`` of a snapshot are stored, as
    ``dtype`` if it is given. A group is written at once, or together with the groups of the next ``delay`` seconds.
    HDF5 cannot add to a file without a moment in which it cannot be read. Therefore there are two files: the unread one
    is brought up to date, then they change places. TisphError where the system refuses to write. ``about``: attributes
    of the file, and units of its datasets, each by name.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        fields: tuple[str, ...] = FIELDS + OPTIONAL,
        dtype: type | None = None,
        delay: float = 0.0,
        about: tuple[dict[str, Any], dict[str, str]] = ({}, {}),
    ):
        self.path = path
        self.name = name
        self.options = (fields, dtype)
        self.delay = delay
        self.attributes, self.units = about
        self.count = 0
        self.due = -math.inf
        self.waiting: list[tuple[str, Snapshot]] = []
        """Names and contents of the groups that no file has yet."""
        self.missing: list[tuple[str, Snapshot]] = []
        """Names and contents of the groups that the spare file lacks."""

    def start(self, snapshots: Iterable[Snapshot]) -> None:
        """Create the file with these ``snapshots``, in place of an existing one."""
        self._tidy()  # a killed run may have left anything in them
        with replaced(self.path) as new, hdf5_file(new) as file:
            file.attrs.update(self.attributes)
            for snapshot in snapshots:
                self.put(file, self.name.format(self.count), _kept(snapshot, *self.options))
                self.count += 1

    def add(self, snapshot: Snapshot) -> None:
        """Add a group."""
        self.waiting.append((self.name.format(self.count), _kept(snapshot, *self.options)))
        self.count += 1
        if time.monotonic() >= self.due:
            self.flush()

    def flush(self) -> None:
        """Write all groups to the file."""
        if not self.waiting:
            return
        with replaced(self.path) as new:
            if not new.exists():
                self._tidy()
                shutil.copyfile(self.path, new)
                self.missing = []
            with hdf5_file(new, "r+") as file:
                for name, content in (*self.missing, *self.waiting):
                    self.put(file, name, content)
            with contextlib.suppress(OSError):  # a system without links: next time the file is copied
                os.link(self.path, spare(self.path))
        with contextlib.suppress(OSError):
            os.replace(spare(self.path), new)
        self.missing, self.waiting = self.waiting, []
        self.due = time.monotonic() + self.delay

    def put(self, file: Any, name: str, snapshot: Snapshot) -> None:
        """Write ``snapshot`` as the group ``name`` of the open ``file``."""
        group = file.create_group(name)
        write_snapshot(group, snapshot)
        for part in (group, group.get(BODIES, {})) if self.units else ():
            for name in part:
                unit = self.units.get(name.removesuffix(EXACT))
                if unit:
                    part[name].attrs["units"] = unit

    def close(self) -> None:
        """Write all groups to the file, and remove the spare one."""
        try:
            self.flush()
        finally:
            self._tidy()

    def _tidy(self) -> None:
        for path in (partial(self.path), spare(self.path)):
            path.unlink(missing_ok=True)


def _kept(snapshot: Snapshot, fields: tuple[str, ...], dtype: type | None) -> Snapshot:
    """Return ``snapshot`` with ``fields`` alone, as ``dtype`` if it is given."""
    kept: dict[str, Any] = dict.fromkeys(FIELDS + OPTIONAL)
    with np.errstate(over="ignore"):
        for name in set(kept) & set(fields):
            value = getattr(snapshot, name)
            kept[name] = None if value is None else np.asarray(value, dtype)
        carried = {name: np.asarray(value, dtype) for name, value in (snapshot.substances or {}).items()}
    return replace(snapshot, **kept, substances=carried or None)


def write_snapshot(group: Any, snapshot: Snapshot) -> None:
    """Write the fields of ``snapshot`` and of its reference into the HDF5 ``group``."""
    group.attrs["t"] = snapshot.t
    group.attrs["step"] = snapshot.step
    for name in STATE:
        if getattr(snapshot, name) is not None:
            group.attrs[name] = getattr(snapshot, name)
    for name in FIELDS + OPTIONAL:
        if getattr(snapshot, name) is not None:
            group.create_dataset(name, data=getattr(snapshot, name))
    for name, values in (snapshot.substances or {}).items():
        group.create_dataset(name, data=values)
        group[name].attrs[SUBSTANCE] = True
    for name, values in (snapshot.reference or {}).items():
        group.create_dataset(name + EXACT, data=values)
    if snapshot.bodies is not None:
        bodies = group.create_group(BODIES)
        for name, values in vars(snapshot.bodies).items():
            if values is not None:
                bodies.create_dataset(name, data=values)


def read_snapshots(path: Path, fields: tuple[str, ...] = FIELDS) -> Iterator[Snapshot]:
    """Yield the snapshots in a file, in the order of time; missing fields that are not in ``fields`` are empty.

    ConfigError where the file is damaged.
    """
    with readable(path), h5py.File(path, "r") as file:
        for group in sorted(file.values(), key=lambda group: group.attrs["t"]):
            stored: dict[str, Any] = {
                name: group[name][...] if name in fields or name in group else np.empty(0) for name in FIELDS
            }
            stored |= {name: group[name][...] for name in OPTIONAL if name in group}
            stored |= {name: group.attrs[name] for name in STATE if name in group.attrs}
            exact = {name.removesuffix(EXACT): group[name][...] for name in group if name.endswith(EXACT)}
            stored["reference"] = exact or None
            carried = {name: values[...] for name, values in group.items() if SUBSTANCE in values.attrs}
            stored["substances"] = carried or None
            if BODIES in group:
                bodies = group[BODIES]
                stored[BODIES] = Bodies(**{name: values[...] for name, values in bodies.items()})
            yield Snapshot(t=float(group.attrs["t"]), step=int(group.attrs["step"]), **stored)


FRAME_FIELDS = ("x", "y", "u", "v", "w", "stress_xy", "passages", "area")
"""Fields that every movie may show: the stress exists only with polymer, w only in axisymmetric flow.

``passages`` exist only where particles enter and leave, areas where they vary."""

FRAME_DELAY = 5.0
"""Seconds of the clock between two writings of frames: one at a time takes longer than many a simulation, and every
frame written before the end is written twice, once into each file."""


class Frames(StateObserver):
    """Draws a frame at evenly spaced times and stores its particles in single precision, and bodies in full.

    From the stored frames ``tisph render`` draws the movie again, and an interrupted run continues it: stored frames
    up to ``resumed_at`` are drawn first. ``flush`` must precede a checkpoint, since a resumed run finds earlier frames
    nowhere else. ``more`` are fields beside ``FRAME_FIELDS`` that this or another movie of the run may show.
    """

    def __init__(
        self, path: Path, movie: Any, times: Iterable[float], resumed_at: float | None = None, more: Iterable[str] = ()
    ):
        self.path = path
        self.movie = movie
        self.schedule = Times(times, resumed_at)
        self.storage = Storage(path, "frame_{:05d}", (*FRAME_FIELDS, *more), np.float32, FRAME_DELAY)
        self.storage.start(self._drawn_again(resumed_at))

    def observe(self, snapshot: Snapshot) -> None:
        """Store and draw one frame."""
        self.storage.add(snapshot)
        self.movie.add(snapshot)

    def flush(self) -> None:
        """Write all frames to the file."""
        self.storage.flush()

    def close(self) -> None:
        """Finish the movie, so that it can be played."""
        try:
            self.storage.close()
        finally:
            self.movie.close()

    def _drawn_again(self, resumed_at: float | None) -> Iterator[Snapshot]:
        """Draw and yield the stored frames of an interrupted run up to ``resumed_at``."""
        if resumed_at is None or not self.path.exists():
            return
        for snapshot in read_frames(self.path):
            if snapshot.t <= resumed_at:
                self.movie.add(snapshot)
                yield snapshot


def read_frames(path: Path) -> Iterator[Snapshot]:
    """Yield the stored frames as snapshots, whose missing fields are empty; ConfigError where the file is damaged."""
    return read_snapshots(path, FRAME_FIELDS)


CONTENT = "particles at the times of the samples"


class Samples(StateObserver):
    """Writes a group ``sample_000``, ... at each of ``times``; ``snapshots`` keeps them, with their reference.

    A group has the attributes ``t`` and ``step`` and the datasets x, y, u, v, density, pressure, with polymer also
    stress_xx, stress_xy, stress_yy, of shape (particles_fluid,), in the units of the config and the order of creation.
    Values of the exact solution are beside them: ``u_exact`` and so on. Where there are bodies, the group ``bodies``
    has a dataset for each field of ``tisph.snapshot.Bodies``. ``about`` describes the run in the attributes of the
    file. ``resumed_at`` is the time up to which samples of an interrupted run are kept, None for a new file.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        times: Iterable[float],
        resumed_at: float | None = None,
        about: Description | None = None,
    ):
        self.scene = scene
        self.schedule: Times = Times(times, resumed_at)
        self.snapshots: list[Snapshot] = []
        if resumed_at is not None:
            self.snapshots = [with_reference(scene, kept) for kept in read_samples(path) if kept.t <= resumed_at]
        described = ({}, {}) if about is None else (about.attributes(CONTENT), about.units)
        self.storage = Storage(path, "sample_{:03d}", about=described)
        self.storage.start(self.snapshots)

    def observe(self, snapshot: Snapshot) -> None:
        """Write one sample."""
        snapshot = with_reference(self.scene, snapshot)
        self.storage.add(snapshot)
        self.snapshots.append(snapshot)

    def close(self) -> None:
        """Remove the spare and the partial file."""
        self.storage.close()


def read_samples(path: Path) -> list[Snapshot]:
    """Return the snapshots of a ``samples.h5`` in the order of time; ConfigError where it is damaged."""
    return list(read_snapshots(path))
