"""The verification page's case beside ours: VM-LSDYNA-SPH-001, "2D Laminar Couette Flow Simulation (SPH)".

The page gives fitted slopes of 0.49 and 0.48 1/s at 1.8 and 2.7 s, errors of 2 % and 4 % against the steady
slope U/H = 0.5 1/s that it calls reached. Its numbers fit no single flow: water's viscosity is printed as
ten times itself, Re = 100 belongs to neither value, and from rest the steady state is far away at 2.7 s. So
each reading of it is run, and compared with the exact solution of that reading.
"""

from tisph.text_table import format_table

READINGS = {
    "re50": "water, from rest",
    "re5": "viscosity as typed, from rest",
    "developed": "water, from the linear profile",
    "steady": "water, from rest to t* = 1",
    "re100": "Re as printed, from rest",
    "as_printed": "water, linear profile, bulk modulus as printed",
}
"""Readings of the page, each a config ``configs/vm_sph_001_NAME.yaml``."""

COSTS = {
    "steady": " (110 000 steps: a minute or two)",
    "as_printed": " (660 000 steps of 4 microseconds: about six minutes)",
}
"""Why a reading takes long."""

TARGET_SLOPE = 0.5
"""Steady slope U/H in 1/s, the page's target."""

PAGE_SLOPES = {1.8: "0.49 (2 %)", 2.7: "0.48 (4 %)"}
"""Slopes that the page gives, in 1/s, and their errors against its target, by output time in s."""

HEADER = (
    "reading",
    "Re",
    "Mach",
    "t [s]",
    "t*",
    "page: slope (error)",
    "slope",
    "exact slope",
    "off exact",
    "off 0.5",
    "intercept [cm/s]",
    "L2",
    "centreline (exact) [cm/s]",
    "bottom shear (exact) [Pa]",
    "top shear (exact) [Pa]",
    "density off",
)

PASCAL = 100.0
"""1 kg/(cm s^2), the unit of stress in the page's system of units, in Pa."""


def page_table(summaries):
    """Markdown table with a row for each sample of each reading, and below it what the readings are.

    ``summaries`` maps names of ``READINGS`` to the contents of their ``summary.json``, in kg, cm and s. A
    run that stopped early shows its status.
    """
    rows = []
    for name, summary in summaries.items():
        stopped = "" if summary["status"] == "done" else f" ({summary['status']})"
        samples = summary.get("samples", [])
        rows += [_row(name + stopped, summary["numbers"], sample) for sample in samples]
        if not samples:
            rows.append([name + stopped] + [""] * (len(HEADER) - 1))
    legend = "; ".join(f"{name}: {READINGS[name]}" for name in summaries)
    return f"{format_table(HEADER, rows)}\n\n{legend}."


def _row(label, numbers, sample):
    return [
        label,
        f"{numbers['reynolds']:.4g}",
        f"{numbers['mach']:.3g}",
        f"{sample['t']:g}",
        f"{sample['t_star']:.4g}",
        PAGE_SLOPES.get(round(sample["t"], 6), ""),
        _number(sample["slope"], ".5f"),
        _number(sample["slope_exact"], ".5f"),
        _error(sample["slope"], sample["slope_exact"]),
        _error(sample["slope"], TARGET_SLOPE),
        _number(sample["intercept"], ".5f"),
        _number(sample["l2"], ".1e"),
        _with_exact(sample, "centreline", ".5f"),
        _with_exact(sample, "wall_shear_bottom", ".3g", PASCAL),
        _with_exact(sample, "wall_shear_top", ".3g", PASCAL),
        _number(sample["density_variation"], ".1e"),
    ]


def _number(value, style, scale=1.0):
    """Value times ``scale`` in the given style; a dash where a run that went wrong has none."""
    if value is None:
        return "-"
    text = format(scale * value, style)
    return text.lstrip("-") if float(text) == 0 else text


def _with_exact(sample, quantity, style, scale=1.0):
    value, exact = (_number(sample[key], style, scale) for key in (quantity, f"{quantity}_exact"))
    return f"{value} ({exact})"


def _error(value, reference):
    """Relative error in per cent, without a sign."""
    if value is None:
        return "-"
    error = 100 * abs(value / reference - 1)
    return "< 1e-6 %" if error < 1e-6 else f"{error:.2g} %"
