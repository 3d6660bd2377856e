"""Messages that docs/questions.md explains are those of the program."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "questions.md").read_text(encoding="utf-8")


def fragments():
    """Words of the messages in the first column of the table, without what changes from case to case."""
    _, table = PAGE.split("| message | what to do |")
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    quoted = [text for cell in cells for text in re.findall(r"`([^`]+)`", cell)]
    return [part.strip() for text in quoted for part in text.split("...")]


def test_messages_are_those_of_the_program():
    code = " ".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "tisph").rglob("*.py")))
    found = fragments()
    assert len(found) > 6
    assert [text for text in found if text not in code] == []
