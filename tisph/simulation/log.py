"""``run.log``: start, end and errors of a run."""

import logging
import sys
from contextlib import contextmanager, suppress

from tisph.errors import TisphError

log = logging.getLogger("tisph")
log.addHandler(logging.NullHandler())  # else Python prints warnings a second time


def warn(text: str) -> None:
    """Print a warning and write it to ``run.log``."""
    log.warning(text)
    print(f"warning: {text}", file=sys.stderr)


@contextmanager
def logging_to(path, append):
    """Write what is logged meanwhile to ``path``, and the error that ends it, if any."""
    handler = logging.FileHandler(path, mode="a" if append else "w", encoding="utf-8")
    handler.handleError = lambda record: None  # a full disk: the results have errors of their own
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    except TisphError as error:
        log.error("%s", error)
        raise
    except Exception:
        log.exception("unexpected failure")
        raise
    finally:
        log.removeHandler(handler)
        with suppress(OSError):
            handler.close()
