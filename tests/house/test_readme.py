"""README and the pages of docs/: the commands they name exist, all of them are named, and no link leads nowhere."""

import re
from pathlib import Path

import pytest
import typer

import tisph
from tisph import cli

ROOT = Path(tisph.__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
GENERATED = ("gallery/", "tutorials/", "reference/keys.md", "reference/command-line.md")
"""Pages that are made with the site, which is strict about links."""
COMMANDS = set(typer.main.get_command(cli.app).commands)


def anchors(path):
    """Anchors of the headings of a page, as the usual forges make them."""
    headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    plain = [re.sub(r"[`*]|\[(.*?)\]\(.*?\)", r"\1", heading).lower() for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading).strip().replace(" ", "-") for heading in plain}


def test_readme_names_every_command():
    named = set(re.findall(r"tisph ([a-z]+)", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert named >= COMMANDS


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_commands_in_blocks_exist(path):
    blocks = re.findall(r"^```[a-z]*\n(.*?)^```", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    named = {name for block in blocks for name in re.findall(r"^tisph ([a-z]+)", block, flags=re.MULTILINE)}
    assert named <= COMMANDS


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(path):
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if link.startswith(("http", *GENERATED)):
            continue
        name, _, anchor = link.partition("#")
        target = (path.parent / name) if name else path
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def test_the_first_screen_has_what_a_visitor_needs():
    first = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()[:25]
    assert any("](media/cavity.gif)" in line for line in first)
    assert sum(line.startswith("* **") for line in first) == 3
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) < 130
