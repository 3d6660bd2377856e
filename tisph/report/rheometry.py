"""The picture of what a rheologist reads: curves of a run beside theory and reference."""

from tisph.report import style

COLOURS = {".": style.PARTICLES, "-": style.EXACT, "--": style.MUTED}


def plot_reading(path, name, reading):
    """Write a PNG of the curves of a ``verification.rheometry.Reading``, a row of axes for each pair of labels."""
    axes_labels = list(dict.fromkeys(curve[0] for curve in reading.curves))
    with style.plot_style():
        figure = style.plot_figure(len(axes_labels))
        for row, labels in enumerate(axes_labels):
            axes = figure.add_subplot(len(axes_labels), 1, row + 1)
            for own, label, x, y, kind in reading.curves:
                if own == labels:
                    axes.plot(x, y, kind, label=label, color=COLOURS[kind])
            axes.set_xlabel(labels[0])
            axes.set_ylabel(labels[1])
            axes.grid(True)
            axes.legend(frameon=False)
        figure.suptitle(f"{name}: {reading.title}")
        figure.tight_layout()
        figure.save(path)
