"""The run itself: from a config to a folder of results."""

from tisph.simulation.run import run

__all__ = ["render", "run"]


def render(run_dir, overrides=(), gif=False):
    """Draw movie and pictures again from the files of a run; see ``drawing.render``."""
    from tisph.simulation import drawing  # matplotlib, which nothing before it needs, takes a fifth of a second

    return drawing.render(run_dir, overrides, gif)
