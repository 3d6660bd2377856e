"""``summary.json`` as a file, and what else its numbers come from."""

import hashlib
import json
import platform
import subprocess
import sys
from importlib import metadata
from pathlib import Path

from tisph import runtime
from tisph.observers._storage import replaced
from tisph.version import __version__


def write_summary(path, summary):
    """Write ``summary`` as JSON, whole or not at all."""
    with replaced(path) as new:
        new.write_text(json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8")


def fingerprint(resolved):
    """Return a hash of all that decides a run's outcome: the ``resolved`` config as YAML."""
    return hashlib.sha256(resolved.encode()).hexdigest()[:16]


def provenance(config, resolved, threads):
    """Return what else a number in the summary depends on; ``resolved`` is the config as YAML."""
    packages = (runtime.PACKAGE, "numpy", "scipy", "h5py", "pydantic", "matplotlib")
    return {
        "versions": {
            "tisph": __version__,
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in packages},
        },
        "platform": platform.platform(),
        "processor": platform.machine(),
        "threads": threads,
        "precision": config.discretisation.precision,
        "seed": config.initial.seed,
        "config_hash": fingerprint(resolved),
        "commit": _commit(),
    }


def peak_memory_mb():
    """Return the largest resident memory of this process so far, None where the system does not tell."""
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6, 1)


def _commit():
    """Return the commit of the checkout that the package lies in, None for an installed package."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    try:
        run = subprocess.run(
            ["git", "-C", str(root), "rev-parse", "HEAD"],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return run.stdout.strip()
