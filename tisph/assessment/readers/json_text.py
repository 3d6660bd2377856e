"""JSON: lists by name, {"x": [...], "u": [...]}, or a list of points, [{"x": 0.1, "u": 0.2}, ...]."""

import json

import numpy as np

from tisph.assessment.readers.frame import Frame, flat
from tisph.errors import ConfigError

SUFFIXES = (".json",)


def read(path, select=None):
    """One frame; a number called ``t`` or ``time`` beside the lists is its time."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(data, list):
            data = {name: [point[name] for point in data] for name in data[0]}
        arrays = {name: np.asarray(values) for name, values in data.items() if isinstance(values, list)}
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ConfigError(f"{path}: is neither lists by name nor a list of points: {error}") from None
    time = next((float(data[name]) for name in ("t", "time") if isinstance(data.get(name), int | float)), None)
    return [Frame(flat(arrays), time)]
