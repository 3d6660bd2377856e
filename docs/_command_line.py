"""The reference of the command line, generated from the commands themselves."""

import typer

from tisph import cli


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


PAGES = {"reference/command-line.md": commands_page}
"""Generated pages of the site, by their names."""
