"""Small configs that tests start from, by name: those of flows.yaml."""

from pathlib import Path
from typing import Any

from tisph.config.yaml_text import dump, parse

FLOWS = parse(Path(__file__).with_name("flows.yaml").read_text(encoding="utf-8")).data


def flow_config(name: str) -> dict[str, Any]:
    """Return the config with this name."""
    return FLOWS[name]


def flow_text(name: str) -> str:
    """Return the same as YAML text."""
    return dump(FLOWS[name])
