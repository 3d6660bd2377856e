"""Events of a run, its progress and its error: text for people, or JSON lines for a program that reads them.

The process of a run writes events to standard error; ``tisph.run`` reads them there, among other lines.
"""

import json
import sys
from typing import Any

_as_json = False


def write_as_json() -> None:
    """Write all later events as JSON lines: ``{"progress": [part, words]}`` or ``{"error": text}``."""
    global _as_json
    _as_json = True


def progress(part: float, words: str) -> None:
    """Write the part of a run that is done, 0 to 1, and words about it."""
    text = json.dumps({"progress": [part, words]}) if _as_json else f"{part:4.0%}  {words}"
    print(text, file=sys.stderr, flush=True)


def error(text: str) -> None:
    """Write the message of the error that ends a command."""
    print(json.dumps({"error": text}) if _as_json else f"error: {text}", file=sys.stderr)


def read(line: str) -> dict[str, Any]:
    """Return the event in a ``line`` that was written as JSON, an empty one for any other text."""
    try:
        found = json.loads(line)
    except ValueError:
        return {}
    return found if isinstance(found, dict) and found.keys() <= {"progress", "error"} else {}
