"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated, Any

import typer

ConfigFile = Annotated[str, typer.Argument(metavar="CONFIG", help="YAML file that describes the run.")]

Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY.PATH=VALUE", help="Replace one value of the config; may be repeated."),
]


def out_folder(words: str) -> Any:
    """Return the option of the folder of results, whose help is ``words``."""
    return typer.Option("--out", metavar="DIR", parser=folder_name, help=words)


def folder_name(text: str) -> Path:
    """Parse the name of a folder; an empty one, as of an unset variable of a shell, is not the current folder."""
    if not text.strip():
        raise typer.BadParameter("the name is empty; give a folder (. is the current one)")
    return Path(text)
