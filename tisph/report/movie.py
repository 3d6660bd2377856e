"""The MP4 of a run, and single frames of it as PNG."""

import contextlib
import pickle
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from tisph.errors import TisphError
from tisph.report import style
from tisph.report.dye import Dye
from tisph.report.encoder import Encoder
from tisph.report.frame import FrameRenderer, Measured
from tisph.report.full_cut import FullCut
from tisph.report.layout import arrange
from tisph.report.quantities import Extremes, quantity
from tisph.report.time_panel import TimePanel, exact_values, measured
from tisph.snapshot import Snapshot


class Movie:
    """A movie of ``scene`` at ``path``, drawn and encoded a frame at a time.

    ``video`` is the config's ``output.video``, ``title`` the name of the run and ``end`` the time at which it ends.
    Where exact values tell the ranges of axes and colours, a frame is drawn when it is added; else its snapshot waits
    in a temporary file until the movie is closed and all ranges are known. The movie's own file is opened by the first
    frame that is drawn, so a Movie that only serves ``save_frame`` writes none. As a context manager it closes the file
    whatever happens: what was added by then can be played.
    Raises TisphError if ffmpeg cannot start or stops early.
    """

    def __init__(self, path: Path | str, scene, video, title: str, end: float):
        self.path = Path(path)
        self._scene, self._video, self._title, self._end = scene, video, title, end
        self._dyed = video.color_by == "dye"
        self._series = scene.movie_series()
        self._view = scene.movie_view("speed" if self._dyed else video.color_by, end)
        if self._dyed:
            self._view = replace(self._view, name="", of=Dye(scene, video.dye).of)
        self._waiting, self._ranges = None, None
        self._renderer: FrameRenderer | None = None
        self._encoder: Encoder | None = None
        if self._view.ends and exact_values(self._series, np.array([end])) is not None:
            self._renderer = self._new_renderer(None)

    def frame(self, snapshot: Snapshot) -> np.ndarray:
        """Return the picture of ``snapshot``, uint8 (height, width, 3), with the ranges of the frames or its own."""
        measured = self._measured(snapshot)
        renderer = self._renderer
        if renderer is None:
            ranges = self._ranges or _Ranges(self._view.profile.line)
            if self._ranges is None:
                ranges.add(measured)
            renderer = self._new_renderer(ranges)
        return renderer.render(measured).copy()

    def save_frame(self, path: Path | str, snapshot: Snapshot) -> None:
        """Write the picture of ``snapshot`` as PNG."""
        Image.fromarray(self.frame(snapshot)).save(path, format="PNG", optimize=True)

    def add(self, snapshot: Snapshot) -> None:
        """Append the picture of ``snapshot`` to the movie."""
        measured = self._measured(snapshot)
        if self._renderer:
            self._draw(measured)
            return
        if self._waiting is None:
            line = self._view.profile.line
            self._waiting, self._ranges = tempfile.TemporaryFile(), _Ranges(line)  # noqa: SIM115 (lives until ``close``)
        self._ranges.add(measured)
        pickle.dump(measured, self._waiting, pickle.HIGHEST_PROTOCOL)

    def close(self) -> None:
        """Draw what waits and finish the file. May be called again, and does nothing then."""
        waiting, self._waiting = self._waiting, None
        try:
            if waiting:
                self._renderer = self._new_renderer(self._ranges)
                waiting.seek(0)
                for _ in range(self._ranges.count):
                    self._draw(pickle.load(waiting))
        finally:
            if waiting:
                waiting.close()
            if self._encoder is not None:
                self._encoder.close()

    def _measured(self, snapshot):
        view = self._view
        colours = view.of(snapshot)
        profile = colours if view.profile.of is view.of else view.profile.of(snapshot)
        return Measured(snapshot, colours, profile, measured(self._series, snapshot))

    def _new_renderer(self, ranges):
        scene = FullCut(self._scene) if self._scene.axisymmetric else self._scene
        layout = arrange(scene, self._video.width, self._video.height, style.THEMES[self._video.theme])
        ends = ranges and (ranges.colours.ends, ranges.profile.ends)
        shown = quantity(self._view, self._scene, (0.0, 1.0) if self._dyed else self._video.limits, ends)
        shown = replace(shown, colour_map=style.DYE_MAP) if self._dyed else shown
        panel = TimePanel(scene, layout, self._series, self._end, ranges and ranges.series.ends)
        return FrameRenderer(scene, layout, self._video, self._title, shown, panel)

    def _draw(self, measured):
        if self._encoder is None:
            self._encoder = Encoder(self.path, self._video.width, self._video.height, self._video.fps)
        self._renderer.render(measured)
        self._encoder.write(self._renderer.frame)

    def __enter__(self) -> "Movie":
        return self

    def __exit__(self, kind, error, trace) -> None:
        # An error on its way out is the message to show: a broken movie must not hide it.
        with contextlib.suppress(TisphError) if kind else contextlib.nullcontext():
            self.close()


class _Ranges:
    """Ranges of what frames show, the profile along ``line``, and how many frames there are."""

    def __init__(self, line):
        self.colours, self.profile, self.series = Extremes(), Extremes(whole=True), Extremes(whole=True)
        self._line, self.count = line, 0

    def add(self, measured):
        """Take a frame."""
        self.count += 1
        self.colours.add(measured.colours)
        self.profile.add(measured.profile[self._line.near(measured.snapshot)])
        self.series.add(measured.series)
