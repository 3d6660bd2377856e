"""The samples in a file for ParaView, written during the run: ``samples.vtkhdf``, and the bodies beside it.

VTKHDF has snapshots as one UnstructuredGrid over time, each particle a vertex (VTK 9.3 and later, ParaView 5.12).
Bodies are in a file of their own, each a polygon, or a line: around the fluid in it, or along a wall that is no plane.
Vectors and tensors are in one piece, in three dimensions.

https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np

from tisph.geometry.body import Body, Placement
from tisph.geometry.line import Line
from tisph.measures.fits import vorticity
from tisph.observers.protocol import StateObserver, Times
from tisph.observers.samples import Description, Samples, Storage
from tisph.scenes._scene import Scene
from tisph.snapshot import OPTIONAL, Snapshot

Field = tuple[str, np.ndarray, str]
"""Name, array (particles,) or (particles, components), unit."""

STRESS = ("stress_xx", "stress_yy", "", "stress_xy", "", "")
"""A symmetric tensor in the order of VTK: xx, yy, zz, xy, yz, xz; the plane has no others."""


class Particles(Protocol):
    """Arrays (particles,) by the names of ``samples.h5``, at time ``t``; ``units`` has the name of each."""

    @property
    def t(self) -> float:
        """Time."""

    @property
    def units(self) -> Mapping[str, str]:
        """Unit by name."""

    def __getitem__(self, name: str) -> np.ndarray: ...


class SnapshotArrays(dict):
    """Arrays of a snapshot named as in ``samples.h5``, and of two-dimensional flow ``vorticity``, with ``units``.

    ``about`` is the ``Description`` of the run.
    """

    def __init__(self, about: Description, snapshot: Snapshot):
        found = {name: getattr(snapshot, name) for name in ("x", "y", "u", "v", "density", "pressure", *OPTIONAL)}
        found |= snapshot.substances or {}
        found |= {f"{name}_exact": values for name, values in (snapshot.reference or {}).items()}
        super().__init__({name: values for name, values in found.items() if values is not None and len(values)})
        self.t = snapshot.t
        if not about.scene.parallel:
            self["vorticity"] = vorticity(about.scene, snapshot)
        self.units = {name: about.units.get(name.removesuffix("_exact"), "") for name in self}


def places(particles: Particles) -> np.ndarray:
    """Return the positions, an array (particles, 3), z being 0."""
    return _together(particles, ("x", "y", ""))


def fields(particles: Particles) -> Iterator[Field]:
    """Yield the fields of the particles, and of the reference at each, whose names end in ``_exact``."""
    units = particles.units
    yield "particle", np.arange(len(particles["x"])), ""
    if "passages" in units:
        yield "passages", particles["passages"], ""
    for suffix in ("", "_exact"):
        for name, parts in (("velocity", ("u", "v", "w")), ("stress", STRESS)):
            if parts[0] + suffix in units:
                here = tuple(part and part + suffix for part in parts)
                yield name + suffix, _together(particles, here), units[here[0]]
        for name in ("pressure" + suffix, "density" + suffix, "vorticity" + suffix, "area" + suffix):
            if name in units:
                yield name, particles[name].astype(float), units[name]
    for name in units:
        if name.removesuffix("_exact") not in PLAIN and "/" not in name:  # temperature, dissolved substances
            yield name, particles[name].astype(float), units[name]


PLAIN = ("x", "y", "u", "v", "w", "pressure", "density", "vorticity", *OPTIONAL)
"""Names of all arrays that are no substance."""


def _together(particles: Particles, parts: tuple[str, ...]) -> np.ndarray:
    """Return the arrays named ``parts`` as columns, zeros where there is no name or no such array."""
    nothing = np.zeros(len(particles["x"]))
    return np.stack([particles[part].astype(float) if part in particles.units else nothing for part in parts], axis=1)


VERSION = (2, 0)
VERTEX, POLY_LINE, POLYGON = 1, 4, 7

LARGEST_CHUNK = 65536
"""Most rows in a chunk of a dataset."""

PIECES = 4
"""Points of an outline on the length of the smallest spacing."""


def append(file: Any, snapshot: Snapshot, about: Description) -> None:
    """Append particles as the next step to an open HDF5 ``file``, which is empty before the first one.

    It has ``velocity``, ``pressure``, ``density``, ``stress``, of two-dimensional flow ``vorticity``, ``area`` where it
    varies, and ``particle``, and the exact ones. Field data: ``units``, a text with the unit of each field; and the
    ``config`` as YAML. ``about`` is the ``Description`` of the run.
    """
    particles, count = SnapshotArrays(about, snapshot), len(snapshot.x)
    found = list(fields(particles))
    root = file.get("VTKHDF") or _begun(file, "PointData", {name: unit for name, _, unit in found}, about)
    data = {name: array for name, array, _ in found}
    _add_step(root, snapshot.t, places(particles), np.full(count, VERTEX), np.ones(count, int), data)


def append_bodies(file: Any, snapshot: Any, about: Description) -> None:
    """Append the bodies of ``snapshot`` as the next step: number and all fields of ``tisph.snapshot.Bodies``."""
    bodies, scene = snapshot.bodies, about.scene
    immersed: Sequence[Body] = scene.bodies
    within = ~np.isnan(bodies.angle)
    chosen = [index for index, body in enumerate(immersed) if not isinstance(body.shape, Line) and within[index]]
    outlines = [_outline(scene, immersed[index], bodies.centre[index], bodies.angle[index]) for index in chosen]
    kinds = [POLYGON if immersed[index].in_fluid else POLY_LINE for index in chosen]
    found = {name: np.asarray(values)[chosen] for name, values in vars(bodies).items() if values is not None}
    found = {name: np.pad(values, ((0, 0), (0, 1))) if values.ndim == 2 else values for name, values in found.items()}
    units = {name: about.units.get(name, "") for name in found}
    root = file.get("VTKHDF") or _begun(file, "CellData", {"body": "", **units}, about)
    points = np.pad(np.concatenate([np.empty((0, 2)), *outlines]), ((0, 0), (0, 1)))
    sizes, kind, number = (np.array(each, dtype=int) for each in (list(map(len, outlines)), kinds, chosen))
    _add_step(root, snapshot.t, points, kind, sizes, {"body": number, **found})


def _outline(scene: Scene, body: Body, centre: np.ndarray, angle: float) -> np.ndarray:
    """Return the boundary (n, 2) of a body, closed where the fluid is in it, at the copy that is in the box."""
    edge, periods = body.shape.boundary_points(scene.wanted_spacing.smallest / PIECES).point, np.array(body.periods)
    left = np.floor((centre - scene.origin) / periods)  # 0 along an axis without a period
    centre = centre - np.where(np.isfinite(periods), left, 0.0) * np.nan_to_num(periods, posinf=0.0)
    return Placement(centre, angle).to_lab_frame(
        np.concatenate([edge, edge[:1]]) if body.shape.fluid_side == "inside" else edge
    )


def has_outlines(scene: Scene) -> bool:
    """Return whether the scene has bodies other than straight walls."""
    bodies: Sequence[Body] = scene.bodies
    return any(not isinstance(body.shape, Line) for body in bodies)


def beside(path: Path) -> Path:
    """Return the path of the file of the bodies beside the file ``path`` of the particles."""
    return path.with_name(f"{path.stem}_bodies{path.suffix}")


def _begun(file: Any, part: str, named: dict[str, str], about: Any) -> Any:
    units = {"Points": about.config.units.length, "time": about.config.units.time, **named}
    said = ", ".join(f"{name} [{unit or '-'}]" for name, unit in units.items())
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = VERSION
    root.attrs.create("Type", np.bytes_("UnstructuredGrid"))  # of fixed length and ASCII, or VTK does not know it
    root.create_group(part)
    root.create_group("Steps").attrs["NSteps"] = 0
    for name, text in (("units", said), ("config", about.resolved)):  # in other characters VTK 9.7 ends the process
        plain = text.replace("µ", "u").encode("ascii", "backslashreplace").decode()
        root.create_dataset(f"FieldData/{name}", data=[plain], dtype=h5py.string_dtype("ascii"))
    return root


def _add_step(root: Any, time: float, points: Any, kinds: Any, sizes: Any, data: dict[str, Any]) -> None:
    """Add cells of these ``kinds`` and ``sizes``, each of the next points, and ``data`` of the points or cells."""
    steps, part = root["Steps"], "PointData" if "PointData" in root else "CellData"
    number, point, cell = int(steps.attrs["NSteps"]), *(len(root.get(name, ())) for name in ("Points", "Types"))
    _add(root, "Points", points)
    for name, array in data.items():
        _add(root[part], name, array)
        _add(steps, f"{part}Offsets/{name}", np.array([point if part == "PointData" else cell]))
    for name, count in (("Points", len(points)), ("Cells", len(sizes)), ("ConnectivityIds", len(points))):
        _add(root, f"NumberOf{name}", np.array([count]))
    _add(root, "Connectivity", np.arange(len(points)))
    _add(root, "Offsets", np.append(0, np.cumsum(sizes)))
    _add(root, "Types", kinds.astype(np.uint8))
    for name, value in (("Values", time), ("PartOffsets", number), ("NumberOfParts", 1), ("PointOffsets", point)):
        _add(steps, name, np.array([value]))
    for name, value in (("CellOffsets", cell), ("ConnectivityIdOffsets", point)):
        _add(steps, name, np.array([[value]]))
    for name in root["FieldData"]:  # without offsets VTK 9.7 ends the process; the texts are the same at every step
        _add(steps, f"FieldDataOffsets/{name}", np.array([0]))
        _add(steps, f"FieldDataSizes/{name}", np.array([[1, 1]]))
    steps.attrs["NSteps"] = number + 1


def _add(group: Any, name: str, rows: np.ndarray) -> None:
    """Append ``rows`` to a dataset, which is created at first."""
    if name not in group:
        chunk = (min(max(len(rows), 64), LARGEST_CHUNK), *rows.shape[1:])
        group.create_dataset(name, data=rows, maxshape=(None, *rows.shape[1:]), chunks=chunk)
        return
    data = group[name]
    data.resize(len(data) + len(rows), axis=0)
    data[-len(rows) :] = rows


class Vtk(StateObserver):
    """Appends each of ``samples``, an observer that is called before this one, to the file ``path``.

    The file can be read at any time, and equals the file of ``tisph export --to vtkhdf``. ``resumed_at`` as for
    ``Samples``, whose kept samples begin a new file.
    """

    def __init__(self, path: Path, samples: Samples, resumed_at: float | None, about: Description):
        self.samples = samples
        self.schedule = Times(samples.schedule.times, resumed_at)
        self.files = [_Steps(path, about, append)]
        if has_outlines(about.scene):
            self.files.append(_Steps(beside(path), about, append_bodies))
        for file in self.files:
            file.start(samples.snapshots)

    def observe(self, snapshot: Snapshot) -> None:
        """Append one sample."""
        snapshot = next(kept for kept in reversed(self.samples.snapshots) if kept.t == snapshot.t)
        for file in self.files:
            file.add(snapshot)

    def close(self) -> None:
        """Complete the files and remove their spare versions."""
        for file in self.files:
            file.close()


class _Steps(Storage):
    """A file of steps, which ``append`` adds to; it does not exist before the first step."""

    def __init__(self, path: Path, about: Description, append: Callable[[Any, Snapshot, Description], None]):
        super().__init__(path, "{}")
        self.about, self.append = about, append

    def start(self, snapshots: Iterable[Snapshot]) -> None:
        """Create a file of ``snapshots``, if there are any, and remove the file of an earlier run."""
        self.path.unlink(missing_ok=True)
        if snapshots:
            super().start(snapshots)

    def flush(self) -> None:
        """Write all steps to the file."""
        if self.waiting and not self.path.exists():
            super().start([])
        super().flush()

    def put(self, file: Any, name: str, snapshot: Snapshot) -> None:
        """Append a snapshot."""
        self.append(file, snapshot, self.about)
