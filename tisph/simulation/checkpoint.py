"""Checkpoints: every field of a scheme, so that a resumed run gives the bits of an uninterrupted one."""

import hashlib
import io
import json
import os

import h5py
import numpy as np

from tisph.config import yaml_text
from tisph.errors import ConfigError
from tisph.observers._storage import readable, replaced
from tisph.runtime import ti, view
from tisph.simulation.resumption import require_fit

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
