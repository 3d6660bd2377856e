"""Room for labels and legend of a plot: what matplotlib's constrained layout does in five times the time.

That engine measures everything twice, and matplotlib prepares all ticks again for each measurement.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend

_PAD = 0.12  # inches, around axes with their labels


def set_margins(figure: Figure, axes: np.ndarray, legend: Legend, *, below: bool) -> None:
    """Give all ``axes`` (rows, columns) of ``figure`` the same size, as large as their labels and the legend leave it.

    The legend is at the right, or ``below``. Axes of a column, and of a row, have the same room around them.
    """
    pad, (width, height) = _PAD * figure.dpi, figure.bbox.size
    renderer = figure.canvas.get_renderer()
    around = np.array([[_labels(one, renderer) for one in row] for row in axes]) + pad  # left, bottom, right, top
    left, right = around[:, :, 0].max(axis=0), around[:, :, 2].max(axis=0)
    bottom, top = around[:, :, 1].max(axis=1), around[:, :, 3].max(axis=1)
    box = legend.get_window_extent(renderer)
    right[-1] += 0.0 if below else width - box.x0
    bottom[-1] += box.y1 if below else 0.0
    across = (width - left.sum() - right.sum()) / axes.shape[1]
    down = (height - bottom.sum() - top.sum()) / axes.shape[0]
    for row, column in np.ndindex(axes.shape):
        x = left[: column + 1].sum() + right[:column].sum() + column * across
        y = height - top[: row + 1].sum() - bottom[:row].sum() - (row + 1) * down
        axes[row, column].set_position((x / width, y / height, across / width, down / height))


def _labels(axes: Axes, renderer) -> tuple[float, float, float, float]:
    """Return how far ticks and labels stand out of ``axes`` at the left, bottom, right and top, in pixels."""
    inner, boxes = axes.bbox, [axis.get_tightbbox(renderer) for axis in (axes.xaxis, axes.yaxis)]
    boxes = [inner, *(box for box in boxes if box)]
    return (
        inner.x0 - min(box.x0 for box in boxes),
        inner.y0 - min(box.y0 for box in boxes),
        max(box.x1 for box in boxes) - inner.x1,
        max(box.y1 for box in boxes) - inner.y1,
    )
