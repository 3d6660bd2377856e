"""The particles, or points, of one time, as every reader returns them."""

from dataclasses import dataclass, field

import numpy as np

from tisph.errors import ConfigError


@dataclass(frozen=True)
class Frame:
    """Columns of one time by name, arrays (points,), as the file has them: its names, units and axes.

    ``time`` is None where the file does not say it; ``label`` may tell such frames of a file apart. ``units`` has the
    unit of a column, or of ``time``, where the file states one. ``notes`` say in words how it was read.
    """

    columns: dict[str, np.ndarray]
    time: float | None = None
    label: str = ""
    units: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def decoded(path):
    """Text of a file in UTF-16 with a byte-order mark, in UTF-8 or in Windows' cp1252; UnicodeDecodeError for none."""
    content = path.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252")


def time_of(entries):
    """The entry of a mapping that is called ``t``, ``time``, ``TIME`` or ``TimeValue``; None without one."""
    return next((entries[name] for name in entries if name == "t" or name.lower() in ("time", "timevalue")), None)


def split(arrays, path):
    """Frames of named arrays (points,), (points, components), (times, points) or (times, points, components).

    Raises ConfigError where it is not clear which index is the time.
    """
    arrays = {name: array for name, each in arrays.items() if (array := np.asarray(each)).dtype.kind in "fiub"}
    times = np.ravel([] if (found := time_of(arrays)) is None else found)
    one = {len(each) for each in arrays.values() if each.ndim == 1 or (each.ndim == 2 and each.shape[1] <= 3)}
    one -= {len(times)}  # numbers of points in arrays without a time; arrays as long as these have none either
    many = {name: each for name, each in arrays.items() if each.ndim > 1 and each.shape[1] > 3 and len(each) not in one}
    if not many and (len(times) < 2 or not one):
        return [Frame(flat(arrays), float(times[0]) if len(times) == 1 else None)]
    (count, points), *others = {each.shape[:2] for each in many.values()} or {(0, 0)}
    if others or count == points or len(times) not in (0, count):
        shapes = ", ".join(f"{name} {each.shape}" for name, each in arrays.items())
        raise ConfigError(f"{path}: which index is the time? It must be the first one; the arrays are {shapes}")
    fixed = {name: each for name, each in arrays.items() if name not in many and each.ndim and len(each) == points}
    found = [flat(fixed | {name: each[index] for name, each in many.items()}) for index in range(count)]
    return [Frame(*each) for each in zip(found, times.tolist() or [None] * count, strict=True)]


def flat(arrays):
    """Columns (points,) of named ``arrays``: one of shape (points, k) becomes ``name_x``, ``name_y``, ``name_z``.

    Only numbers, and only arrays as long as the longest: others are no quantity of the points.
    """
    columns = {}
    for name, array in arrays.items():
        array = np.asarray(array)
        if array.dtype.kind not in "fiub" or array.ndim not in (1, 2):
            continue
        if array.ndim == 1:
            columns[name] = array.astype(float)
        elif array.shape[1] <= 3:
            columns |= {f"{name}_{axis}": group.astype(float) for axis, group in zip("xyz", array.T, strict=False)}
    longest = max((len(column) for column in columns.values()), default=0)
    return {name: column for name, column in columns.items() if len(column) == longest}


def pysph_frame(particles, time, select, path):
    """The frame of PySPH's own output, version 2: of its groups of ``particles`` by name."""
    group = chosen_group(particles, select, path)
    return Frame(flat(particles[group]["arrays"]), None if time is None else float(time))


def chosen_group(groups, wanted, path):
    """Name of the group of particles: the ``wanted`` one, else ``fluid`` or the like, else the only one.

    ``groups`` are their names. Raises ConfigError where that leaves a choice.
    """
    if wanted:
        if wanted not in groups:
            raise ConfigError(f"{path}: has no particles called {wanted}; it has {', '.join(groups)}")
        return wanted
    fluid = [name for name in groups if name.lower() in ("fluid", "liquid", "water")]
    if fluid or len(groups) == 1:
        return (fluid or list(groups))[0]
    raise ConfigError(f"{path}: which particles are the fluid? Give --select {' or --select '.join(groups)}")
