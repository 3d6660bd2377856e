"""Checkpoints: every field of a scheme, so that a resumed run is bitwise equal to an uninterrupted one.

A checkpoint fits its own config, or one with a later end.
"""

import hashlib
import io
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tisph.config import yaml_text
from tisph.config.yaml_text import in_one_line
from tisph.errors import ConfigError
from tisph.folder import readable, replaced
from tisph.runtime import ti, view
from tisph.schemes._protocol import Scheme

OF_LATER_TIMES = ("time.end", "time.samples", "output.video.frames")
"""Keys that may differ where the end is later: up to the old end they influence only the output."""

MOST_SHOWN = 5
"""Differences between two configs that a message lists."""

OTHER_STEPS = (
    "the steps before the checkpoint were chosen for the old time.end, so that the result is not bitwise that of a run "
    "with the new time.end from the start"
)


def require_fit(path: Path, made_with: str, asked: str, time: float) -> None:
    """Raise ConfigError with the keys that prevent a run of ``asked`` from resuming ``path`` at ``time``.

    ``made_with`` is the config of the checkpoint ``path``; both are resolved configs, as YAML.
    """
    old, new = (yaml_text.parse(text).data for text in (made_with, asked))
    times = [data["time"] for data in (old, new)]
    later = times[1]["end"] > times[0]["end"]
    found = [text for key, text in _differences(old, new) if not (later and key in OF_LATER_TIMES)]
    found += _samples(times[0]["end"], times[0]["samples"], times[1]["samples"], time) if later else []
    if found:
        more = f"; and {len(found) - MOST_SHOWN} more" if len(found) > MOST_SHOWN else ""
        raise ConfigError(
            f"{path}: the checkpoint is of another config: {'; '.join(found[:MOST_SHOWN])}{more}; resume with the one "
            "that it was made with, where only time.end may be later, with samples after the old end and more frames"
        )


def _samples(old_end: float, old_samples: list[float], new_samples: list[float], time: float) -> Iterator[str]:
    """Yield the contradictions between the new samples up to ``old_end`` and the old ones."""
    early = [[sample for sample in samples if sample < old_end] for samples in (old_samples, new_samples)]
    if early[0] != early[1]:
        yield f"time.samples before t = {old_end:g} were {early[0]}, are {early[1]}"
    if time >= old_end and old_end in new_samples and old_end not in old_samples:
        yield f"time.samples has t = {old_end:g}, which the checkpoint has passed without a sample"


def _differences(old: dict[str, Any], new: dict[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield dotted key and description of each difference between two nested maps."""
    for key in sorted(old.keys() | new.keys()):
        if isinstance(old.get(key), dict) and isinstance(new.get(key), dict):
            yield from _differences(old[key], new[key], f"{before}{key}.")
        elif old.get(key) != new.get(key):
            was, now = (in_one_line(json.dumps(data[key])) if key in data else "not given" for data in (old, new))
            yield f"{before}{key}", f"{before}{key} was {was}, is {now}"


DIGEST = hashlib.sha256


def save(path: Path, scheme: Scheme, config: str) -> None:
    """Write the state of ``scheme`` and the resolved ``config``, as YAML; only a complete file replaces an older one.

    The file ends with a digest of all bytes before it, which HDF5 ignores. TisphError where it cannot be written.
    """
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        file.attrs["config"] = config
        file.attrs["host"] = json.dumps(scheme.host_state())
        for name, values in _values(scheme):
            options = {} if values.size <= 1 else {"compression": "gzip", "compression_opts": 1}
            file.create_dataset(name, data=values, **options)
    with replaced(path) as new, new.open("wb") as file:
        file.write(image.getbuffer())
        file.write(DIGEST(image.getbuffer()).digest())
        file.flush()
        os.fsync(file.fileno())  # before the older one is gone


def restore(path: Path, scheme: Scheme, config: str, targets: Sequence[float] = ()) -> bool:
    """Fill ``scheme`` from a checkpoint of the same ``config``, or of one with an earlier end, and set its ``targets``.

    Returns whether a run with these targets from the start would have taken the same steps. ConfigError where there is
    no checkpoint, where it does not fit the config, and where it is damaged.
    """
    if not path.exists():
        raise ConfigError(f"{path}: no checkpoint to resume from; run again with --overwrite")
    with readable(path), h5py.File(io.BytesIO(_image(path)), "r") as file:
        host = json.loads(file.attrs["host"])
        made_with = file.attrs["config"]
        if made_with != config:
            require_fit(path, made_with, config, host["time"])
        scheme.make_room(host)
        for name, values in _values(scheme):
            if file[name].shape != values.shape:
                raise ValueError(f"{name} has the shape {file[name].shape}, not {values.shape}")
            values[...] = file[name][()]
        scheme.restore_host_state(host)
    return made_with == config or scheme.set_targets(targets)


def config_of(path: Path) -> dict[str, Any]:
    """Return the config in the checkpoint ``path``; ConfigError where it cannot be read."""
    if not path.is_file():
        raise ConfigError(f"{path}: no checkpoint to restore")
    with readable(path), h5py.File(io.BytesIO(_image(path)), "r") as file:
        return yaml_text.parse(file.attrs["config"]).data


def _image(path: Path) -> memoryview:
    """Return the HDF5 file that ``save`` wrote; ValueError if a byte has changed, which HDF5 may not detect."""
    content = memoryview(path.read_bytes())
    end = max(0, len(content) - DIGEST().digest_size)
    if DIGEST(content[:end]).digest() != content[end:]:
        raise ValueError("it is not as it was written, or no checkpoint")
    return content[:end]


def _values(scheme: Scheme) -> Iterator[tuple[str, np.ndarray]]:
    """Yield name and array, in place, of the used part of each Taichi field and of each array of the scheme's parts.

    An attribute ``used`` of a field is a NumPy index of that part, or None where nothing outlives a step.
    """
    for part_name, part in scheme.parts().items():
        for name, field in sorted(vars(part).items()):
            used = getattr(field, "used", ...)
            if isinstance(field, ti.Field) and used is not None:
                yield f"{part_name}.{name}", view(field)[used]
            elif isinstance(field, np.ndarray):
                yield f"{part_name}.{name}", field
