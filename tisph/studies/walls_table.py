"""The comparison of wall treatments as text: a Markdown line for each row, what stopped, and what is recommended."""

import math

from tisph.studies.walls_cases import ARRANGEMENTS, COST_LIMIT, FLOWS, REFERENCE
from tisph.text_table import format_table

MEASURES = {"l2": "L2", "rms": "rms"}


class Columns:
    """Columns of the table at the particle numbers ``resolutions``, one of which is ``measured_at``."""

    def __init__(self, resolutions, measured_at, treatments):
        self.resolutions = resolutions
        self.measured_at = measured_at
        errors = (f"{number} across" for number in resolutions)
        self.header = ("flow", "treatment", "particles", "error", *errors, "order", "wall shear", "S_xy", "cost")
        longest = [max(names, key=len) for names in (self._titles(), treatments, ARRANGEMENTS)]
        widest = [*longest, "rms", *["1.2e-03"] * len(resolutions), "-1.23", "12.34 %", "1.2e-03", "12.34"]
        self.widths = [max(map(len, column)) for column in zip(self.header, widest, strict=True)]

    def cells(self, row):
        """Cells of one ``Row``."""
        case = row.case
        return (
            case.title,
            case.treatment,
            case.arrangement,
            MEASURES[case.measure],
            *(_number(row.errors[number], ".1e", "stopped") for number in self.resolutions),
            _number(row.order, ".2f"),
            f"{_number(100 * row.wall_shear, '.2g')} %".replace("- %", "-"),
            "" if row.stress_error is None else _number(row.stress_error, ".1e"),
            _number(row.cost, ".2f"),
        )

    def legend(self):
        """What the columns mean."""
        number = self.measured_at
        return "\n".join(
            [
                "- error: L2 = sqrt(sum (u - u_exact)^2 / sum u_exact^2), or, where u crosses zero, rms = "
                "sqrt(mean (u - u_exact)^2) / U",
                "- order: power of the spacing with which the error falls, over all resolutions",
                f"- wall shear: error of the stress on the walls at {number} across, the larger one of both walls, "
                "over the larger exact stress",
                f"- S_xy: L2 error of the polymer's shear stress at {number} across",
                f"- cost: time for a step over that of {REFERENCE} in the same flow and arrangement, {number} across "
                "in a channel of length 2, one run at a time on one thread",
            ]
        )

    @staticmethod
    def _titles():
        return [flow.title for flow in FLOWS.values()]


def stopped_lines(rows):
    """A line for each run that did not reach its end, with its reason."""
    return [f"{name} stopped: {message}" for row in rows for name, message in row.stopped.items()]


def standings_table(found):
    """Markdown table of the ``Standing`` s: what the recommendation is made from."""
    header = ("treatment", "mean error", "mean cost", "runs stopped")
    lines = [(s.treatment, _number(s.error, ".2e"), _number(s.cost, ".2f"), str(s.stopped)) for s in found]
    return format_table(header, lines)


def recommendation(name, measured_at):
    """The sentence that names the treatment ``name``, None for none, and the rule."""
    rule = (
        f"the smallest geometric mean of the errors at {measured_at} across, over all flows and arrangements, among "
        f"the treatments that finish every run at a mean cost of at most {COST_LIMIT:g} x {REFERENCE}"
    )
    return f"recommended: {name}, which has {rule}" if name else f"recommended: none; no treatment qualifies for {rule}"


def _number(value, style, missing="-"):
    return format(value, style) if math.isfinite(value) else missing
