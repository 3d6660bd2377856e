"""Short runs, and which names of their files the page of files does not have."""

import re

import _files
import pytest

import tisph
from tisph import simulation
from tisph.config import loader

NAMED = {re.split(r"[/=(]", name)[0] for name in re.findall(r"`([^`\n]+)`", _files.files_page())}


def run(config, folder, **changes):
    """Return the results of a run in this process, with little history and without pictures, which have no keys."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tisph.observers.history.RECORDS", 21)
        settings = loader.loaded(config, changes)
        return tisph.open(simulation.run(settings, folder, pictures=False, video=False))


def plain(name):
    """A key without the number or the wall of a body, and without what marks the exact value."""
    name = re.sub(r"_exact$", "", name)
    name = re.sub(r"^(force|torque)_(body_\d+|bottom|top|left|right|around_\d+)$", r"\1_NAME", name)
    return re.sub(r"_(\d+|around)$|^(drag|lift)(_pressure)?_(bottom|top)$", r"\2\3", name)


def missing(names):
    """Those of the names that the page does not have."""
    return {name for name in names if not {name, plain(name)} & NAMED}
