"""Parts of Taichi 1.7.4 that are replaced by faster ones; a run with them is bitwise the same as one without.

Each file here tells what it replaces, why, and how much that saves. They stay off by themselves with any other version
than the one they were written for, with Quadrants, and with the environment variable ``TISPH_PLAIN_TAICHI=1``, which
changes how long a run takes and nothing else.
"""

from tisph.runtime.replacements._switch import OFF, SWITCH, VERSION

__all__ = ["OFF", "SWITCH", "VERSION", "install"]


def install():
    """Put all replacements in their places."""
    if OFF:
        return
    from tisph.runtime.replacements import _launches

    _launches.install()
