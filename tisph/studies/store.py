"""Runs of many configs: kept in a folder, started side by side, with a progress bar on a terminal.

Suites, sweeps, the stability matrix and the benchmarks all run their configs here. A run that has ended once, with the
same config and the same code, is read from its folder: an interrupted command continues where it stopped.
"""

import hashlib
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, nullcontext
from pathlib import Path
from typing import Any

from filelock import Timeout
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from tisph.config.yaml_text import dump
from tisph.errors import ConfigError
from tisph.folder import held
from tisph.studies.processes import Ended, Outcomes, Process, Result, read_result, run_side_by_side

WITHOUT_EFFECT = ("cli/", "interface", "assessment/", "report/", "results/", "studies/", "schemes/_estimate")
"""Parts of the package on which no number of a run depends."""

START_SECONDS = 2.0
"""Approximate time [s] of a run apart from its steps, for the remaining time on the bar."""

PATIENCE, ALLOWANCE = 10.0, 600.0
"""A limited run is stopped after PATIENCE times its estimated time plus ALLOWANCE [s], since machines pause."""


def config_text(name: str, config: dict[str, Any]) -> str:
    """Return a config, a plain dict, as YAML under the name ``name``."""
    return dump({"name": name, **config})


def fingerprint() -> str:
    """Return a hash of the source files on which the numbers of a run depend."""
    root = Path(__file__).parents[1]
    paths = [path for path in root.rglob("*.py") if not path.relative_to(root).as_posix().startswith(WITHOUT_EFFECT)]
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@contextmanager
def claimed(folder: Path, taken: str, alone: bool = True) -> Iterator[None]:
    """Lock ``folder``, created if missing, against other commands; on Ctrl-C print that its runs are kept.

    Raises ConfigError, with the words ``taken`` where another command holds it, and where it cannot be written. A
    command that is not ``alone`` shares the folder with others, whose runs have locks of their own.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with held(folder) if alone else nullcontext():
            yield
    except Timeout:
        raise ConfigError(f"--out {folder}: {taken}; choose another folder") from None
    except OSError as error:
        raise ConfigError(f"--out {folder}: cannot be written: {error.strerror or error}") from None
    except KeyboardInterrupt:
        print(f"\nfinished runs are kept in {folder}; the same command continues from them", flush=True)
        raise


class Store:
    """Runs kept in ``folder``: the config of the run in NAME is NAME.yaml, which begins with the hash of the code."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._code = fingerprint()
        folder.mkdir(exist_ok=True)

    def kept(self, name: str, config: dict[str, Any], failed: bool = False) -> tuple[Result, str] | None:
        """Return ``Result`` and message of a run that ended, with this config and this code; None without one.

        Runs that ``failed``, which are not kept but made again, are returned on request alone.
        """
        path = self.folder / f"{name}.yaml"
        if not path.is_file() or path.read_text(encoding="utf-8") != self._text(name, config):
            return None
        result = read_result(self.folder / name)
        message = result.summary.get("message", "") or self._read_error(name)
        if result.summary["status"] in ("done", "diverged") or (failed and message):
            return result, message
        return None

    def outcome(self, name: str, config: dict[str, Any]) -> tuple[Result, str]:
        """Return ``Result`` and message of one run, kept or new."""
        [(_, result, message)] = self.outcomes({name: config}, 1)
        return result, message

    def outcomes(
        self, configs: dict[str, dict[str, Any]], most: int, launch: Callable[[str], Process | Ended] | None = None
    ) -> Outcomes:
        """Yield (name, ``Result``, message) of every run of ``configs`` (name -> config), the kept runs first.

        ``launch(name)`` starts a missing run, ``most`` of them at a time; by default it is ``self.launch``.
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
            for name, result, message in ended:
                self._write_error(name, result, message)
                yield name, result, message

    def launch(self, name: str, config: dict[str, Any], seconds: float = math.inf) -> Process | Ended:
        """Start the run as a ``Process`` of at most ``seconds``; it replaces an earlier run of this name.

        Another command may have made the run meanwhile: it is ``Ended`` then. Raises filelock's Timeout while a run of
        another command, or of an earlier one that was killed, uses the folder.
        """
        folder = self.folder / name
        with ExitStack() as lock:
            lock.enter_context(held(self.folder, f"{name}.lock"))
            with held(folder):
                pass
            if kept := self.kept(name, config):
                return Ended(*kept)
            (folder / "summary.json").unlink(missing_ok=True)
            self._error_path(name).unlink(missing_ok=True)
            return Process(self.write(name, config), folder, seconds=seconds, lock=lock.pop_all())

    def write(self, name: str, config: dict[str, Any]) -> Path:
        """Write the config of a run into its file, and return the path."""
        path = self.folder / f"{name}.yaml"
        path.write_text(self._text(name, config), encoding="utf-8")
        return path

    def keep(self, name: str, config: dict[str, Any], files: dict[str, bytes], message: str) -> Result:
        """Store ``files`` (name -> content) and ``message`` of a run that was made elsewhere; return its ``Result``."""
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        for file, content in files.items():
            (folder / file).write_bytes(content)
        self.write(name, config)
        result = read_result(folder)
        self._write_error(name, result, message)
        return result

    def _error_path(self, name: str) -> Path:
        return self.folder / f"{name}.error"

    def _read_error(self, name: str) -> str:
        path = self._error_path(name)
        return path.read_text(encoding="utf-8") if path.is_file() else ""

    def _write_error(self, name: str, result: Result, message: str) -> None:
        """Store the ``message`` of a run whose summary has none: a process that crashed, or a goal not reached."""
        self._error_path(name).unlink(missing_ok=True)
        if message and "message" not in result.summary:
            self._error_path(name).write_text(message, encoding="utf-8")

    def _text(self, name: str, config: dict[str, Any]) -> str:
        return f"# code {self._code}\n{config_text(name, config)}"


class Engine:
    """Runs configs of a ``store``, ``processes`` at a time, with a progress bar on standard error if it is a terminal.

    ``seconds``: estimated time of each run, by name, for the bar. Use it as a context: the bar shows inside.
    """

    def __init__(self, store: Store, processes: int, seconds: dict[str, float]):
        self._store, self._processes = store, processes
        self._began = time.perf_counter()
        self._seconds = {name: estimate + START_SECONDS for name, estimate in seconds.items()}
        self._running: list[str] = []
        self._ended, self._done = 0, 0.0
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
            redirect_stdout=False,
            speed_estimate_period=3600.0,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task("", total=sum(self._seconds.values()))

    def __enter__(self) -> "Engine":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def outcomes(
        self, configs: dict[str, dict[str, Any]], limited: bool = False, source: Outcomes | None = None
    ) -> Outcomes:
        """Yield (name, ``Result``, message) of every run of ``configs`` (name -> config), the kept runs first.

        ``limited``: stop runs that take much longer than estimated. ``source``: outcomes from other machines, in place
        of processes on this one.
        """

        def launch(name: str) -> Process | Ended:
            limit = PATIENCE * self._seconds[name] + ALLOWANCE if limited else math.inf
            process = self._store.launch(name, configs[name], limit)
            self._running.append(name)
            self._show()
            return process

        with closing(source or self._store.outcomes(configs, self._processes, launch)) as ended:
            for name, result, message in ended:
                self._running = [each for each in self._running if each != name]
                self._ended += 1
                self._done += self._seconds[name]
                self._bar.update(self._task, completed=self._done)
                self._show()
                yield name, result, message

    def say(self, text: str) -> None:
        """Print a line of the result; the bar is hidden meanwhile, since the two would mix."""
        self._bar.stop()
        print(text, flush=True)
        self._bar.start()

    @property
    def seconds_left(self) -> float:
        """Time for the runs that have not ended, if they take as much over their estimates as the earlier ones."""
        return (time.perf_counter() - self._began) * (sum(self._seconds.values()) / max(self._done, 1e-9) - 1.0)

    def _show(self) -> None:
        text = "; ".join([f"{self._ended} of {len(self._seconds)} runs", *self._running])
        self._bar.update(self._task, description=text)
