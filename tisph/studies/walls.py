"""Comparison of all wall treatments, ``tisph verify --walls``: tables, their picture, and the recommended treatment.

Flows, arrangements of the particles, resolutions and limits are data: ``suites/walls.yaml``. Every treatment runs in
every flow. Treatments qualify whose runs all reached their end, and whose step costs at most ``cost_limit`` times the
step of ``reference``. The recommended one has the smallest geometric mean, over all flows and arrangements, of the
errors at the resolution ``measured_at``. In a geometric mean a halved error counts the same in every flow, whatever the
size of the errors there; costs are averaged over the flows in the same way.

Every run is a process on one thread, two at a time. All are kept in the folder of the results: an interrupted
comparison continues where it stopped.

The discrete Laplacian next to a wall needs no runs. The particles get an exact profile u(y), the treatment makes the
wall particles, and the scheme evaluates the acceleration nu lap u + g once, without shifting. The error is the root
mean square of lap u - u_yy over the particles within a spacing of a wall, or beyond the reach of the walls, over the
largest |u_yy|. A profile of constant u_yy shows the error of order 0: in the rows next to a wall it is the error of the
treatment, elsewhere the error of the second moments.

Rows, Laplacians and standings are plain maps, as in ``walls.json``.
"""

import json
import math
import platform
from collections.abc import Callable, Collection, Iterator
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from tisph import registry, runtime, scenes, schemes
from tisph.config.loader import loaded
from tisph.measures.metrics import fitted_order, root_mean_square
from tisph.report.style import MUTED, constrained_figure, plot_style
from tisph.runtime import view
from tisph.studies import suites
from tisph.studies.expressions import Number, digits, merged
from tisph.studies.processes import Result
from tisph.studies.store import Engine, Store, claimed
from tisph.studies.sweep import StyledLine, draw_lines
from tisph.text_table import format_header, format_row, format_table
from tisph.version import __version__

PICTURE, NUMBERS = "verify_walls.png", "walls.json"
SIDE_BY_SIDE = 2

DATA = suites.study("walls")
FLOWS, ARRANGEMENTS, LAPLACIANS = DATA["flows"], DATA["arrangements"], DATA["laplacian"]
Case = tuple[str, str, str]
"""Flow, treatment and arrangement of the particles."""

REFERENCE, COST_LIMIT = DATA["reference"], DATA["cost_limit"]


