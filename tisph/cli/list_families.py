"""``tisph list``: the menu of choices."""

from typing import Annotated

import typer

from tisph.errors import ConfigError


def list_families(
    family: Annotated[str | None, typer.Argument(metavar="[FAMILY]", help="One family; all without it.")] = None,
) -> None:
    """List what a config can choose from.

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
        print(shown)
        for name in registry.names(shown):
            print(f"  {name:16} {registry.summary(shown, name)}")
