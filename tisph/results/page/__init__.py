"""Runs as HTML: one page to mail, and what a notebook shows. Templates write it, and escape every text.

The page needs no network and no script: movie and pictures are in it.
"""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from tisph.results.page import tables
from tisph.results.page.view import View, element
from tisph.version import __version__

if TYPE_CHECKING:
    from jinja2 import Environment

    from tisph.results import Results

_TEMPLATES = Path(__file__).parent / "templates"


def report(runs: "Sequence[Results]") -> str:
    """Return one page about ``runs``: side by side where there are several."""
    names = [run.summary.name for run in runs]
    same = len(set(names)) < len(names)  # then the folders tell them apart
    views = [View.of(run, str(run.folder) if same else run.summary.name) for run in runs]
    return (
        _environment()
        .get_template("report.html")
        .render(
            views=views,
            title=", ".join(view.title for view in views),
            tables=[
                tables.errors(runs, views),
                tables.estimates(runs, views),
                tables.measures(runs, views),
                *tables.side_by_side(runs),
            ],
            config=tables.config(runs),
            version=__version__,
        )
    )


def fragment(run: "Results") -> str:
    """Return movie, pictures and errors of a run, for a notebook."""
    view = View.of(run, run.summary.name)
    errors = tables.errors([run], [view])
    return _environment().get_template("fragment.html").render(view=view, errors=errors)


def movie_element(path: Path, title: str) -> str:
    """Return the movie in the file ``path`` as an element that a notebook plays."""
    return _environment().get_template("movie.html").render(movie=element(path, f"Movie of {title}"))


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(_TEMPLATES), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
