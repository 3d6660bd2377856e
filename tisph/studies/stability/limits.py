"""Limits that the matrix shows: what defaults, warnings and guards can be derived from."""

import math
from itertools import product

from tisph.equation_of_state import SCALE_RATIO
from tisph.studies.stability.cells import Cell
from tisph.studies.stability.judge import SILENT_FAILURE, VERDICTS
from tisph.studies.stability.matrix import TABLE
from tisph.text_table import format_table

ARRANGEMENTS = {"lattice": lambda cell: cell.jitter == 0, "disordered": lambda cell: cell.jitter > 0}
FLUIDS = {
    "": lambda cell: not (cell.has_polymer or cell.two_dimensional),
    ", Oldroyd-B (of the solvent)": lambda cell: cell.has_polymer,
    ", doubly periodic": lambda cell: cell.doubly_periodic,
    ", curved walls": lambda cell: cell.curved_walls,
}


def limits(rows):
    """Return what the ``rows``, by cell, show: a dict of two lists of dicts.

    ``ranges``: of a quantity, the largest value ``fine`` below which no run failed, and the smallest that did, ``not``
    (None for none). Of the time steps, over the default, every run that is not stable failed; of the cell Reynolds
    number U dx / nu, nu that of the solvent, those that stopped or failed silently. ``largest``: by scheme and verdict,
    the largest density variation and transverse velocity at the end of runs in channels that finished.
    """
    return {"ranges": [*_steps(rows), *_cell_reynolds(rows)], "largest": list(_largest(rows))}


def tables(found):
    """Return limits as Markdown."""
    ranges = [(each["what"], _text(each["fine"]), _text(each["not"])) for each in found["ranges"]]
    largest = [
        (each["what"], f"{each['density_variation']:.1e}", f"{each['transverse_velocity']:.1e}")
        for each in found["largest"]
    ]
    return "\n\n".join(
        [
            format_table(("limit", "no failure up to", "first failure at"), ranges),
            format_table(("largest at the end", "density variation (c = 10)", "max abs(v) / U"), largest),
        ]
    )


def _text(number):
    return "-" if number is None else f"{number:.3g}"


def _steps(rows):
    axes = TABLE["values"]
    for sound in axes["sound"]:
        for jitter in axes["jitter"]:
            cells = [Cell(jitter=jitter, sound=sound, step=step) for step in axes["step"]]
            known = [(cell.step, rows[cell].judgement.verdict != "stable") for cell in cells if cell in rows]
            if known:
                yield {"what": f"steps over the default, explicit, c = {sound:g}, jitter {jitter:g}", **_range(known)}


def _cell_reynolds(rows):
    """Of runs with the default walls, steps and sound speed."""
    usual = {cell: row for cell, row in rows.items() if cell.usual and row.judgement.verdict != "refused"}
    for scheme in dict.fromkeys(cell.scheme for cell in usual):
        for (fluid, of), (name, belongs) in product(FLUIDS.items(), ARRANGEMENTS.items()):
            own = [row for cell, row in usual.items() if cell.scheme == scheme and of(cell) and belongs(cell)]
            known = [(row.cell.cell_reynolds, row.judgement.verdict in ("stopped", SILENT_FAILURE)) for row in own]
            if known:
                yield {"what": f"cell Reynolds number{fluid}, {scheme}, {name}", **_range(known)}


def _range(known):
    """From pairs of a value and whether a run failed there."""
    first = min((value for value, failed in known if failed), default=None)
    below = math.inf if first is None else first
    return {"fine": max((value for value, _ in known if value < below), default=None), "not": first}


def _largest(rows):
    """Density varies with the square of the Mach number: that of other sound speeds is taken to the default's."""
    for scheme in dict.fromkeys(cell.scheme for cell in rows):
        for verdict in VERDICTS:
            own = [row for row in rows.values() if row.cell.scheme == scheme and row.judgement.verdict == verdict]
            known = [row for row in own if row.judgement.transverse is not None and verdict != "stopped"]
            if known:
                yield {
                    "what": f"{scheme}, {verdict}",
                    "density_variation": max(
                        row.judgement.density_variation * (row.cell.sound / SCALE_RATIO) ** 2 for row in known
                    ),
                    "transverse_velocity": max(row.judgement.transverse for row in known),
                }
