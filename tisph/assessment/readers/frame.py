"""The particles, or points, of one time, as every reader returns them."""

from dataclasses import dataclass, field

import numpy as np

from tisph.errors import ConfigError


@dataclass(frozen=True)
class Frame:
    """Columns of one time by name, arrays (points,), as the file has them: its names, units and axes.

    ``time`` is None where the file does not say it; ``label`` then tells the frames of the file apart. ``groups`` are
    the names of the groups of particles that the file had, of which this is ``group``: both empty where it has none.
    ``units`` has the unit of a column, or of ``time``, where the file states one. ``notes`` say how it was read.
    """

    columns: dict[str, np.ndarray]
    time: float | None = None
    group: str = ""
    groups: tuple[str, ...] = ()
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
        if b"\0" in content:
            raise
        return content.decode("cp1252")


def time_of(entries):
    """The entry called ``t``, ``time`` or ``TimeValue`` of a mapping; capitals of the long names do not count."""
    return next(
        (value for name, value in entries.items() if name == "t" or name.lower() in ("time", "timevalue")), None
    )


def split(arrays, path):
    """Frames of named arrays (points,), (points, components), (times, points), (times, points, components).

    Arrays (points, times) are accepted beside more than three times. Raises ConfigError where it is not clear which
    index is the time.
    """
    arrays = {name: np.asarray(array) for name, array in arrays.items()}
    arrays = {name: array for name, array in arrays.items() if array.dtype.kind in "fiub"}
    times = np.ravel([] if (found := time_of(arrays)) is None else found)
    lengths = [len(each) for each in arrays.values() if each.ndim == 1 or (each.ndim == 2 and each.shape[1] <= 3)]
    points = max((length for length in lengths if length != len(times)), default=0)
    if len(times) > 3:
        arrays = {name: each.T if each.shape == (points, len(times)) else each for name, each in arrays.items()}
    series = {
        name: each
        for name, each in arrays.items()
        if each.ndim == 3 or (each.ndim == 2 and each.shape[1] > 3 and len(each) != points)
    }
    if not series and (len(times) < 2 or not points):
        return [Frame(flat(arrays), float(times[0]) if len(times) == 1 else None)]
    shapes = {each.shape[:2] for each in series.values()}
    count, points = next(iter(shapes), (0, 0))
    if (
        len(shapes) != 1
        or (len(times) and len(times) != count)
        or (points == count and 1 in map(np.ndim, arrays.values()))
    ):
        text = ", ".join(f"{name} {each.shape}" for name, each in arrays.items())
        raise ConfigError(f"{path}: which index is the time? The arrays are {text}; the time must be the first index")
    fixed = {name: each for name, each in arrays.items() if name not in series and each.ndim and len(each) == points}
    rows = [flat(fixed | {name: each[index] for name, each in series.items()}) for index in range(count)]
    return [
        Frame(row, float(times[index]) if len(times) else None, label=f"row {index + 1}")
        for index, row in enumerate(rows)
    ]


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
    return Frame(flat(particles[group]["arrays"]), None if time is None else float(time), group, tuple(particles))


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
