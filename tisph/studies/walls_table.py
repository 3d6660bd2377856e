"""The comparison of wall treatments as text: a Markdown line for each row, what stopped, and what is recommended."""

import math

from tisph.studies.walls_cases import ARRANGEMENTS, COST_LIMIT, FLOWS, REFERENCE
from tisph.text_table import format_table

MEASURES = {"l2": "L2", "rms": "rms"}


def header(extent):
    """Titles of the columns."""
    errors = (f"{number} across" for number in extent.resolutions)
    return "flow", "treatment", "particles", "error", *errors, "order", "wall shear", "S_xy", "cost"


def widths(extent, treatments):
    """Widths of the columns: of the longest names, and of numbers as wide as there may be."""
    names = [flow.title for flow in FLOWS.values()], treatments, ARRANGEMENTS
    numbers = "rms", *["1.2e-03"] * len(extent.resolutions), "-1.23", "12.34 %", "1.2e-03", "12.34"
    widest = [*(max(each, key=len) for each in names), *numbers]
    return [max(map(len, column)) for column in zip(header(extent), widest, strict=True)]


def cells(row):
    """Cells of one ``Row``."""
    return (
        row.case.title,
        row.case.treatment,
        row.case.arrangement,
        MEASURES[row.case.measure],
        *(_number(error, ".1e", "stopped") for error in row.errors.values()),
        _number(row.order, ".2f"),
        f"{_number(100 * row.wall_shear, '.2g')} %".replace("- %", "-"),
        "" if row.stress_error is None else _number(row.stress_error, ".1e"),
        _number(row.cost, ".2f"),
    )


def legend(number):
    """What the columns mean, most of them at ``number`` particles across."""
    return "\n".join(
        [
            "- error: L2 = sqrt(sum (u - u_exact)^2 / sum u_exact^2), or, where u crosses zero, rms = "
            "sqrt(mean (u - u_exact)^2) / U; the largest of all times",
            "- order: power of the spacing with which the error falls, over all resolutions",
            f"- wall shear: error of the stress on the walls at {number} across, the larger one of both walls, "
            "over the larger exact stress",
            f"- S_xy: L2 error of the polymer's shear stress at {number} across",
            f"- cost: time for a step over that of {REFERENCE} in the same flow and arrangement, {number} across, of "
            "two runs at a time on one thread each: it needs a machine that does nothing else",
        ]
    )


def stopped_lines(rows):
    """A line for each run that did not reach its end, with its reason."""
    return [f"{name} stopped: {message}" for row in rows for name, message in row.stopped.items()]


def standings_table(found):
    """Markdown table of the ``Standing`` s: what the recommendation is made from."""
    header = ("treatment", "mean error", "mean cost", "runs stopped")
    lines = [(s.treatment, _number(s.error, ".2e"), _number(s.cost, ".2f"), str(s.stopped)) for s in found]
    return format_table(header, lines)


def laplacian_table(laplacians):
    """Markdown table of the errors of the discrete Laplacian (``walls_laplacian.Laplacian``), over the largest u_yy."""
    header = ("treatment", "profile", "particles", "kernel", "h/dx", "next to the wall", "order", "inside", "order")
    lines = []
    for each in laplacians:
        cells = [each.treatment, each.profile, each.arrangement, each.kernel, f"{each.ratio:g}"]
        for column, order in zip(zip(*each.errors.values(), strict=True), each.orders, strict=True):
            cells += [", ".join(_number(error, ".1e") for error in column), _number(order, ".2f")]
        lines.append(cells)
    return f"Errors of the discrete Laplacian\n\n{format_table(header, lines)}"


def recommendation(name, measured_at):
    """The sentence that names the treatment ``name``, None for none, and the rule."""
    rule = (
        f"the smallest geometric mean of the errors at {measured_at} across, over all flows and arrangements, among "
        f"the treatments that finish every run at a mean cost of at most {COST_LIMIT:g} x {REFERENCE}"
    )
    return f"recommended: {name}, which has {rule}" if name else f"recommended: none; no treatment qualifies for {rule}"


def _number(value, style, missing="-"):
    return format(value, style) if math.isfinite(value) else missing
