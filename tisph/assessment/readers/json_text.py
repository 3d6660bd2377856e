"""JSON: lists by name, {"x": [...], "u": [...]}, a list of these, or a list of points, [{"x": 0.1, "u": 0.2}, ...]."""

import json

from tisph.assessment.readers.frame import decoded, split
from tisph.errors import ConfigError

SUFFIXES = (".json",)


def read(path, select=None):
    """Frames of the lists, as ``frame.split`` has them; of a list of sets of lists those of each set."""
    try:
        data = json.loads(decoded(path))
        if isinstance(data, list) and not any(isinstance(value, list) for value in data[0].values()):
            data = {name: [point[name] for point in data] for name in data[0]}
        sets = data if isinstance(data, list) else [data]
        return [frame for each in sets for frame in split(each, path)]
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ConfigError(f"{path}: is neither lists by name nor a list of points: {error}") from None
