"""What is asked for, in the words of the command line: a config as a file, overrides as ``--set``."""

import json
import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from tisph.errors import TisphError

if TYPE_CHECKING:
    from tisph.config import Config

Asked: TypeAlias = "str | PathLike[str] | Mapping[str, Any] | Config"
"""A YAML file, a dict of what such a file says, or a checked config."""


@contextmanager
def config_file(config: Asked) -> Iterator[str]:
    """Yield the path of a YAML file that says ``config``; an error that names such a file calls it ``config``."""
    if isinstance(config, str | PathLike):
        yield fspath(config)
        return
    with tempfile.TemporaryDirectory(prefix="tisph-") as folder:
        path = Path(folder) / "run.yaml"
        resolved = getattr(config, "resolved_yaml", None)
        path.write_text(resolved() if resolved else json.dumps(_plain(config)), encoding="utf-8")
        try:
            yield str(path)
        except TisphError as error:
            raise type(error)(re.sub(rf"{re.escape(str(path))}(:\d+)?", "config", str(error))) from None


def loaded(config: Asked, overrides: Mapping[str, Any]) -> "Config":
    """Return what is asked for as a checked ``Config``; ConfigError where it is none."""
    from tisph.config import Config, load

    if isinstance(config, Config) and not overrides:
        return config
    with config_file(config) as path:
        return load(path, override_texts(overrides))


def override_texts(overrides: Mapping[str, Any]) -> list[str]:
    """Return ``key.path=value`` for each of ``overrides``, values by dotted key."""
    return [f"{key}={json.dumps(_plain(value))}" for key, value in overrides.items()]


def _plain(value: Any) -> Any:
    """Return ``value`` with what NumPy and others have for numbers and lists as those of Python."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple | range):
        return [_plain(each) for each in value]
    return value if value is None or isinstance(value, str | bool | int | float) else str(value)
