"""``history.csv`` as a record array."""

from pathlib import Path
from typing import Any

import numpy as np

from tisph.observers._storage import readable
from tisph.observers.history import read_rows


class History(np.recarray):
    """A row a time: ``history.t``, and by their names in the file ``history["u(y=0.5)"]`` and so on.

    Numbers are in the units of the config; where there is none it is NaN.
    """

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame``, a column a name; ImportError where there is no pandas."""
        import pandas  # not needed otherwise

        return pandas.DataFrame({name: self[name] for name in self.dtype.names or ()})


def read(path: Path) -> History:
    """Return what is in ``path``; no rows where there is no such file, or a run was killed before its first one."""
    with readable(path):
        names, rows = read_rows(path) if path.is_file() else (["t"], [])
        return np.array(rows, dtype=[(name, float) for name in names]).view(History)
