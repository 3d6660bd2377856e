"""The menu: ``tisph list`` and ``keys`` show choices and keys of a config, ``tisph new`` copies a commented config.

``tisph references`` shows reference values.
"""

import re
from itertools import groupby, takewhile
from pathlib import Path
from typing import Annotated

import typer

from tisph.errors import ConfigError, TisphError

PACKAGE = Path(__file__).resolve().parents[1]

SHORTEST = 20
"""Least number of characters of a line of the menu: a sentence ends at a dot or colon only after as many."""

SENTENCE_END = re.compile(r"(?<![ (][A-Z])[.:;](?= |$)")
"""End of a first sentence; the dot after an initial, as in "J. R. Womersley", is none."""


def new(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Name of a config of the menu.")] = None,
    show: Annotated[bool, typer.Option("--list", help="Show the menu instead.")] = False,
) -> None:
    """Copy a commented config from the menu into this folder.

    \b
    Examples:
      tisph new --list
      tisph new couette
    """
    if show:
        for kind, paths in groupby(sorted(menu(), key=kind_of), kind_of):
            print(kind)
            for path in paths:
                print(f"  {path.stem:32} {first_words(path)}")
        return
    if name is None:
        raise ConfigError("NAME is missing; tisph new --list shows the menu")
    print(copied(name))


def menu() -> list[Path]:
    """Return the configs of the menu by their names."""
    return sorted(shipped("configs").glob("*.yaml"))


def kind_of(path: Path) -> str:
    """Return the group of a config in the menu: its scene, and open ends, bodies or a non-Newtonian fluid, if any."""
    from tisph.config.yaml_text import parse

    data = parse(path.read_text(encoding="utf-8")).data
    law = data["fluid"].get("rheology", {}).get("type", "newtonian")
    given = {"open ends": "ends" in data, "bodies": "bodies" in data, "non-Newtonian": law != "newtonian"}
    return ", ".join([data["scene"], *(words for words, holds in given.items() if holds)])


def shipped(name: str) -> Path:
    """Return the folder ``name`` in an installed package, or in a checkout; TisphError without one."""
    for folder in (PACKAGE / name, PACKAGE.parent / name):
        if folder.is_dir():
            return folder
    raise TisphError(f"there is no {PACKAGE / name}: the installation is not complete")


def first_words(path: Path) -> str:
    """Return the first sentence of the comment at the top of a config."""
    lines = path.read_text(encoding="utf-8").splitlines()
    text = " ".join(line.removeprefix("# ").strip() for line in takewhile(lambda line: line.startswith("# "), lines))
    ends = (match.start() for match in SENTENCE_END.finditer(text))
    return text[: next((end for end in ends if end >= SHORTEST), len(text))]


def copied(name: str) -> Path:
    """Copy the config ``name`` into the current folder and return its path; ConfigError where that fails."""
    from tisph.config.fields import nearest

    found = {path.stem: path for path in menu()}
    stem = name.removesuffix(".yaml")
    if stem not in found:
        raise ConfigError(f"NAME {name!r}: there is no such config{nearest(stem, found)}; tisph new --list shows them")
    path = Path(f"{stem}.yaml")
    text = found[stem].read_text(encoding="utf-8").replace("configs/", "")  # the comments name the file in configs/
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ConfigError(f"{path}: is there already, and is left as it is") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror or error}") from None
    return path


def list_families(
    family: Annotated[str | None, typer.Argument(metavar="[FAMILY]", help="One family; all without it.")] = None,
) -> None:
    """List the choices of a config.

    Scenes, wall treatments, schemes, rheologies, kernels and more, with one line each.

    \b
    Examples:
      tisph list
      tisph list walls
    """
    from tisph import registry

    if family is not None and family not in registry.FAMILIES:
        raise ConfigError(f"FAMILY {family!r}: must be one of {', '.join(registry.FAMILIES)}")
    for shown in [family] if family else registry.FAMILIES:
        names = registry.names(shown)
        width = max(map(len, names))
        print(shown)
        for name in names:
            print(f"  {name:{width}} {registry.summary(shown, name)}")


def keys(
    scene: Annotated[str | None, typer.Argument(metavar="[SCENE]", help="One scene; all without it.")] = None,
    section: Annotated[str | None, typer.Argument(metavar="[SECTION]", help="One section, such as time.")] = None,
) -> None:
    """Print the keys of a config: unit, allowed values, default and meaning.

    With a SCENE only the keys of its configs are printed, with a SECTION only the keys of this section.

    \b
    Examples:
      tisph keys
      tisph keys channel
      tisph keys channel walls
    """
    from tisph import registry
    from tisph.config import reference
    from tisph.config.fields import nearest

    names = registry.names("scenes")
    if scene not in (None, *names):
        raise ConfigError(f"SCENE {scene!r}: must be one of {', '.join(names)}{nearest(scene, names)}")
    if scene is not None and section is not None and section not in (sections := reference.sections(scene)):
        raise ConfigError(f"SECTION {section!r}: must be one of {', '.join(sections)}{nearest(section, sections)}")
    print("\n".join(reference.listing(scene, section)).lstrip())


def references(
    flow: Annotated[str | None, typer.Argument(metavar="[FLOW]", help="One flow; a list of all without it.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Print reference values of a flow with their sources.

    Each number has its unit, convention and spread, how it was obtained, whether the source was checked, and the other
    values that circulate. Without a FLOW the flows are listed, with all values that contradict a reference. Exit status
    1 if two values differ by more than both spreads without a stated reason.

    \b
    Examples:
      tisph references
      tisph references dfg_2d_1
      tisph references --json
    """
    from tisph.references import table

    try:
        print(table.as_json(flow) if as_json else "\n".join(table.listing(flow) if flow else table.summary()))
    except ValueError as error:
        raise ConfigError(f"FLOW: {error}") from None
    shown = [flow] if flow else list(table.flows())
    if any(pair.verdict == table.DISAGREES for name in shown for pair in table.pairs(name)):
        raise typer.Exit(1)
