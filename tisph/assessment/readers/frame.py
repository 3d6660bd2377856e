"""What a reader makes of a file: the particles, or points, of one time."""

from dataclasses import dataclass

import numpy as np

from tisph.errors import ConfigError


@dataclass(frozen=True)
class Frame:
    """Columns of one time by name, arrays (points,), as the file has them: its names, units and axes.

    ``time`` is None where the file does not say it. ``groups`` are the names of the groups of particles that the file
    had, of which this is ``group``: both empty where it has no groups.
    """

    columns: dict[str, np.ndarray]
    time: float | None = None
    group: str = ""
    groups: tuple[str, ...] = ()


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
