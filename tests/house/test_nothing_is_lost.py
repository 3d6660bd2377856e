"""Commands, options and config keys of version 0.1.0 (commit ba37bb3) are all there still.

``data/commands.json`` and ``data/keys.json`` were written by this file's functions at that commit.
"""

import json
import re
from pathlib import Path

import pytest
import typer

from tisph import cli, registry
from tisph.config.reference import fields
from tisph.config.schema import FORMER_KEYS

DATA = Path(__file__).parent / "data"
FAMILIES = ["walls", "schemes", "rheology", "bodies"]
GONE = {"bench": {"name"}, "verify": {"--estimates"}}
"""What became scripts in ``benchmarks/``: names of benchmarks other than frontier are no argument's values any more,
and estimates of ``tisph check`` are compared with runs by ``benchmarks/estimates.py``."""


def commands():
    """Options and arguments of every command, those that its help shows, by its name."""
    found = {}
    for name, command in typer.main.get_command(cli.app).commands.items():
        found[name] = sorted(option for each in command.params for option in (*each.opts, *each.secondary_opts))
    return found


def all_keys():
    """Keys of the config of every scene, and of all parameters of every member of a family, by ``family/name``."""
    found = {}
    for family, model in {"scenes": "Config", **dict.fromkeys(FAMILIES, "Parameters")}.items():
        for name in registry.names(family):
            found[f"{family}/{name}"] = sorted(dict(fields(getattr(registry.load(family, name), model))))
    return found


@pytest.mark.parametrize("command", json.loads((DATA / "commands.json").read_text()))
def test_commands_and_their_options_are_still_there(command):
    before = set(json.loads((DATA / "commands.json").read_text())[command])
    assert before - set(commands()[command]) <= GONE.get(command, set())


@pytest.mark.parametrize("name", json.loads((DATA / "keys.json").read_text()))
def test_keys_of_configs_are_still_there(name):
    before = set(json.loads((DATA / "keys.json").read_text())[name])
    present = {re.sub(r"^[^.]+", lambda match: FORMER_KEYS.get(match.group(), match.group()), key) for key in before}
    assert present - set(all_keys()[name]) == set()
