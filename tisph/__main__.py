"""The ``tisph`` command, also as ``python -m tisph``."""

import contextlib
import os

from tisph.errors import INTERRUPTED


def main() -> None:
    """Run the command line; Ctrl-C while it is still being imported is one line, too."""
    try:
        import signal  # it takes milliseconds

        signal.signal(signal.SIGINT, _leave)
    except KeyboardInterrupt:
        _leave()
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # the search in all installed packages takes time
    # matrices are small: NumPy's threads double the processor time, and wait for one another on a busy machine
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from tisph.cli import main as command

    command()


def _leave(*_: object) -> None:
    # in some calls of Python during an import an exception would be lost, or end in a traceback
    with contextlib.suppress(OSError):
        os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
