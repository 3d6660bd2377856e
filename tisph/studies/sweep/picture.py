"""The picture of a sweep: error and cost against each key that is a number, a line for each choice of the others."""

from tisph.report import style
from tisph.studies.sweep import table

MOST_LINES = 12


def plot(study, rows, path):
    """Draw into ``path``; nothing where no key has two numbers."""
    keys = [key for key in study.keys if any(len(points) > 1 for points in table.groups(study, rows, key).values())]
    if not keys:
        return False
    found = table.orders(study, rows)
    with style.plot_style():
        figure = style.plot_figure(rows=len(keys))
        grid = figure.subplots(len(keys), 2, squeeze=False)
        for axes, key in zip(grid, keys, strict=True):
            _panel(axes[0], table.groups(study, rows, key), f"error: {study.error}", key)
            _panel(axes[1], table.groups(study, rows, key, lambda each: each.seconds), "time of the loop [s]", key)
            power, count = found[key]
            axes[0].set_title(f"{study.error} ~ ({key})^{power:.2g}" + (f", median of {count}" if count > 1 else ""))
            if study.bound:
                axes[0].axhline(study.bound, color=style.EXACT, linewidth=0.9)
        figure.tight_layout()
        figure.save(path)
    return True


def _panel(axes, groups, label, key):
    colours = style.colours(max(len(groups), 2), 0.85)
    lines = []
    for (others, points), colour in zip(groups.items(), colours, strict=False):
        name = ", ".join(f"{other.rpartition('.')[2]} = {value}" for other, value in others)
        lines.append((points, {"marker": "o", "color": colour, "label": name, "markersize": 4}))
    draw_lines(axes, lines, label, key)
    if 1 < len(groups) <= MOST_LINES:
        axes.legend(fontsize=7, frameon=False)


def draw_lines(axes, lines, label, key):
    """Draw ``lines``, pairs of points (x, y) and options of matplotlib, on logarithmic axes with a tick at each x."""
    for points, options in lines:
        axes.loglog(*zip(*points, strict=True), **options)
    values = sorted({value for points, _ in lines for value, _ in points})
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.set_xticks([], minor=True)
    axes.set_xlabel(key)
    axes.set_ylabel(label)
    axes.grid(True, which="both")
