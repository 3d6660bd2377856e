"""A movie as an animated GIF, for pages and slides that play no video."""

import subprocess
from pathlib import Path

from imageio_ffmpeg import get_ffmpeg_exe

from tisph.errors import TisphError

_WIDTH, _RATE = 640, 12  # pixels, and frames a second
_FILTERS = (
    f"fps={_RATE},scale={_WIDTH}:-2:flags=lanczos,split[film][sample];"
    "[sample]palettegen=max_colors=128[palette];[film][palette]paletteuse=dither=none"
)


def write_gif(movie: Path, path: Path) -> None:
    """Write the ``movie`` as GIF to ``path``; TisphError where ffmpeg cannot."""
    command = [get_ffmpeg_exe(), "-y", "-loglevel", "error", "-i", f"file:{movie}", "-vf", _FILTERS, f"file:{path}"]
    try:
        done = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL)
    except OSError as error:
        raise TisphError(f"{path}: ffmpeg could not be started, so there is no GIF: {error}") from error
    if done.returncode != 0:
        words = done.stderr.decode(errors="replace").strip()
        raise TisphError(f"{path}: ffmpeg stopped with status {done.returncode}: {words}")
