"""Scenes: geometry, boundary motion and exact solution of a flow. One file each; ``_scene.py`` has the protocol."""

from typing import TYPE_CHECKING

from tisph import registry

if TYPE_CHECKING:
    from tisph.config.schema import Config
    from tisph.scenes._scene import Scene


def of(config: "Config") -> "Scene":
    """Return the scene that ``config`` describes."""
    from tisph.scenes._spacing import with_sources  # the drawing process, which takes scenes, does without configs
    from tisph.scenes._substances import with_substances

    flow = with_sources(registry.load("scenes", config.scene).Scene.from_config(config), config)
    return with_substances(flow, config)
