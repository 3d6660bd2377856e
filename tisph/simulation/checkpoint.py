"""Checkpoints: every field of a scheme, so that a resumed run gives the bits of an uninterrupted one."""

import json
import os

import h5py

from tisph.errors import ConfigError
from tisph.runtime import ti


def save(path, scheme, fingerprint):
    """Write the whole state of ``scheme``; an older checkpoint is only replaced by a complete one."""
    partial = path.with_suffix(".partial")
    with h5py.File(partial, "w") as file:
        file.attrs["config"] = fingerprint
        file.attrs["host"] = json.dumps(scheme.host_state())
        for name, field in _fields(scheme):
            options = {} if field.shape == () else {"compression": "gzip", "compression_opts": 1}
            file.create_dataset(name, data=field.to_numpy(), **options)
    os.replace(partial, path)


def restore(path, scheme, fingerprint):
    """Fill ``scheme`` from a checkpoint of the same config.

    Raises ConfigError where there is none, where it belongs to another config, and where it cannot be read.
    """
    if not path.exists():
        raise ConfigError(f"{path}: no checkpoint to resume from; run again with --overwrite")
    try:
        with h5py.File(path, "r") as file:
            if file.attrs["config"] != fingerprint:
                raise ConfigError(
                    f"{path}: the checkpoint is of another config; resume with the config it was made with"
                )
            values = {name: file[name][...] for name, _ in _fields(scheme)}
            host = json.loads(file.attrs["host"])
    except (OSError, KeyError, ValueError) as error:
        raise ConfigError(f"{path}: the checkpoint cannot be read ({error}); run again with --overwrite") from error
    for name, field in _fields(scheme):
        if field.shape == ():
            field[None] = values[name][()]
        else:
            field.from_numpy(values[name])
    scheme.restore_host_state(host)


def _fields(scheme):
    """Yield (name, field) for every Taichi field of the scheme and its parts."""
    for part_name, part in scheme.parts().items():
        for name, field in sorted(vars(part).items()):
            if isinstance(field, ti.Field):
                yield f"{part_name}.{name}", field
