"""Every kind of bad input is one ConfigError that names file, line and key, and is written in one printable line."""

import re
from pathlib import Path

import pytest

from tisph.config import load
from tisph.config.yaml_text import parse
from tisph.errors import ConfigError

GOOD = """\
scene: channel
fluid:
  density: 1000.0
  dynamic_viscosity: 1.0e-3
geometry:
  gap: 0.01
  length: 0.02
walls:
  top: {velocity: 0.005}
time:
  end: 2.7
"""
TEXTS = parse((Path(__file__).parent / "data" / "bad_text.yaml").read_text(encoding="utf-8")).data
CONFIGS = Path(__file__).parents[2] / "configs"
LONG = {"DEEP": "a: " + "[" * 10_000, "NINES": "9" * 5000, "LONG:": "d" * 500 + ":"}


@pytest.fixture
def message(tmp_path):
    """Write text or bytes to case.yaml, load it, and return the message of the error it must raise."""

    def load_bad(content, *overrides):
        path = tmp_path / "case.yaml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        with pytest.raises(ConfigError) as caught:
            load(path, overrides)
        assert caught.value.exit_status == 2
        return str(caught.value).replace(str(path), "case.yaml")

    return load_bad


@pytest.mark.parametrize(("old", "new", "wanted"), TEXTS.values(), ids=list(TEXTS))
def test_bad_text(message, old, new, wanted):
    assert old in GOOD
    text = message(GOOD.replace(old or GOOD, LONG.get(new, new), 1))
    assert [part for part in wanted if part not in text] == []
    assert len(text) < 1000
    assert text.replace("\n", " ").isprintable()


@pytest.mark.parametrize(
    ("override", "wanted"),
    [
        ("fluid", "must look like key.path=value"),
        ("=1", "must look like key.path=value"),
        ("a..b=1", "must look like key.path=value"),
        ("time.end=[1", "--set time.end=[1: the value is not YAML"),
        ("time.end=!!float 3", "tags are not allowed"),
        ("time.end.x=3", "time.end is not a map of keys"),
        ("geometry={gap: 1,5, length: 2}", "key '5': keys must be words; a decimal comma? write gap: 1.5"),
        ("geometry={1,5: 2}", "key '1': keys must be words"),
        ("ends.left.flow_rate=1", "unknown key; velocity is the mean over the inlet: the flow rate over its width"),
    ],
)
def test_an_override_that_is_none_is_refused(message, override, wanted):
    assert wanted in message(GOOD + "ends: {left: {type: inlet, velocity: 1}, right: {type: outlet}}\n", override)


@pytest.mark.parametrize(
    ("scene", "key", "wanted"),
    [
        ("cavity", "ends", "unknown key; only for scenes channel, pipe, region; allowed"),
        ("taylor_green", "outlet", "a value of ends.left.type, ends.right.type, only for scenes channel, pipe, region"),
        ("carried_circle", "ends.inlet", "ends.inlet = 1: unknown key; a value of ends.left.type, ends.right.type"),
        ("couette", "turning", "unknown key; only for scene region;"),
    ],
)
def test_a_key_of_other_scenes_names_them(scene, key, wanted):
    with pytest.raises(ConfigError, match=re.escape(wanted)):
        load(CONFIGS / f"{scene}.yaml", [f"{key}=1"])


@pytest.mark.parametrize("names", [("tracers", "probes"), ("probes", "tracers")])
def test_overrides_by_the_former_and_the_present_name_are_refused(message, names):
    text = message(GOOD, *(f"{name}.count=5" for name in names))
    assert text == f"--set {names[1]}.count=5: probes: is the new name of tracers: give one of them"


def test_several_mistakes_are_listed_in_order_up_to_five(message):
    lines = message(GOOD.replace("1000.0", "-1").replace("0.01", "x").replace("2.7", ".nan")).split("\n")
    assert [re.match(r"case.yaml:(\d+):", line).group(1) for line in lines] == ["3", "6", "11"]
    lines = message(GOOD + "".join(f"wrong{index}: 1\n" for index in range(7))).split("\n")
    assert (len(lines), lines[-1]) == (6, "and 2 more")


def test_a_replaced_value_is_blamed_on_the_override(message):
    text = message(GOOD, "geometry={gap: -1, length: 0.02}")
    assert text.startswith("--set geometry={gap: -1, length: 0.02}: geometry.gap = -1")


def test_of_two_conflicting_values_the_later_one_is_reported(message):
    content = GOOD.replace("0.02\n", "0.025\n") + "discretisation: {particles_across: 50}\n"
    text = message(content, "discretisation.particles_across=51")
    assert text.startswith("--set discretisation.particles_across=51: discretisation.particles_across = 51: ")
    text = message(content, "geometry.length=0.0251")
    assert text.startswith("--set geometry.length=0.0251: geometry.length = 0.0251")
    assert message(content.replace("50}", "51}")).startswith("case.yaml:12: discretisation.particles_across = 51")


def test_an_item_of_a_list_is_set_by_its_index(message, tmp_path):
    content = GOOD + "  samples: [1.0, 2.0]\n"
    for index in ("2", "-1", "end"):
        assert message(content, f"time.samples.{index}=1.5") == (
            f"--set time.samples.{index}=1.5: time.samples is a list of 2: {index} must be its index, from 0 on"
        )
    text = message(content, "time.samples.0=-1.5")
    assert text.startswith("--set time.samples.0=-1.5: time.samples.0 = -1.5: ")
    assert load(tmp_path / "case.yaml", ["time.samples.0=1.5"]).time.samples == (1.5, 2.0)


def test_whole_numbers_may_be_written_as_floats(tmp_path, message):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    across = load(path, ["discretisation.particles_across=10.0"]).discretisation.particles_across
    assert (across, type(across)) == (10, int)
    for value in ("10.5", "true", "'10'"):
        assert "must be a whole number" in message(GOOD, f"discretisation.particles_across={value}")


def test_files_that_are_no_text_or_too_large(message):
    assert "case.yaml:2: is not UTF-8 text" in message(b"scene: channel\nname: \xff\xfe\n")
    assert "case.yaml" in message(bytes(range(256)))
    assert "is larger than" in message("# x\n" * 100_000)


def test_missing_file_names_the_nearest(tmp_path):
    (tmp_path / "couette.yaml").write_text(GOOD)
    with pytest.raises(ConfigError, match=r"couete.yaml: no such file; nearest: couette.yaml"):
        load(tmp_path / "couete.yaml")


@pytest.mark.parametrize("path", ["", ".", "a\0b", "x" * 5000, "no/such/folder/x.yaml"])
def test_unreadable_path(path):
    with pytest.raises(ConfigError):
        load(path)


def test_more_memory_than_the_machine_has(message, monkeypatch):
    # 5000 particles have fields for 10 000
    monkeypatch.setattr("tisph.config.schema.physical_bytes", lambda: 1_000_000)
    assert "would need about 25.6 MB of memory; this machine has 1 MB" in message(GOOD)
