"""Picture of a chain of runs: each number against the spacing, with the goal around the finest one and its bar."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tisph.config.schema import Config
from tisph.report import style
from tisph.report.labels import number, scientific


def draw(found: Mapping[str, Any], config: Config, path: Path) -> None:
    """Draw the contents of ``accuracy.json`` into ``path``."""
    with style.plot_style():
        figure = style.plot_figure(rows=len(found))
        for axes, (name, entry) in zip(figure.subplots(len(found), 1, squeeze=False)[:, 0], found.items(), strict=True):
            runs = [each for each in entry["runs"] if each["value"] is not None]
            spacings, values = [each["spacing"] for each in runs], [each["value"] for each in runs]
            end, value, bar, goal = entry["runs"][-1]["spacing"], entry["value"], entry["bar"], entry["goal"]
            if value is not None and goal is not None:
                band = {"color": style.EXACT, "alpha": 0.15, "linewidth": 0, "label": f"goal, {entry['asked']}"}
                axes.axhspan(value - goal, value + goal, **band)
            axes.plot(spacings, values, "o-", color="tab:blue", markersize=4, linewidth=0.8, label="runs")
            if value is not None and bar is not None:
                axes.errorbar([end], [value], [bar], color="tab:red", capsize=5, label=f"bar, {scientific(bar)}")
            shown = "" if value is None else f" = {number(value, 6)}"
            axes.set_title(f"{name}{shown}: {'reached' if entry['reached'] else 'not reached'}")
            axes.set_xscale("log")
            ticks = {each["spacing"]: each["particles_across"] for each in entry["runs"]}
            axes.set_xticks(list(ticks), [f"{spacing:.3g}\n{across} across" for spacing, across in ticks.items()])
            axes.set_xticks([], minor=True)
            axes.set_xlabel(f"spacing [{config.units.length}]")
            axes.set_ylabel(name)
            axes.legend(fontsize=8, frameon=False)
        figure.tight_layout()
        figure.save(path)
