"""Scenes: geometry, boundary motion and exact solution of a flow. One file each."""

from typing import Any

from tisph import registry


def of(config: Any) -> Any:
    """Return the scene that ``config`` describes."""
    return registry.load("scenes", config.scene).Scene.from_config(config)
