"""Files of a run: whole or not there, whatever ends the run, and what they say of themselves.

Snapshots are HDF5 groups: attributes ``t`` and ``step``, a dataset for each field, and a group for the bodies. A
``Description`` has software, flow, units, and the config that made a file.
"""

import contextlib
import io
import math
import os
import shutil
import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import h5py
import numpy as np

from tisph.errors import ConfigError, TisphError
from tisph.folder import partial, spare
from tisph.snapshot import OPTIONAL, STRESSES, STRESSES_AROUND, Bodies, Snapshot
from tisph.version import __version__


@dataclass(frozen=True)
class Description:
    """Of the run of ``config`` in ``scene``; the same for the same config, whenever it runs."""

    config: Any
    scene: Any

    @cached_property
    def resolved(self):
        """The config as YAML; to write that takes longer than all else here."""
        return self.config.resolved_yaml()

    def attributes(self, content):
        """Return names and values, text and numbers in the config's units, of a file with this ``content``."""
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
    def units(self):
        """Units by the name of a field."""
        length, mass, time = (getattr(self.config.units, name) for name in ("length", "mass", "time"))
        fields = {"x": length, "y": length, "u": f"{length}/{time}", "v": f"{length}/{time}", "w": f"{length}/{time}"}
        stresses = ("pressure", *STRESSES, *STRESSES_AROUND, "normal_stress")
        fields |= {"centre": length, "velocity": f"{length}/{time}", "angle": "rad", "angular_velocity": f"rad/{time}"}
        loads = {"force": f"{mass}/{time}^2", "torque": f"{mass} {length}/{time}^2"}  # per length across the plane
        if self.config.axisymmetric:
            loads = {"force": f"{mass} {length}/{time}^2", "torque": f"{mass} {length}^2/{time}^2"}
        fields |= {"contact_force": loads["force"], "t": time}
        fields |= dict.fromkeys(("stresslet", "contact_torque", "contact_stresslet"), loads["torque"])
        fields |= {f"{part}{name}": unit for name, unit in loads.items() for part in ("", "pressure_")}
        fields["vorticity"] = f"1/{time}"
        return {**fields, "density": f"{mass}/{length}^3", **dict.fromkeys(stresses, f"{mass}/({length} {time}^2)")}

    def comment(self, content):
        """Return the attributes as lines that begin with ``#``."""
        lines = []
        for name, value in self.attributes(content).items():
            first, *more = str(value).splitlines() if name != "config" else ["", *value.splitlines()]
            lines += [f"# {name}: {first}".rstrip(), *(f"#   {line}" for line in more)]
        return "".join(f"{line}\n" for line in lines)


DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError)
"""What reading a damaged file raises: h5py has no error of its own."""


@contextlib.contextmanager
def written(path):
    """Raise one TisphError that names ``path`` where the system does not let it be written."""
    try:
        yield
    except OSError as error:
        raise TisphError(f"{path}: cannot be written: {error.strerror or error}") from error


@contextlib.contextmanager
def replaced(path):
    """Yield the path of a new file, which takes the place of ``path`` once it is complete.

    Until then, and where that fails, ``path`` is what it was; TisphError where the system is why.
    """
    new = partial(path)
    with written(path):
        try:
            yield new
            os.replace(new, path)
        except BaseException:
            with contextlib.suppress(OSError):
                new.unlink()
            raise


@contextlib.contextmanager
def readable(path):
    """Raise one ConfigError that names ``path`` where what it holds cannot be read."""
    try:
        yield
    except DAMAGE as error:
        raise ConfigError(f"{path}: cannot be read ({error}); run again with --overwrite") from error


@contextlib.contextmanager
def hdf5_file(path, mode="w"):
    """Yield ``path`` as HDF5 file to write, new or (``r+``) as it is; OSError, once closed, where a write failed."""
    with _Disk(path, "w+" if mode == "w" else "r+") as disk:
        with h5py.File(disk, mode) as hdf5:
            yield hdf5
        if disk.error:
            raise disk.error


