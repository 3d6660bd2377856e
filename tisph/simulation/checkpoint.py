"""Checkpoints: every field of a scheme, so that a resumed run gives the bits of an uninterrupted one.

A checkpoint fits the config that it was made with, or one that runs for longer.
"""

import hashlib
import io
import json
import os

import h5py
import numpy as np

from tisph.config import yaml_text
from tisph.config.yaml_text import in_one_line
from tisph.errors import ConfigError
from tisph.observers._storage import readable, replaced
from tisph.runtime import ti, view

OF_LATER_TIMES = ("time.end", "time.samples", "output.video.frames")
"""Keys that may differ where the end is later: up to the old end they decide nothing but what is looked at."""

MOST_SHOWN = 5

OTHER_STEPS = (
    "the steps before the checkpoint led to the old time.end, so that the bits are not those of a run that had the "
    "later one from the start"
)


def require_fit(path, made_with, asked, time):
    """Raise ConfigError with the keys that forbid a run of ``asked`` to go on from the checkpoint ``path`` at ``time``.

    ``made_with`` and ``asked`` are resolved configs, as YAML.
    """
    old, new = (yaml_text.parse(text).data for text in (made_with, asked))
    times = [data["time"] for data in (old, new)]
    later = times[1]["end"] > times[0]["end"]
    found = [text for key, text in _differences(old, new) if not (later and key in OF_LATER_TIMES)]
    found += _samples(times[0]["end"], *(data["samples"] for data in times), time) if later else []
    if found:
        more = f"; and {len(found) - MOST_SHOWN} more" if len(found) > MOST_SHOWN else ""
        raise ConfigError(
            f"{path}: the checkpoint is of another config: {'; '.join(found[:MOST_SHOWN])}{more}; resume with the one "
            "that it was made with, where only time.end may be later, with samples after the old end and more frames"
        )


def _samples(old_end, old_samples, new_samples, time):
    """Yield what is wrong with samples that a run to the old end had or should have had."""
    early = [[sample for sample in samples if sample < old_end] for samples in (old_samples, new_samples)]
    if early[0] != early[1]:
        yield f"time.samples before t = {old_end:g} were {early[0]}, are {early[1]}"
    if time >= old_end and old_end in new_samples and old_end not in old_samples:
        yield f"time.samples has t = {old_end:g}, which the checkpoint has passed without a sample"


def _differences(old, new, before=""):
    """Yield dotted key and words for all that differs between two nested maps."""
    for key in sorted(old.keys() | new.keys()):
        if isinstance(old.get(key), dict) and isinstance(new.get(key), dict):
            yield from _differences(old[key], new[key], f"{before}{key}.")
        elif old.get(key) != new.get(key):
            was, now = (in_one_line(json.dumps(data[key])) if key in data else "not given" for data in (old, new))
            yield f"{before}{key}", f"{before}{key} was {was}, is {now}"


DIGEST = hashlib.sha256


def save(path, scheme, config):
    """Write the whole state of ``scheme`` in a run of ``config``, as YAML; only a complete file replaces an older one.

    The file ends with a digest of all before it, which HDF5 does not look at. TisphError where it cannot be written.
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


def restore(path, scheme, config, targets=()):
    """Fill ``scheme`` from a checkpoint of the same ``config``, or of one with an earlier end, and aim at ``targets``.

    Returns whether its steps are those of a run that had these targets from the start. Raises ConfigError where there
    is none, where it does not fit the config, and where it is not as it was written.
    """
    if not path.exists():
        raise ConfigError(f"{path}: no checkpoint to resume from; run again with --overwrite")
    with readable(path), h5py.File(io.BytesIO(_image(path)), "r") as file:
        host = json.loads(file.attrs["host"])
        made_with = file.attrs["config"]
        if made_with != config:
            require_fit(path, made_with, config, host["time"])
        for name, values in _values(scheme):
            if file[name].shape != values.shape:
                raise ValueError(f"{name} has the shape {file[name].shape}, not {values.shape}")
            values[...] = file[name][()]
        scheme.restore_host_state(host)
    return made_with == config or scheme.set_targets(targets)


def config_of(path):
    """Return the config that the checkpoint ``path`` was made with, as a dict; ConfigError where it cannot be read."""
    if not path.is_file():
        raise ConfigError(f"{path}: no checkpoint to restore")
    with readable(path), h5py.File(io.BytesIO(_image(path)), "r") as file:
        return yaml_text.parse(file.attrs["config"]).data


def _image(path):
    """Return what ``save`` wrote; ValueError if a byte of it has changed, since HDF5 would not always see it."""
    content = memoryview(path.read_bytes())
    end = max(0, len(content) - DIGEST().digest_size)
    if DIGEST(content[:end]).digest() != content[end:]:
        raise ValueError("it is not as it was written, or no checkpoint")
    return content[:end]


def _values(scheme):
    """Yield (name, array in place) for what is used of every Taichi field of the scheme and its parts, and for arrays.

    A field may say so by an attribute ``used``, an index of NumPy; None for nothing that outlives a step.
    """
    for part_name, part in scheme.parts().items():
        for name, field in sorted(vars(part).items()):
            used = getattr(field, "used", ...)
            if isinstance(field, ti.Field) and used is not None:
                yield f"{part_name}.{name}", view(field)[used]
            elif isinstance(field, np.ndarray):
                yield f"{part_name}.{name}", field
