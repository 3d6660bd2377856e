"""Runs that outlive the command that asked for them: a run that has ended once is not run again."""

import hashlib
import math
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from filelock import Timeout

from tisph.config.yaml_text import dump
from tisph.errors import ConfigError
from tisph.folder import held
from tisph.studies.processes import POLL_SECONDS, Process, Result, read_result, run_side_by_side

WITHOUT_EFFECT = ("cli/", "interface", "assessment/", "report/", "results/", "studies/", "schemes/_estimate")
"""Parts of the package on which no number of a run depends."""


def config_text(name: str, config: dict[str, Any]) -> str:
    """A config, a plain dict, as YAML under the name ``name``."""
    return dump({"name": name, **config})


Outcome = tuple[str, Result, str]
"""Name of a run, its ``Result``, and its error message, empty if it is done."""


@contextmanager
def claimed(folder: Path, taken: str) -> Iterator[None]:
    """Hold ``folder``, made if there is none, against other commands; on Ctrl-C say that runs are kept there.

    Raises ConfigError, with the words ``taken`` where another command holds it, and where it cannot be written.
    """
    try:
        with held(folder):
            yield
    except Timeout:
        raise ConfigError(f"--out {folder}: {taken}; choose another folder") from None
    except OSError as error:
        raise ConfigError(f"--out {folder}: cannot be written: {error.strerror or error}") from None
    except KeyboardInterrupt:
        print(f"\nfinished runs are kept in {folder}; the same command goes on from them", flush=True)
        raise


class Store:
    """Runs kept in ``folder``: NAME.yaml is the config of the run in NAME, with a mark of the code that it ran."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._code = fingerprint()
        folder.mkdir(exist_ok=True)

    def kept(self, name: str, config: dict[str, Any]) -> tuple[Result, str] | None:
        """``Result`` and message of a run that ended, with this config and this code; None without one."""
        path = self.folder / f"{name}.yaml"
        if not path.is_file() or path.read_text(encoding="utf-8") != self._text(name, config):
            return None
        result = read_result(self.folder / name)
        if result.summary["status"] not in ("done", "diverged"):
            return None
        return result, result.summary.get("message", "")

    def outcome(self, name: str, config: dict[str, Any]) -> tuple[Result, str]:
        """``Result`` and message of one run, kept or new."""
        [(_, result, message)] = self.outcomes({name: config}, 1)
        return result, message

    def outcomes(
        self, configs: dict[str, dict[str, Any]], most: int, launch: Callable[[str], Process] | None = None
    ) -> Iterator[Outcome]:
        """Yield (name, ``Result``, message) of runs, their ``configs`` by name: first of those that are kept.

        The others run ``most`` at once, started by ``launch(name)``, which is ``launch`` of this store if not given.
        """
        missing = []
        for name, config in configs.items():
            kept = self.kept(name, config)
            if kept:
                yield (name, *kept)
            else:
                missing.append(name)
        start = launch or (lambda name: self.launch(name, configs[name]))
        with closing(run_side_by_side(missing, start, most)) as ended:
            yield from ended

    def launch(self, name: str, config: dict[str, Any], seconds: float = math.inf) -> Process:
        """Start the run as a ``Process`` of at most ``seconds``, in place of one that may be there.

        Wait until no run of an earlier command that was killed goes on in its folder.
        """
        folder = self.folder / name
        while folder.is_dir():
            try:
                with held(folder):
                    break
            except Timeout:
                time.sleep(POLL_SECONDS)
        (folder / "summary.json").unlink(missing_ok=True)
        return Process(self.write(name, config), folder, seconds=seconds)

    def write(self, name: str, config: dict[str, Any]) -> Path:
        """Write the config of a run into its file, and return the path."""
        path = self.folder / f"{name}.yaml"
        path.write_text(self._text(name, config), encoding="utf-8")
        return path

    def keep(self, name: str, config: dict[str, Any], files: dict[str, bytes]) -> Result:
        """``Result`` of a run that was made elsewhere: its ``files``, contents by name, kept as if it had run here."""
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        for file, content in files.items():
            (folder / file).write_bytes(content)
        self.write(name, config)
        return read_result(folder)

    def _text(self, name, config):
        return f"# code {self._code}\n{config_text(name, config)}"


def fingerprint() -> str:
    """Hash of the source files on which the numbers of a run depend."""
    root = Path(__file__).parents[1]
    paths = [path for path in root.rglob("*.py") if not path.relative_to(root).as_posix().startswith(WITHOUT_EFFECT)]
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
