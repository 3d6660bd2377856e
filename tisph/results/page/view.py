"""A run as a page shows it: words, movie and pictures with what they say in words."""

from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tisph import schemes
from tisph.folder import Folder
from tisph.report.encoder import poster
from tisph.report.labels import number

if TYPE_CHECKING:
    from tisph.results import Results

_TYPES = {".png": "image/png", ".mp4": "video/mp4", ".jpg": "image/jpeg"}
_TIMES_NAMED = 6


@dataclass(frozen=True)
class Element:
    """A picture or a movie: all of its file as a ``data:`` address, what is to be seen, in words, and a still of it."""

    address: str
    words: str
    poster: str | None = None


@dataclass(frozen=True)
class View:
    """What is shown of one run; None where the run left no such file."""

    title: str
    folder: str
    status: str
    message: str | None
    facts: list[tuple[str, str]]
    movie: Element | None
    profiles: Element | None
    history: Element | None

    @classmethod
    def of(cls, run: "Results", title: str) -> "View":
        """Of ``run``, which the page calls ``title``."""
        summary, files, time = run.summary, Folder(run.folder), run.config.units.time
        times = [f"{number(sample.t)} {time}" for sample in summary.samples]
        shown = ", ".join(times if len(times) <= _TIMES_NAMED else [*times[:_TIMES_NAMED], "..."])
        video = run.config.output.video
        film = f"particles coloured by {video.color_by}, with the profile beside them" if video else "the particles"
        series = run._scene.time_series(**run.config.time_series).content
        return cls(
            title=title,
            folder=str(run.folder),
            status=summary.status,
            message=summary.message,
            facts=_facts(run),
            movie=element(
                files.movie,
                f"Movie of {title} from t = {number(run.config.start_time)} to {number(run.config.time.end)} {time}: "
                f"{film}.",
            ),
            profiles=element(
                files.profiles_picture,
                f"Profiles of {title} at t = {shown}: particles, and the reference as lines where there is one. "
                f"{_error_words(run)}",
            ),
            history=element(
                files.history_picture,
                f"History of {title}: {series}. Markers are the run, lines the reference where there is one.",
            ),
        )


def element(path: Path, words: str) -> Element | None:
    """Return the picture or movie in ``path``, None where there is no such file."""
    if not path.is_file():
        return None
    still = poster(path) if path.suffix == ".mp4" else None
    return Element(_address(path.suffix, path.read_bytes()), words, _address(".jpg", still) if still else None)


def _address(suffix: str, content: bytes) -> str:
    return f"data:{_TYPES[suffix]};base64,{b64encode(content).decode()}"


def _facts(run: "Results") -> list[tuple[str, str]]:
    """What the flow is, as ``tisph check`` says it, and what it was computed with."""
    numbers = run.summary.numbers
    facts = [*run._scene.parameters(), ("scene", run.config.scene), ("scheme", schemes.resolve(run.config)[1])]
    if "particles_fluid" in numbers:
        facts.append(("particles", str(numbers["particles_fluid"])))
    units = run.config.units
    return [*facts, ("units", f"{units.length}, {units.mass}, {units.time}")]


def _error_words(run: "Results") -> str:
    last = run.summary.samples[-1] if run.summary.samples else None
    if last is None or last.l2 is None:
        return ""
    return f"L2 error at the last one: {number(last.l2, 2)}."
