"""Maps of verdicts: which cell stands where, the same for tables and pictures, and the tables in Markdown."""

from dataclasses import dataclass

from tisph.studies.stability.judge import VERDICTS, Judgement
from tisph.studies.stability.matrix import AXES
from tisph.studies.stability.plan import Plan
from tisph.text_table import format_table

LABELS = {
    "reynolds": "Re {:g}",
    "jitter": "jitter {:g}",
    "across": "{} across",
    "step": "steps x {:g}",
    "sound": "c = {:g}",
    "aspect": "length {:g}",
    "solvent": "solvent {:g}",
    "elasticity": "E = {:g}",
    "t_star": "t* = {:g}",
}
"""How the value of an axis reads; the others speak for themselves."""


@dataclass(frozen=True)
class Row:
    """A cell's plan and what became of its run; ``steps`` and wall-clock ``seconds`` that it took."""

    plan: Plan
    judgement: Judgement
    steps: int = 0
    seconds: float = 0.0

    @property
    def cell(self):
        """Its cell."""
        return self.plan.cell

    @property
    def short(self):
        """The verdict in a word, with the error of a run that finished, where it has one."""
        found = self.judgement
        if found.verdict in ("stopped", "refused"):
            return found.verdict
        number = "" if found.error is None else f"{found.error:.0e}".replace("e-0", "e-")
        return number if number and found.verdict == "stable" else f"{found.verdict} {number}".strip()


def label(cell, axes):
    """Text for the values of ``axes``, names, of a cell."""
    return ", ".join(LABELS.get(axis, "{}").format(getattr(cell, axis)) for axis in axes)


def layout(part):
    """Labels of the columns and of the rows of a sub-matrix' map, and its cells by (row, column).

    Columns and rows are in the order in which the values of each axis first appear.
    """
    positions = {(label(cell, part.rows), label(cell, part.columns)): cell for cell in part.cells}
    return _labels(part, part.columns), _labels(part, part.rows), positions


def _labels(part, axes):
    order = {axis: list(dict.fromkeys(getattr(cell, axis) for cell in part.cells)) for axis in axes}
    cells = sorted(part.cells, key=lambda cell: [order[axis].index(getattr(cell, axis)) for axis in axes])
    return list(dict.fromkeys(label(cell, axes) for cell in cells))


def by_axis(part, rows):
    """Counts of the verdicts, in their order, of a sub-matrix without a map, by (axis, label of the value)."""
    counts = {}
    for axis, values in AXES.items():
        for value in values if isinstance(values[0], str) else sorted(values):
            own = [rows[cell].judgement.verdict for cell in part.cells if getattr(cell, axis) == value]
            found = next((cell for cell in part.cells if getattr(cell, axis) == value), None)
            if found:
                counts[axis, label(found, [axis])] = [own.count(verdict) for verdict in VERDICTS]
    return counts


def tables(parts, rows):
    """All maps as Markdown, from ``rows`` by cell; a stable cell shows its error alone, a required one a star."""
    texts = [_summary(parts, rows)]
    for part in parts:
        texts.append(f"### {part.title}\n\n{_map(part, rows) if part.columns else _counts(part, rows)}")
    return "\n\n".join(texts)


def _summary(parts, rows):
    lines = []
    for part in parts:
        verdicts = [rows[cell].judgement.verdict for cell in part.cells]
        met = [rows[cell].judgement.met for cell in part.cells if cell.required]
        lines.append((part.title, *(str(verdicts.count(each)) for each in VERDICTS), f"{sum(met)} of {len(met)}"))
    return format_table(("sub-matrix", *VERDICTS, "requirements met"), lines)


def _map(part, rows):
    columns, names, positions = layout(part)
    lines = [(name, *(_entry(rows, positions.get((name, column))) for column in columns)) for name in names]
    return format_table((", ".join(part.rows), *columns), lines)


def _entry(rows, cell):
    if cell is None:
        return ""
    star = "*" if cell.required else ""
    return f"{rows[cell].short}{star}"


def _counts(part, rows):
    lines = [(axis, value, *map(str, counts)) for (axis, value), counts in by_axis(part, rows).items()]
    return format_table(("axis", "value", *VERDICTS), lines)
