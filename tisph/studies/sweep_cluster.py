"""The runs of a sweep on the workers of a Dask scheduler: a run whose worker dies is run again.

A worker needs tisph, of the same code, and nothing else: the config travels to it, the files of the run come back.
"""

import multiprocessing
import tempfile
from contextlib import contextmanager
from pathlib import Path

from tisph.errors import ConfigError
from tisph.studies.processes import run_config
from tisph.studies.store import config_text, fingerprint

LEFT_THERE = ("frames.h5", "checkpoint.h5", ".lock")
"""Files that do not travel: large ones that no table needs."""


def outcomes(configs, store, address):
    """Yield (name, ``Result``, message) of runs, their ``configs`` by name, as they end on the workers of the scheduler
    at ``address``.
    """
    distributed = _imported()
    with _connected(distributed, address) as client:
        code = fingerprint()
        futures = [client.submit(run, name, config, code, key=f"{name}-{code}") for name, config in configs.items()]
        try:
            for future in distributed.as_completed(futures):
                name, files, message = future.result()
                yield name, store.keep(name, configs[name], files), message
        finally:
            client.cancel([future for future in futures if not future.done()])


def run(name, config, code):
    """On a worker: run a config in an empty folder; its name, its files by name, and its message, empty if done."""
    if fingerprint() != code:
        raise ConfigError("--scheduler: a worker has another version of tisph than this command")
    multiprocessing.current_process().daemon = False  # as Dask starts it, it might start no process
    with tempfile.TemporaryDirectory(prefix="tisph-sweep-") as scratch:
        path, folder = Path(scratch) / f"{name}.yaml", Path(scratch) / name
        path.write_text(config_text(name, config), encoding="utf-8")
        _, message = run_config(path, folder)
        files = {each.name: each.read_bytes() for each in folder.glob("*") if each.is_file()}
    return name, {key: content for key, content in files.items() if key not in LEFT_THERE}, message


def _imported():
    try:
        import distributed
    except ImportError:
        raise ConfigError("--scheduler: needs Dask: pip install '.[dask]' in a clone") from None
    return distributed


@contextmanager
def _connected(distributed, address):
    try:
        client = distributed.Client(address, timeout="10s")
    except (OSError, ValueError, TimeoutError) as error:
        raise ConfigError(f"--scheduler {address}: cannot be reached: {error}") from None
    with client:
        yield client
