"""``history.csv`` as a record array."""

from pathlib import Path
from typing import Any

import numpy as np

from tisph.observers._files import readable


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
    names, rows = ["t"], []
    if path.is_file():
        with readable(path):
            text = path.read_text(encoding="utf-8")
            whole = text[: text.rfind("\n") + 1].splitlines()  # a killed run may leave a last line without its end
            lines = [line for line in whole if not line.startswith("#")]
            names = lines[0].split(",") if lines else names
            rows = [tuple(float(cell or "nan") for cell in line.split(",")) for line in lines[1:]]
    with readable(path):
        return np.array(rows, dtype=[(name, float) for name in names]).view(History)
