"""The MP4 of a run, and single frames of it as PNG."""

import contextlib
from pathlib import Path

import numpy as np
from PIL import Image

from tisph.errors import TisphError
from tisph.report.encoder import Encoder
from tisph.report.frame import FrameRenderer
from tisph.snapshot import Snapshot


class Movie:
    """A movie of ``scene`` at ``path``, drawn and encoded a frame at a time.

    ``video`` is the config's ``output.video`` (fps, width, height, color_by, overlay), ``title`` the name of the run
    and ``end`` the time at which it ends, to which axes and colours are fitted. The file is opened by the first
    frame, so a Movie that only serves ``frame`` or ``save_frame`` writes none. As a context manager it closes the
    file whatever happens: what was added by then can be played.
    Raises TisphError if ffmpeg cannot start or stops early.
    """

    def __init__(self, path: Path | str, scene, video, title: str, end: float):
        self.path = Path(path)
        self._video = video
        self._renderer = FrameRenderer(scene, video, title, end)
        self._encoder: Encoder | None = None

    def frame(self, snapshot: Snapshot) -> np.ndarray:
        """Return the picture of ``snapshot``, uint8 of shape (height, width, 3)."""
        return self._renderer.render(snapshot).copy()

    def save_frame(self, path: Path | str, snapshot: Snapshot) -> None:
        """Write the picture of ``snapshot`` as PNG."""
        Image.fromarray(self.frame(snapshot)).save(path, format="PNG", optimize=True)

    def add(self, snapshot: Snapshot) -> None:
        """Append the picture of ``snapshot`` to the movie."""
        if self._encoder is None:
            self._encoder = Encoder(self.path, self._video.width, self._video.height, self._video.fps)
        self._renderer.render(snapshot)
        self._encoder.write(self._renderer.frame)

    def close(self) -> None:
        """Finish the file. May be called again, and does nothing then."""
        if self._encoder is not None:
            self._encoder.close()

    def __enter__(self) -> "Movie":
        return self

    def __exit__(self, kind, error, trace) -> None:
        # An error on its way out is the message to show: a broken movie must not hide it.
        with contextlib.suppress(TisphError) if kind else contextlib.nullcontext():
            self.close()