def run(folder: str | Path, quick: bool = False) -> bool:
    """Print the comparison (``quick``: a small one) and leave its picture and numbers in ``folder``.

    Returns True if a treatment can be recommended. Raises ConfigError where ``folder`` cannot be used.
    """
    folder, extent = Path(folder), DATA["quick" if quick else "full"]
    treatments, measured_at = registry.names("walls"), extent["measured_at"]
    by_flow = [cases(flow, treatments, extent) for flow in FLOWS]
    columns, rows = widths(extent, treatments), []
    with claimed(folder, "another comparison is writing there"):
        print(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
        print(format_header(header(extent), columns), flush=True)
        names = [name for own in by_flow for name in runs(own, extent)]
        with Engine(Store(folder / "runs"), SIDE_BY_SIDE, dict.fromkeys(names, 0.0)) as engine:
            for own in by_flow:
                ended = engine.outcomes(runs(own, extent))
                for row in rows_of(own, {name: (result, message) for name, result, message in ended}, extent):
                    engine.say(format_row(cells(row), columns))
                    rows.append(row)
        found = {
            "measured_at": measured_at,
            "cost_limit": COST_LIMIT,
            "recommended": recommended(standings(rows, measured_at)),
            "treatments": standings(rows, measured_at),
            "rows": rows,
            "laplacians": laplacians(treatments, extent["resolutions"]),
            "version": __version__,
            "platform": platform.platform(),
        }
        numbers = json.dumps(_without_nan(found), indent=2, allow_nan=False)
        (folder / NUMBERS).write_text(numbers + "\n", encoding="utf-8")
        plot_walls(folder / PICTURE, rows, found["laplacians"])
        print(conclusion(found, f"picture: {folder / PICTURE}; numbers: {folder / NUMBERS}"))
        return found["recommended"] is not None


def _without_nan(data: Any) -> Any:
    if isinstance(data, dict):
        return {str(key): _without_nan(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_without_nan(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


def cases(flow: str, treatments: Collection[str], extent: dict[str, Any]) -> list[Case]:
    """Return the cases of a flow: every arrangement of each of ``treatments``."""
    return [(flow, name, arrangement) for name in treatments for arrangement in extent["arrangements"]]


def runs(cases: list[Case], extent: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the configs of the runs of ``cases`` by name."""
    return {name_of(case, number): config_of(case, number) for case in cases for number in extent["resolutions"]}


def name_of(case: Case, number: int) -> str:
    """Return the name of the run of a case at ``number`` particles across."""
    return f"{'-'.join(case).replace(' ', '_')}-{number}"


def config_of(case: Case, number: int) -> dict[str, Any]:
    """Return the config of the run of a case at ``number`` particles across."""
    flow, treatment, arrangement = case
    own = {"initial": {"jitter": ARRANGEMENTS[arrangement], "seed": 0}, "runtime": {"threads": 1}}
    return merged(_config(FLOWS[flow]["change"], treatment, number, DATA["columns"]), own)


def _config(change: dict[str, Any], treatment: str, number: int, columns: float) -> dict[str, Any]:
    size = {"discretisation": {"particles_across": number}, "geometry": {"length": digits(columns / number)}}
    return merged(DATA["base"], change, size, {"walls": {"treatment": {"type": treatment}}})


def rows_of(
    cases: list[Case], outcomes: dict[str, tuple[Result, str]], extent: dict[str, Any]
) -> Iterator[dict[str, Any]]:
    """Yield the numbers of each case of a flow from the (``Result``, message) of all their runs by name.

    ``errors``: particles across -> largest error of all times; ``order``: order of convergence; ``wall_shear``: error
    of the wall shear stress; ``stress_error``: error of the polymer stress, None without polymer; ``cost``: time of a
    step over the time of a step of ``REFERENCE``; ``stopped``: messages of runs that did not reach their end. NaN where
    a run gave no number.
    """

    def step_seconds(case: Case) -> float:
        summary = outcomes[name_of(case, measured_at)][0].summary
        cost = summary.get("cost") if summary["status"] == "done" else None
        return cost["wall_loop_s"] / cost["steps"] if cost else math.nan

    def largest(number: int, measure: str) -> float:
        result, value = outcomes[name_of(case, number)][0], Number(measure, "measure")
        return float(np.max([value(result, result.sample(time)) for time in flow["t_star"]]))

    measured_at = extent["measured_at"]
    polymer = "rheology" in FLOWS[cases[0][0]]["change"].get("fluid", {})
    seconds = {case: step_seconds(case) for case in cases}
    reference = {case[2]: seconds[case] for case in cases if case[1] == REFERENCE}
    for case in cases:
        flow, names = FLOWS[case[0]], [name_of(case, number) for number in extent["resolutions"]]
        errors = {number: largest(number, flow["measure"]) for number in extent["resolutions"]}
        yield {
            "case": dict(zip(("flow", "treatment", "arrangement"), case, strict=True)),
            "errors": errors,
            "order": fitted_order(errors.keys(), list(errors.values())),
            "wall_shear": largest(measured_at, "wall_shear"),
            "stress_error": largest(measured_at, "shear_stress_l2") if polymer else None,
            "cost": seconds[case] / reference[case[2]],
            "stopped": {name: outcomes[name][1] for name in names if outcomes[name][1]},
            "t_star": flow["t_star"],
            "measure": flow["measure"],
        }


def standings(rows: Collection[dict[str, Any]], measured_at: int) -> list[dict[str, Any]]:
    """Return geometric means of errors and costs, and how many runs stopped, of each treatment in ``rows``."""
    found = []
    for name in dict.fromkeys(row["case"]["treatment"] for row in rows):
        own = [row for row in rows if row["case"]["treatment"] == name]
        numbers = [row["errors"][measured_at] for row in own], [row["cost"] for row in own]
        error, cost = (float(np.exp(np.mean(np.log(each)))) for each in numbers)
        stopped = sum(len(row["stopped"]) for row in own)
        found.append({"treatment": name, "error": error, "cost": cost, "stopped": stopped})
    return found


def recommended(found: list[dict[str, Any]]) -> str | None:
    """Return the treatment with the smallest mean error of those without a stopped run and within the cost limit."""
    finished = [one for one in found if not one["stopped"] and math.isfinite(one["error"])]
    eligible = [one for one in finished if one["cost"] <= COST_LIMIT]
    return min(eligible, key=lambda one: one["error"])["treatment"] if eligible else None


ROUND_OFF = 1e-11
"""Error of an exact Laplacian: rounding of a velocity over a time step."""

PROFILES = {
    "bent": (lambda y: 4.0 * y * (1.0 - y), lambda y: -8.0 + 0.0 * y),
    "straight": (
        lambda y: y + np.sin(2.0 * np.pi * y) / (2.0 * np.pi),
        lambda y: -2.0 * np.pi * np.sin(2.0 * np.pi * y),
    ),
}
"""Functions u and u_yy of a driven flow, bent at the walls, and of a sheared flow, whose u_yy vanishes there."""


def laplacians(treatments: Collection[str], resolutions: list[int]) -> list[dict[str, Any]]:
    """Return each treatment with the usual kernel, then the consistent images with each kernel and ratio."""
    settings: list[tuple] = [(name, profile, resolutions) for name in treatments for profile in PROFILES]
    for kernel, ratios in LAPLACIANS["kernels"].items():
        several = [(profile, resolutions[-3:][:2], kernel, ratio) for ratio in ratios for profile in PROFILES]
        settings += [("consistent_image", *setting) for setting in several]
    return [each for setting in settings for each in measured(*setting)]


def measured(
    name: str, profile: str, resolutions: list[int], kernel: str = "quintic_spline", ratio: float = 1.0
) -> list[dict[str, Any]]:
    """Return errors (next to the walls, inside) by particles across, and the orders of both, of each arrangement.

    Each row of particles of ``rows slid`` is displaced along x at random, as shear flow does. An error of round-off has
    no order.
    """
    runtime.start("f64", 1)
    errors: dict[str, dict[int, tuple[float, ...]]] = {}
    for number in resolutions:
        plain = _config(LAPLACIANS["profiles"][profile], name, number, LAPLACIANS["columns"])
        config = loaded(merged(plain, {"discretisation": {"kernel": kernel, "smoothing_ratio": ratio}}), {})
        scene = scenes.of(config).in_flow_frame()
        scheme: Any = schemes.build(config, scene, [config.time.end], serial=True)
        view(scheme.operators.shift_speed)[...] = 0.0
        x, y = scene.lattice()
        slid = scene.spacing * np.random.default_rng(0).uniform(size=number)[(y / scene.spacing).astype(int)]
        places = {"lattice": (x, y), "rows slid": ((x + slid) % scene.extent[0], y)}
        places[f"jitter {LAPLACIANS['jitter']}"] = scene.jittered(0, LAPLACIANS["jitter"])
        for arrangement, place in places.items():
            errors.setdefault(arrangement, {})[number] = _error(scheme, *PROFILES[profile], *place)
    settings = {"treatment": name, "profile": profile, "kernel": kernel, "ratio": ratio}
    rows = []
    for arrangement, found in errors.items():
        both = zip(*found.values(), strict=True)
        orders = [fitted_order(found.keys(), each) if min(each) > ROUND_OFF else math.nan for each in both]
        rows.append({**settings, "arrangement": arrangement, "errors": found, "orders": orders})
    return rows


def _error(scheme: Any, velocity: Callable, curvature: Callable, x: np.ndarray, y: np.ndarray) -> tuple[float, ...]:
    """Return the error of the Laplacian of a profile next to the walls, and inside."""
    scene, particles = scheme.scene, scheme.particles
    scheme.length = 0.0  # no step is pending
    scheme.start(np.stack([x, y], 1), np.stack([velocity(y), 0.0 * y], 1))
    # the middle of the first step has the velocity u + dt/2 (nu lap u + g)
    fluid = np.s_[scheme.now, : particles.fluid]
    gained = view(particles.mid_velocity)[fluid][:, 0] - view(particles.velocity)[fluid][:, 0]
    height = view(particles.position)[fluid][:, 1]
    laplacian = (2.0 * gained / scheme.length - scene.acceleration) / scene.kinematic_viscosity
    error = (laplacian - curvature(height)) / np.abs(curvature(np.linspace(0.0, 1.0, 401))).max()
    depth = np.minimum(height, scene.gap - height)
    parts = error[depth < scene.spacing], error[depth > scheme.lists.cutoff]
    return tuple(float(root_mean_square(part)) if part.size else math.nan for part in parts)


def header(extent: dict[str, Any]) -> tuple[str, ...]:
    """Return the titles of the columns."""
    errors = (f"{number} across" for number in extent["resolutions"])
    return "flow", "treatment", "particles", "error", *errors, "order", "wall shear", "S_xy", "cost"


def widths(extent: dict[str, Any], treatments: Collection[str]) -> list[int]:
    """Return the widths of the columns, for the longest names and the widest numbers."""
    names = [flow["title"] for flow in FLOWS.values()], treatments, ARRANGEMENTS
    numbers = "rms", *["1.2e-03"] * len(extent["resolutions"]), "-1.23", "12.34 %", "1.2e-03", "12.34"
    widest = [*(max(each, key=len) for each in names), *numbers]
    return [max(map(len, column)) for column in zip(header(extent), widest, strict=True)]


def cells(row: dict[str, Any]) -> tuple[str, ...]:
    """Return the cells of a row."""
    flow, treatment, arrangement = row["case"].values()
    return (
        FLOWS[flow]["title"],
        treatment,
        arrangement,
        row["measure"].replace("l", "L"),
        *(_number(error, ".1e", "stopped") for error in row["errors"].values()),
        _number(row["order"], ".2f"),
        f"{_number(100 * row['wall_shear'], '.2g')} %".replace("- %", "-"),
        "" if row["stress_error"] is None else _number(row["stress_error"], ".1e"),
        _number(row["cost"], ".2f"),
    )


def conclusion(found: dict[str, Any], files: str) -> str:
    """Return the text below the rows: legend, runs that stopped, standings, Laplacians and the recommendation."""
    means = [
        (one["treatment"], _number(one["error"], ".2e"), _number(one["cost"], ".2f"), str(one["stopped"]))
        for one in found["treatments"]
    ]
    header = ("treatment", "profile", "particles", "kernel", "h/dx", "next to the wall", "order", "inside", "order")
    lines = []
    for each in found["laplacians"]:
        line = [each["treatment"], each["profile"], each["arrangement"], each["kernel"], f"{each['ratio']:g}"]
        for column, order in zip(zip(*each["errors"].values(), strict=True), each["orders"], strict=True):
            line += [", ".join(_number(error, ".1e") for error in column), _number(order, ".2f")]
        lines.append(line)
    name, number = found["recommended"], found["measured_at"]
    rule = DATA["rule"].format(number=number, reference=REFERENCE, limit=COST_LIMIT)
    texts = [
        "\n".join(f"- {line}" for line in DATA["legend"]).format(number=number, reference=REFERENCE),
        "\n".join(f"{run} stopped: {why}" for row in found["rows"] for run, why in row["stopped"].items()),
        format_table(("treatment", "mean error", "mean cost", "runs stopped"), means),
        f"Errors of the discrete Laplacian\n\n{format_table(header, lines)}",
        files,
        f"recommended: {name}, which has {rule}" if name else f"recommended: none; no treatment qualifies for {rule}",
    ]
    return "\n" + "\n\n".join(filter(None, texts))


def _number(value: float, style: str, missing: str = "-") -> str:
    return format(value, style) if math.isfinite(value) else missing


# Okabe and Ito's colours, which colour-blind people can distinguish; the markers distinguish the treatments without.
LOOKS = (("#d55e00", "v"), ("#009e73", "s"), ("#56b4e9", "o"), ("#000000", "x"), ("#cc79a7", "D"), ("#e69f00", "P"))
STYLES = dict(zip(ARRANGEMENTS, ("-", "--"), strict=True))
COLUMNS = 3


def plot_walls(path: Path, rows: Collection[dict[str, Any]], laplacians: list[dict[str, Any]]) -> None:
    """Write the picture to ``path``: error against resolution, a panel for each flow and each profile.

    Runs that stopped leave gaps.
    """
    treatments = dict.fromkeys(row["case"]["treatment"] for row in rows)
    looks: dict[str, dict[str, Any]] = {
        name: {"color": colour, "marker": marker, "markerfacecolor": "none", "markersize": 7}
        for name, (colour, marker) in zip(treatments, cycle(LOOKS), strict=False)
    }
    drawn = {row["case"]["arrangement"]: STYLES[row["case"]["arrangement"]] for row in rows}
    panels = _panels(rows, laplacians, looks, drawn)
    with plot_style():
        height = -(-len(panels) // COLUMNS)
        figure = constrained_figure((12.0, 3.9 * height + 0.9), dpi=120)
        figure.set_layout_engine("constrained", w_pad=0.1, h_pad=0.1)
        axes = figure.subplots(height, COLUMNS, squeeze=False).ravel()
        for each, (title, label, lines) in zip(axes, panels, strict=False):
            draw_lines(each, lines, label, "particles across the gap")
            each.set_title(title, fontsize=11)
        for each in axes[len(panels) :]:
            each.axis("off")
        handles = [Line2D([], [], label=name, **look) for name, look in looks.items()]
        handles += [Line2D([], [], color="#000000", linestyle=style, label=name) for name, style in drawn.items()]
        handles.append(Line2D([], [], color=MUTED, linewidth=0.8, label="second order"))
        figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
        figure.savefig(path)


def _panels(
    rows: Collection[dict[str, Any]],
    laplacians: list[dict[str, Any]],
    looks: dict[str, dict[str, Any]],
    drawn: dict[str, str],
) -> list[tuple[str, str, list[StyledLine]]]:
    """Return title, label and lines of each panel: errors of a flow, or of Laplacians next to a wall.

    Laplacians are drawn with the usual kernel only.
    """

    def line(points: dict[int, float], of: dict[str, Any]) -> StyledLine:
        return points.items(), {**looks[of["treatment"]], "linestyle": drawn[of["arrangement"]], "linewidth": 1.4}

    panels = []
    for flow in dict.fromkeys(row["case"]["flow"] for row in rows):
        own = [row for row in rows if row["case"]["flow"] == flow]
        lines = [line(row["errors"], row["case"]) for row in own]
        scaled = [error * number**2 for row in own for number, error in row["errors"].items() if error > 0]
        if scaled:  # a line of slope -2 below all others
            slope = [(number, 0.6 * min(scaled) / number**2) for number in own[0]["errors"]]
            lines.append((slope, {"color": MUTED, "linewidth": 0.8}))
        title = f"{FLOWS[flow]['title']}, t* = {', '.join(f'{time:g}' for time in own[0]['t_star'])}"
        panels.append((title, f"{own[0]['measure'].replace('l', 'L')} error", lines))
    usual = [each for each in laplacians if (each["kernel"], each["ratio"]) == ("quintic_spline", 1.0)]
    for profile in dict.fromkeys(each["profile"] for each in usual):
        lines = []
        for each in usual:
            near = {number: error for number, (error, _) in each["errors"].items() if error > ROUND_OFF}
            if near and each["profile"] == profile and each["arrangement"] in drawn:
                lines.append(line(near, each))
        title = f"Laplacian next to the wall, {profile} profile"
        panels.append((title, "error of the Laplacian over $u_{yy}$", lines))
    return panels
