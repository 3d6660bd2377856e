"""The rule of messages: an error says where, names the key with its value, and says what must be or what helps."""

import re
from pathlib import Path

import pytest

from tisph.config import load
from tisph.config.yaml_text import dump, parse
from tisph.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"
TABLE = parse((Path(__file__).parent / "data" / "refused.yaml").read_text(encoding="utf-8")).data
CASES = [(row["config"], changes, keys) for row in TABLE for changes, keys in row["refused"].items()]
HELPS = r"(must|is missing|unknown key|give|for|needs|nearest|allowed|take|leave|at (least|most))"


@pytest.mark.parametrize(("config", "changes", "keys"), CASES, ids=[f"{keys}-{text[:50]}" for _, text, keys in CASES])
def test_an_error_names_the_key_and_says_what_helps(tmp_path, config, changes, keys):
    path = CONFIGS / str(config)
    if isinstance(config, dict):
        path = tmp_path / "case.yaml"
        path.write_text(dump(config))
    with pytest.raises(ConfigError) as caught:
        load(path, changes.split(" | "))
    assert caught.value.exit_status == 2
    text = str(caught.value)
    for key in [keys] if isinstance(keys, str) else keys:
        assert re.search(
            rf"^(--set |{re.escape(str(path))}).*: {re.escape(key)}( = .+)?: .*{HELPS}", text, re.MULTILINE
        )
    assert text.replace("\n", "").isprintable()
    assert max(map(len, text.splitlines())) < 1000