class _Disk(io.FileIO):
    """A file that keeps its first failure for later: HDF5 crashes the process where it sees a write fail."""

    error = None

    def write(self, data):
        """Write all of ``data`` as long as nothing has failed."""
        rest = memoryview(data).cast("B")
        try:
            while rest and not self.error:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.error = error
        return len(data)

    def truncate(self, size=None):
        """Set the size of the file."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error


FIELDS = ("x", "y", "u", "v", "density", "pressure")

STATE = ("divergence", "steepest", "added_power", "load_scatter", "acceleration")
"""Attributes of a group beside ``t`` and ``step``, where a scheme knows them: see ``Snapshot``."""

BODIES = "bodies"
"""Name of the group with a dataset for each field of the bodies."""

EXACT = "_exact"
"""What the name of a dataset of the exact solution ends in."""


class Storage:
    """A file of snapshots in groups, which can be read at any time: whatever ends the process spoils nothing in it.

    ``name`` makes the name of a group from its number; those of ``fields`` that a snapshot has are stored, as ``dtype``
    where one is given. A group is in the file at once, or with those added up to ``delay`` seconds later. HDF5 cannot
    add to a file without a moment in which it cannot be read. So there are two: the one that nobody reads is brought up
    to date, then they change places. TisphError where the system lets none be written. ``about``: attributes of the
    file, and units of its datasets, each by name.

    ``put`` says what a snapshot is in the file.
    """

    def __init__(self, path, name, fields=FIELDS + OPTIONAL, dtype=None, delay=0.0, about=({}, {})):
        self.path = path
        self.name = name
        self.options = (fields, dtype)
        self.delay = delay
        self.attributes, self.units = about
        self.count = 0
        self.due = -math.inf
        self.waiting = []
        """Names and contents of the groups that no file has yet."""
        self.missing = []
        """Those that the other file lacks."""

    def start(self, snapshots):
        """Make a file of ``snapshots``, in place of one that there may be."""
        self._tidy()  # what a killed run was writing may be anything
        with replaced(self.path) as new, hdf5_file(new) as file:
            file.attrs.update(self.attributes)
            for snapshot in snapshots:
                self.put(file, self.name.format(self.count), _kept(snapshot, *self.options))
                self.count += 1

    def add(self, snapshot):
        """Add a group."""
        self.waiting.append((self.name.format(self.count), _kept(snapshot, *self.options)))
        self.count += 1
        if time.monotonic() >= self.due:
            self.flush()

    def flush(self):
        """Have all groups in the file."""
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

    def put(self, file, name, snapshot):
        """Write ``snapshot`` as the group ``name`` of the open ``file``."""
        group = file.create_group(name)
        write_snapshot(group, snapshot)
        for part in (group, group.get(BODIES, {})) if self.units else ():
            for name in part:
                unit = self.units.get(name.removesuffix(EXACT))
                if unit:
                    part[name].attrs["units"] = unit

    def close(self):
        """Have all groups in the file, and no other file."""
        try:
            self.flush()
        finally:
            self._tidy()

    def _tidy(self):
        for path in (partial(self.path), spare(self.path)):
            path.unlink(missing_ok=True)


def _kept(snapshot, fields, dtype):
    """Return ``snapshot`` with those of its fields that are in ``fields``, as ``dtype`` where one is given."""
    with np.errstate(over="ignore"):
        values = {name: getattr(snapshot, name) for name in FIELDS + OPTIONAL}
        kept = {
            name: np.asarray(value, dtype) if name in fields and value is not None else None
            for name, value in values.items()
        }
    return replace(snapshot, **kept)


def write_snapshot(group, snapshot):
    """Write the fields that ``snapshot`` has, and those of its reference, into ``group``."""
    group.attrs["t"] = snapshot.t
    group.attrs["step"] = snapshot.step
    for name in STATE:
        if getattr(snapshot, name) is not None:
            group.attrs[name] = getattr(snapshot, name)
    for name in FIELDS + OPTIONAL:
        if getattr(snapshot, name) is not None:
            group.create_dataset(name, data=getattr(snapshot, name))
    for name, values in (snapshot.reference or {}).items():
        group.create_dataset(name + EXACT, data=values)
    if snapshot.bodies is not None:
        bodies = group.create_group(BODIES)
        for name, values in vars(snapshot.bodies).items():
            if values is not None:
                bodies.create_dataset(name, data=values)


def read_snapshots(path, fields=FIELDS):
    """Yield the snapshots in a file, in the order of time; fields other than ``fields`` may be missing, and are empty.

    ConfigError where the file is damaged.
    """
    with readable(path), h5py.File(path, "r") as file:
        for group in sorted(file.values(), key=lambda group: group.attrs["t"]):
            stored = {name: group[name][...] if name in fields or name in group else np.empty(0) for name in FIELDS}
            stored |= {name: group[name][...] for name in OPTIONAL if name in group}
            stored |= {name: group.attrs[name] for name in STATE if name in group.attrs}
            exact = {name.removesuffix(EXACT): group[name][...] for name in group if name.endswith(EXACT)}
            stored["reference"] = exact or None
            if BODIES in group:
                bodies = group[BODIES]
                stored[BODIES] = Bodies(**{name: values[...] for name, values in bodies.items()})
            yield Snapshot(t=float(group.attrs["t"]), step=int(group.attrs["step"]), **stored)
