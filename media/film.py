"""The film at the top of README.md: one push through a channel, of a Newtonian fluid and of an elastic one.

``python media/film.py`` runs configs/oldroyd_b_poiseuille.yaml with both fluids, of the same viscosity, and writes
media/film.mp4 and media/film.gif. Above: particles coloured by their velocity, an arrow for the push, and a line of dye
that flows with the particles.
Below: the velocity at mid-gap as it is measured, on the exact curve.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tisph import config, scenes
from tisph.observers.samples import read_frames
from tisph.report import style
from tisph.report.encoder import Encoder, write_gif

ROOT = Path(__file__).resolve().parents[1]
MEDIA, CONFIG = ROOT / "media", ROOT / "configs" / "oldroyd_b_poiseuille.yaml"
WIDTH, HEIGHT, RATE, SECONDS, END = 1280, 640, 24, 20, 10.0
FRAMES = RATE * SECONDS
SHARED = [f"time.end={END}", f"time.samples=[{END}]", f"output.video.frames={FRAMES + 1}", "output.video.width=640",
          "output.video.height=320"]  # fmt: skip
ELASTIC = ["fluid.rheology={type: oldroyd_b, relaxation_time: 4.0, solvent_fraction: 0.05}"]
FLUIDS = {"Newtonian": ["fluid.rheology={type: newtonian}"], "elastic (Oldroyd-B)": ELASTIC}
DYE = 0.25
"""Where the line of dye is at first, over the length of the channel."""


class Fluid:
    """The frames of a run: mid-gap velocity ``centre`` (frames,), and the dye's displacement (frames, rows)."""

    def __init__(self, name, changes):
        folder = ROOT / "runs" / "media" / f"film-{changes[0].split('type: ')[1].split(',')[0].strip('}')}"
        words = [word for text in (*SHARED, *changes) for word in ("--set", text)]
        command = [sys.executable, "-m", "tisph", "run", str(CONFIG), "--out", str(folder), "--overwrite", *words]
        subprocess.run(command, check=True)
        self.name, self.scene = name, scenes.of(config.load(folder / "config.resolved.yaml"))
        self.frames = list(read_frames(folder / "frames.h5"))
        self.times = np.array([frame.t for frame in self.frames])
        height = self.scene.extent[1]
        self.height = np.linspace(0.0, height, 101)
        rows = [np.argsort(frame.y) for frame in self.frames]
        speed = [
            np.interp(self.height, np.r_[0.0, frame.y[row], height], np.r_[0.0, frame.u[row], 0.0])
            for frame, row in zip(self.frames, rows, strict=True)
        ]
        self.speed = np.array(speed)
        steps = 0.5 * np.diff(self.times)[:, None] * (self.speed[1:] + self.speed[:-1])
        self.dye = DYE * self.scene.extent[0] + np.concatenate([0.0 * steps[:1], np.cumsum(steps, axis=0)])
        self.centre = self.speed[:, 50]

    def exact(self, times):
        """Return the exact velocity at mid-gap at ``times``."""
        return self.scene.exact("u", 0.0, 0.5 * self.scene.extent[1], times)


