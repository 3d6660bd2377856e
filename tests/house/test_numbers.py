"""Numbers of the documents are those of their sources: texts, keys, and the runs that take a second."""

import math

import _numbers as numbers
import pytest

pytestmark = pytest.mark.taichi

ENTRIES = numbers.entries()


@pytest.fixture(scope="module", autouse=True)
def runs(tmp_path_factory):
    """Keep the runs of this file in one folder, outside of the repository."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(numbers, "RUNS", tmp_path_factory.mktemp("numbers"))
        yield


def named(entry):
    """Return the name of the case of an entry."""
    return f"{entry.page}, {entry.source}"


@pytest.mark.parametrize("entry", ENTRIES, ids=named)
def test_a_text_with_numbers_is_on_its_page_once(entry):
    counts = {text: numbers.text_of(entry.page).count(numbers.plain(text)) for text in entry.numbers}
    assert counts == dict.fromkeys(entry.numbers, 1)


@pytest.mark.parametrize("entry", ENTRIES, ids=named)
def test_a_source_exists(entry):
    if entry.run:
        assert entry.config().name
    if entry.verify:
        keys = [key for keys in entry.numbers.values() for key in (keys if isinstance(keys, list) else [keys])]
        assert [key for key in keys if not entry.criteria(key)] in ([], ["rows"])
    if entry.quotes:
        assert entry.wrong() == []


@pytest.mark.parametrize("entry", [entry for entry in ENTRIES if entry.quick], ids=named)
def test_numbers_of_quick_sources_agree(entry):
    assert entry.wrong() == []


AGREE = [("3.6e-5", 3.6469e-5), ("0.0008%", 7.6e-6), ("46", 46), ("-4.37", -4.3749)]
DIFFER = [("3.6e-5", 3.6531e-5), ("0.0008%", 7.4e-6), ("46", 45), ("4.37", -4.3749), ("2.0", 2.06), ("2.0", math.nan)]


@pytest.mark.parametrize(("shown", "value", "expected"), [(*each, each in AGREE) for each in AGREE + DIFFER], ids=str)
def test_a_number_agrees_to_the_digits_that_are_shown(shown, value, expected):
    assert numbers.agrees(shown, value) == expected


def test_a_wrong_number_is_named_with_its_source():
    entry = numbers.Entry(page="README.md", run="configs/couette.yaml", numbers={"error {3.0e-6}": "l2"})
    entry.__dict__["found"] = {"l2": 2.62e-6}.get
    (line,) = entry.wrong()
    assert line == "README.md: 3.0e-6 in 'error 3.0e-6' is 2.62e-06 by tisph run configs/couette.yaml (l2)"
