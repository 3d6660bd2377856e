"""What a config says of its movie."""

from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Model
from tisph.config.fields import number_or

FrameWidth = Annotated[int, Field(ge=640, le=4096, multiple_of=2)]
FrameHeight = Annotated[int, Field(ge=320, le=4096, multiple_of=2)]


class Video(Model):
    """Movie: frames a second, number of frames, size in pixels (even, as H.264 wants it), and what is drawn how.

    ``color_by`` says what colours show, from ``limits`` [a, b] or from the values of the run. Coloured by dye, the
    fluid keeps the colour of the pattern ``dye`` in the first frame. ``style`` auto: a continuous field in
    two-dimensional flow, else particles. ``overlay``: velocities as arrows, lines of equal stream function, or the
    paths of some particles.
    """

    fps: Annotated[int, Field(ge=1, le=120)] = 30
    frames: Annotated[int, Field(ge=2, le=10_000)] = 120
    width: FrameWidth = 1280
    height: FrameHeight = 640
    renderer: Literal["raster"] = "raster"
    color_by: str = "speed"
    limits: number_or(Annotated[tuple[float, float], Field(strict=False)], "auto") = "auto"
    style: Literal["auto", "field", "particles", "both"] = "auto"
    dye: Literal["stripes", "checkerboard", "blob"] = "stripes"
    overlay: Literal["none", "vectors", "streamlines", "tracks"] = "none"
    theme: Literal["light", "dark"] = "light"
