"""The reference of keys and commands, generated from the models of the config and from the command line itself.

Range and default come from the models; ``_keys.yaml`` has meaning and unit. A key without a line there is a KeyError.
"""

import re
import typing
from pathlib import Path

import typer
import yaml
from pydantic_core import PydanticUndefined

from tisph import cli, registry
from tisph.config.base import LARGEST, SMALLEST, Model
from tisph.config.fields import Member

MEANINGS = yaml.safe_load((Path(__file__).parent / "_keys.yaml").read_text(encoding="utf-8"))
FAMILIES = {
    "schemes": "Schemes: `scheme: {type: NAME, ...}`",
    "rheology": "Fluid laws: `fluid: {rheology: {type: NAME, ...}}`",
    "walls": "Wall treatments: `walls: {treatment: {type: NAME, ...}}`",
    "bodies": "Shapes: `bodies: [{type: NAME, ...}]`",
}
SIDES = re.compile(r"^walls\.(top|bottom|inner|outer)\b")
HEAD = "| key | meaning | unit | allowed | default |\n|---|---|---|---|---|\n"


def keys_page():
    """The page of all keys, as Markdown."""
    parts = [
        "# Keys of a config\n\nThis page is generated from the program. Units are those of the config itself: any "
        "self-consistent system will do. A key without a default must be given.\n\n## All scenes\n\n",
    ]
    scenes = {name: dict(fields(registry.load("scenes", name).Config)) for name in registry.names("scenes")}
    shared = [key for key in scenes["channel"] if all(key in each for each in scenes.values())]
    shared = [key for key in shared if not key.startswith(("geometry", "walls", "initial"))]
    parts.append(table({key: scenes["channel"][key] for key in shared}))
    for name, own in scenes.items():
        parts.append(f"\n## Scene `{name}`\n\n{summary('scenes', name)}\n\n")
        parts.append(table({key: field for key, field in own.items() if key not in shared}))
    for family, title in FAMILIES.items():
        parts.append(f"\n## {title}\n\n")
        for name in registry.names(family):
            parts.append(f"\n### `{name}`\n\n{summary(family, name)}\n\n")
            parts.append(table(dict(fields(registry.load(family, name).Parameters)), f"{family}/"))
    return "".join(parts)


def summary(family, name):
    """First sentence of what a member says of itself."""
    first = " ".join(registry.load(family, name).__doc__.partition("\n\n")[0].split())
    return re.split(r"(?<=[a-z)])[.:] ", first)[0].rstrip(".") + "."


def table(entries, above=""):
    """Lines of a table of keys with their fields; ``above`` is what stands before them in ``_keys.yaml``."""
    lines = []
    for key, field in entries.items():
        meaning, unit = MEANINGS[above + SIDES.sub("walls.SIDE", key)]
        cells = (f"`{key}`", meaning, unit, allowed(field.annotation, field.metadata), default(field))
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n")
    return HEAD + "".join(lines)


def fields(model, above=""):
    """Pairs of dotted key and field of a parameter model; what a family is for stands with its members."""
    for name, field in model.model_fields.items():
        yield f"{above}{name}", field
        for below in models(field.annotation):
            yield from fields(below, f"{above}{name}.")


def models(annotation):
    """Parameter models in the type of a field, but for those that a family stands for."""
    if isinstance(annotation, type) and issubclass(annotation, Model) and annotation is not Model:
        yield annotation
    for each in typing.get_args(annotation):
        yield from models(each)


def allowed(annotation, metadata=()):
    """What values a field may have, in words."""
    family = next((one.family for one in metadata if isinstance(one, Member)), None)
    if family:
        return "a map with `type`: " + ", ".join(f"`{name}`" for name in registry.names(family))
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return allowed(inner[0], [*metadata, *constraints(inner[1:])])
    if origin is typing.Literal:
        return ", ".join(f"`{value}`" for value in inner)
    if origin is tuple:
        return ("list, each: " if inner[-1] is ... else f"{len(inner)} values, each: ") + allowed(inner[0])
    if origin is not None:
        return " or ".join(dict.fromkeys(allowed(each, metadata) for each in inner if each is not type(None)))
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return "a map"
    kind = {float: "number", int: "whole number", bool: "`true`, `false`", str: "text"}[annotation]
    return f"{kind}{limits(metadata)}"


def constraints(metadata):
    """All parts of the metadata of a type, those inside of pydantic's fields, too."""
    for one in metadata:
        yield from getattr(one, "metadata", [one])


def limits(metadata):
    """The bounds of a number, in words."""
    bounds = {
        kind: getattr(one, kind)
        for one in constraints(metadata)
        for kind in ("ge", "gt", "le", "lt")
        if hasattr(one, kind)
    }
    words = {"ge": "at least {}", "gt": "above {}", "le": "at most {}", "lt": "below {}"}
    if bounds.get("ge") == SMALLEST:
        bounds = {**{kind: bound for kind, bound in bounds.items() if kind != "ge"}, "gt": 0}
    said = [words[kind].format(f"{bound:g}") for kind, bound in sorted(bounds.items()) if abs(bound) < LARGEST]
    return f" {' and '.join(said)}" if said else ""


def default(field):
    """The default of a field, in words; empty where it must be given."""
    value = field.get_default(call_default_factory=True) if field.default_factory else field.default
    if value is PydanticUndefined:
        return ""
    if isinstance(value, Model):
        return f"`{value.type}`" if hasattr(value, "type") else "see below"
    if value is None or value == ():
        return "none"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"`{list(value) if isinstance(value, tuple) else value}`"


def commands_page():
    """The page of the command line, as Markdown."""
    parts = [
        "# Command line\n\nThis page is generated from the program: it is what `tisph COMMAND --help` says.\n",
    ]
    shown = [(name, one) for name, one in typer.main.get_command(cli.app).commands.items() if not one.hidden]
    for name, command in sorted(shown):
        about, _, examples = (command.help or "").partition("\b")
        parts.append(f"\n## `tisph {name}`\n\n{' '.join(about.split())}\n\n")
        if examples:
            lines = [line.strip() for line in examples.strip().splitlines() if line.strip().startswith("tisph")]
            parts.append("```\n" + "\n".join(lines) + "\n```\n\n")
        rows = [option_row(one) for one in command.params if not getattr(one, "hidden", False)]
        parts.append("| argument or option | meaning | default |\n|---|---|---|\n" + "".join(rows))
    return "".join(parts)


def option_row(parameter):
    """Line of the table of a command."""
    names = ", ".join(f"`{name}`" for name in parameter.opts) if parameter.opts[0].startswith("-") else ""
    names = names or f"`{parameter.metavar or parameter.name.upper()}`"
    given = parameter.default
    said = "" if given is None or given is False or callable(given) or given == () else f"`{given}`"
    meaning = " ".join((getattr(parameter, "help", "") or "").split())
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in (names, meaning, said)) + " |\n"


PAGES = {"reference/keys.md": keys_page, "reference/command-line.md": commands_page}
"""Generated pages of the site, by their names."""
