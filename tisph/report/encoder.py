"""Files of a movie: RGB frames as MP4 (H.264, yuv420p), an animated GIF, and a still for where the movie does not play.

The ffmpeg is the one that imageio-ffmpeg brings along. The GIF is for pages and slides that play no video. The still is
the last frame, since nothing has happened yet in the first one.
"""

import contextlib
import io
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from imageio_ffmpeg import get_ffmpeg_exe
from PIL import Image

from tisph.errors import TisphError
from tisph.folder import partial, replaced
from tisph.report.drawing_process import apart_from_terminal

_WIDTH, _RATE = 640, 12  # pixels, and frames a second
_FILTERS = (
    f"fps={_RATE},scale={_WIDTH}:-2:flags=lanczos,split[film][sample];"
    "[sample]palettegen=max_colors=128[palette];[film][palette]paletteuse=dither=none"
)


def write_gif(movie: Path, path: Path, seconds: float | None = None) -> None:
    """Write the ``movie``, or its first ``seconds``, as GIF to ``path``; TisphError where ffmpeg cannot."""
    part = [] if seconds is None else ["-t", str(seconds)]
    source = [*part, "-i", f"file:{movie}"]
    command = [get_ffmpeg_exe(), "-y", "-loglevel", "error", *source, "-vf", _FILTERS, "-f", "gif"]
    with replaced(path) as new:
        try:
            done = subprocess.run([*command, f"file:{new}"], capture_output=True, stdin=subprocess.DEVNULL)
        except OSError as error:
            raise TisphError(f"{path}: ffmpeg could not be started, so there is no GIF: {error}") from error
        if done.returncode != 0:
            words = done.stderr.decode(errors="replace").strip()
            raise TisphError(f"{path}: ffmpeg stopped with status {done.returncode}: {words}")


SOUGHT = "-2"
"""Seconds before the end from which frames are read; a movie has one a second at least."""


def poster(path: Path) -> bytes | None:
    """Return the last frame of the movie in the file ``path`` as JPEG, None where that is no whole movie."""
    frame = None
    with suppress(OSError, RuntimeError):  # errors of imageio-ffmpeg for a damaged file
        frames = imageio_ffmpeg.read_frames(str(path), input_params=["-sseof", SOUGHT])
        size = next(frames)["size"]
        for frame in frames:  # noqa: B007 (the last one is used)
            pass
    if frame is None:
        return None
    image = io.BytesIO()
    Image.frombytes("RGB", size, frame).save(image, format="JPEG", quality=85)
    return image.getvalue()


# From RGB with the matrix of HD video, and the file says so: every player shows the colours that were drawn.
_COLOURS = (
    "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1:range=tv"
)

# Features that particles on a plain ground do not need are off: half of the time of preset veryfast at crf 23, 1.5
# times the bytes, PSNR 33.8 dB instead of 35.4 for Couette flow.
_QUALITY = (
    *("-preset", "superfast", "-crf", "26"),
    *("-x264-params", "cabac=0:bframes=0:subme=0:rc-lookahead=0:mbtree=0:weightp=0"),
)

_PIPE = 2**20  # bytes: a frame goes through in a few turns of both processes, not in fifty


class Encoder:
    """Writes frames as they come; ``close`` makes the file ``path``, also after an interruption.

    Until then, and after a failure, the file is as before. ``width`` and ``height`` in pixels must be even, as yuv420p
    has one colour for 2 x 2 pixels. Raises TisphError if ffmpeg cannot start or stops early.
    """

    def __init__(self, path: Path, width: int, height: int, frames_per_second: float):
        self._shape = (height, width, 4)
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 (it lives as long as the process)
        try:
            self._process: Any = subprocess.Popen(
                _command(partial(path), width, height, frames_per_second),
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=self._messages,
                **apart_from_terminal(),
            )
        except (OSError, RuntimeError) as error:  # imageio-ffmpeg raises RuntimeError if it has no ffmpeg
            self._messages.close()
            raise TisphError(f"{path}: ffmpeg could not be started, so there is no movie: {error}") from error
        _widen(self._process.stdin)
        self._path = path

    def write(self, frame: np.ndarray) -> None:
        """Encode one frame, uint8 of shape (height, width, 4): RGB and a byte that means nothing."""
        if frame.shape != self._shape or frame.dtype != np.uint8:
            raise ValueError(f"frame is {frame.dtype} {frame.shape}, expected uint8 {self._shape}")
        try:
            self._process.stdin.write(np.ascontiguousarray(frame).data)
        except OSError as error:  # ffmpeg has gone: its own words say why
            raise self._failure() from error

    def close(self) -> None:
        """Finish the file. May be called again, and does nothing then."""
        if self._messages.closed:
            return
        with contextlib.suppress(OSError):  # nothing left to flush into if ffmpeg has gone
            self._process.stdin.close()
        status = self._process.wait()
        if status != 0:
            raise self._failure()
        self._messages.close()
        partial(self._path).replace(self._path)

    def _failure(self) -> TisphError:
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        status = self._process.wait()
        self._messages.seek(0)
        words = (self._messages.read().decode(errors="replace").strip() or "it said nothing").splitlines()[0]
        self._messages.close()
        partial(self._path).unlink(missing_ok=True)
        return TisphError(f"{self._path}: ffmpeg stopped with status {status}: {words}")


def _command(path: Path, width: int, height: int, frames_per_second: float) -> list[str]:
    """Return the ffmpeg call."""
    return [
        get_ffmpeg_exe(), "-y", "-loglevel", "error",
        "-f", "rawvideo", "-pix_fmt", "rgb0", "-s", f"{width}x{height}", "-r", str(frames_per_second),
        "-i", "pipe:0",
        "-an", "-vf", _COLOURS, "-c:v", "libx264", *_QUALITY, "-threads", "1",
        "-movflags", "+faststart", "-f", "mp4", f"file:{path}",
    ]  # fmt: skip


def _widen(pipe: Any) -> None:
    """Let more wait in ``pipe``, where its size can be chosen and the user's pipes together leave room for it."""
    with contextlib.suppress(ImportError, AttributeError, OSError):
        from fcntl import F_SETPIPE_SZ, fcntl

        fcntl(pipe, F_SETPIPE_SZ, _PIPE)
