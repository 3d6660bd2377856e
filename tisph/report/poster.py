"""A still of a movie, for where it does not play: its last frame, since nothing has happened yet in the first one."""

import io
from contextlib import suppress
from pathlib import Path

import imageio_ffmpeg
from PIL import Image

SOUGHT = "-2"
"""Seconds before the end from which frames are read; a movie has one a second at least."""


def poster(path: Path) -> bytes | None:
    """Return the last frame of the movie in the file ``path`` as JPEG, None where that is no whole movie."""
    frame = None
    with suppress(OSError, RuntimeError):  # what imageio-ffmpeg raises of a damaged file
        frames = imageio_ffmpeg.read_frames(str(path), input_params=["-sseof", SOUGHT])
        size = next(frames)["size"]
        for frame in frames:  # noqa: B007 (the last one is used)
            pass
    if frame is None:
        return None
    image = io.BytesIO()
    Image.frombytes("RGB", size, frame).save(image, format="JPEG", quality=85)
    return image.getvalue()
