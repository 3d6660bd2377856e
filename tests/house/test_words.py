"""One word for one meaning, and that of the field's textbooks: words and phrases that are not used here."""

import re
from pathlib import Path

import pytest

from tisph.config.yaml_text import parse

ROOT = Path(__file__).parents[2]
PLACES = (
    "tisph/**/*.py",
    "docs/**/*.md",
    "docs/_gallery/*.yaml",
    "configs/*.yaml",
    "tisph/suites/*.yaml",
    "README.md",
    "CONTRIBUTING.md",
)
READ = {path: " ".join(path.read_text("utf-8").split()) for place in PLACES for path in sorted(ROOT.glob(place))}
WORDS = parse((Path(__file__).parent / "data" / "words.yaml").read_text(encoding="utf-8")).data
EXCEPTIONS = {(name, word) for name, word, _ in WORDS["exceptions"]}


@pytest.mark.parametrize(("pattern", "better"), WORDS["phrases"].items())
def test_a_phrase_of_its_own_is_not_used(pattern, better):
    expression = re.compile(pattern, re.IGNORECASE)
    found = [
        f"{path.relative_to(ROOT)}: {match.group()}"
        for path, text in READ.items()
        for match in expression.finditer(text)
        if (path.name, match.group().lower()) not in EXCEPTIONS
    ]
    assert not found, f"say {better!r} instead: {found}"


@pytest.mark.parametrize(("kind", "pattern"), [("names", r"\w+"), ("attributes", r"(?:def |self\.)(\w+)\b")])
def test_names_are_those_of_the_field(kind, pattern):
    found = [
        f"{path.relative_to(ROOT)}: {name}, say {WORDS[kind][name]}"
        for path, text in READ.items()
        if kind == "names" or path.suffix == ".py"
        for name in set(re.findall(pattern, text)) & WORDS[kind].keys()
    ]
    assert not found


def test_names_of_tests_have_at_most_a_dozen_words():
    names = [
        name for path in ROOT.glob("tests/*/*.py") for name in re.findall(r"def test_(\w+)", path.read_text("utf-8"))
    ]
    assert [name for name in names if name.count("_") > 11] == []
