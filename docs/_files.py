"""Tables of the names in the files of a run, for docs/reference/files.md: ``tisph/results/names.yaml`` as Markdown."""

import re
from pathlib import Path

from ruamel.yaml import YAML

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference" / "files.md"
SECTIONS = YAML(typ="safe").load((ROOT / "tisph" / "results" / "names.yaml").read_text(encoding="utf-8"))
BAR = r"\|"
POINTER = re.compile(r"^.*`([^`]+)` in \[names\.yaml\]\([^)]*\)\.\n", re.MULTILINE)
"""Line of the page that says where a clone has the names of a section."""


def files_page():
    """Return the page with its tables in place of the lines that point to names.yaml."""
    return POINTER.sub(lambda found: tables(found[1]), PAGE.read_text(encoding="utf-8"))


def tables(section):
    """Return the tables of a section: one, or one for each of its parts, with a title."""
    parts = SECTIONS[section]
    if any(isinstance(part, str) for part in parts.values()):
        return table(parts)
    return "\n".join(f"{title[0].upper()}{title[1:]}:\n\n{table(rows)}" for title, rows in parts.items())


def table(rows):
    """Return names and meanings as a table."""
    lines = [f"| {name} | {meaning.replace('|', BAR)} |\n" for name, meaning in rows.items()]
    return "| name | meaning |\n|---|---|\n" + "".join(lines)


PAGES = {"reference/files.md": files_page}
"""Generated pages of the site, by their names."""