class Film:
    """The figure: a panel above for each fluid, and the curves of both below."""

    def __init__(self, fluids):
        self.fluids, self.figure = fluids, Figure((WIDTH / 80, HEIGHT / 80), dpi=80)
        self.canvas = FigureCanvasAgg(self.figure)
        largest = max(np.abs(fluid.speed).max() for fluid in fluids)
        self.colours = style.LIGHT.series[0], style.LIGHT.series[1]
        self.parts = [self._channel(place, fluid, largest) for place, fluid in enumerate(fluids)]
        self._key(largest)
        axes = self.figure.add_axes((0.07, 0.11, 0.9, 0.3), xlim=(0.0, END))
        times = np.linspace(1e-3, END, 600)
        for fluid in fluids:
            axes.plot(times, fluid.exact(times), color=style.EXACT, linewidth=1.2)
        axes.axhline(0.0, color=style.MUTED, linewidth=0.8)
        axes.set_xlabel("time [s]", fontsize=13)
        axes.set_ylabel("mid-gap velocity [cm/s]", fontsize=13)
        axes.tick_params(labelsize=12)
        axes.plot([], [], color=style.EXACT, linewidth=1.2, label="exact")
        self.curves = [
            axes.plot([], [], "o", markersize=4, color=colour, label=fluid.name)[0]
            for colour, fluid in zip(self.colours, fluids, strict=True)
        ]
        self.heads = [axes.plot([], [], "o", markersize=11, color=colour)[0] for colour in self.colours]
        axes.legend(loc="upper right", ncols=3, frameon=False, fontsize=13)

    def _channel(self, place, fluid, largest):
        width, height = fluid.scene.extent
        axes = self.figure.add_axes((0.03 + 0.44 * place, 0.5, 0.42, 0.42), xlim=(0.0, width), ylim=(0.0, height))
        axes.set_aspect("equal")
        axes.set_xticks([])
        axes.set_yticks([])
        axes.set_title(fluid.name, fontsize=17, color=self.colours[place], fontweight="bold")
        for side in ("left", "right"):
            axes.spines[side].set_visible(False)
        for side in ("top", "bottom"):
            axes.spines[side].set_linewidth(5.0)
        push = {"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "linewidth": 3.0, "color": style.TEXT}
        axes.annotate("", (0.18 * width, 0.2 * height), (0.03 * width, 0.2 * height), arrowprops=push, zorder=3)
        axes.text(0.03 * width, 0.26 * height, "push", fontsize=13)
        x, y, u = self._beyond_the_ends(fluid, 0)
        limits = {"vmin": -largest, "vmax": largest, "cmap": style.DIVERGING_MAP}
        dots = axes.scatter(x, y, c=u, s=44, linewidths=0.0, **limits)
        line = axes.plot([], [], color=style.TEXT, linewidth=5.0)[0]
        axes.text((DYE - 0.01) * width, 0.03 * height, "dye", fontsize=13, ha="right")
        return dots, line

    def _key(self, largest):
        """Draw the key to the colours at the right of the channels."""
        axes = self.figure.add_axes((0.925, 0.52, 0.012, 0.38), xlim=(0.0, 1.0), ylim=(-largest, largest))
        colours = style.colours(256, colour_map=style.DIVERGING_MAP)[::-1, None, :]
        axes.imshow(colours, extent=(0.0, 1.0, -largest, largest), aspect="auto")
        axes.set_xticks([])
        axes.yaxis.tick_right()
        axes.tick_params(labelsize=11)
        axes.set_title("velocity\n[cm/s]", fontsize=12)

    def _beyond_the_ends(self, fluid, index):
        """Return x, y and u of the particles and of their copies beyond both ends, which make the ends even."""
        frame, length = fluid.frames[index], fluid.scene.extent[0]
        shifts = np.repeat([-length, 0.0, length], len(frame.x))
        x, y, u = (np.tile(each, 3) for each in (frame.x, frame.y, frame.u))
        near = np.abs(x + shifts - 0.5 * length) < 0.6 * length
        return (x + shifts)[near], y[near], u[near]

    def draw(self, index):
        """Return frame ``index``, uint8 (rows, columns, 4)."""
        for fluid, (dots, line), curve, head in zip(self.fluids, self.parts, self.curves, self.heads, strict=True):
            (x, y, u), length = self._beyond_the_ends(fluid, index), fluid.scene.extent[0]
            dots.set_offsets(np.stack([x, y], axis=1))
            dots.set_array(u)
            x = fluid.dye[index] % length
            gaps = np.flatnonzero(np.abs(np.diff(x)) > 0.5 * length) + 1
            line.set_data(np.insert(x, gaps, np.nan), np.insert(fluid.height, gaps, np.nan))
            shown = slice(0, index + 1, 6)
            curve.set_data(fluid.times[shown], fluid.centre[shown])
            head.set_data([fluid.times[index]], [fluid.centre[index]])
        self.canvas.draw()
        return np.asarray(self.canvas.buffer_rgba())


def make():
    """Write film.mp4 and film.gif."""
    fluids = [Fluid(name, changes) for name, changes in FLUIDS.items()]
    with style.plot_style():
        film = Film(fluids)
        encoder = Encoder(MEDIA / "film.mp4", WIDTH, HEIGHT, RATE)
        for index in range(FRAMES):
            encoder.write(np.ascontiguousarray(film.draw(index)))
        encoder.close()
    write_gif(MEDIA / "film.mp4", MEDIA / "film.gif")


if __name__ == "__main__":
    make()
