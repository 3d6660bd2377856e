"""The version of the package, as in ``pyproject.toml``; in its own file, so that every room can have it."""

__version__ = "0.1.0"
