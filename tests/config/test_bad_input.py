"""Every kind of bad input is one ConfigError that names file, line, key, value and what is allowed."""

import re

import pytest

from tisph.config import load
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


# (what to replace in GOOD, by what, what the message must contain)
TEXT_CASES = {
    "not_yaml": (GOOD, "a: [1, 2", ["case.yaml:1: is not YAML"]),
    "tab": (GOOD, "fluid:\n\tdensity: 1", ["case.yaml:2: a tab; YAML indents with spaces"]),
    "two_documents": (GOOD, "a: 1\n---\nb: 2", ["case.yaml:2", "single document"]),
    "empty": (GOOD, "", ["case.yaml: is empty", "map of keys"]),
    "list": (GOOD, "- 1\n- 2", ["case.yaml: is a list", "map of keys"]),
    "single_value": (GOOD, "hello", ["case.yaml: is a single value"]),
    "nested_list": ("walls:\n  top: {velocity: 0.005}", "walls: [1]", ["case.yaml:8: walls = [1]: must be a map"]),
    "nested_value": ("  top: {velocity: 0.005}", "  top: 0.005", ["case.yaml:9: walls.top = 0.005: must be a map"]),
    "nothing": ("{velocity: 0.005}", "", ["case.yaml:9: walls.top = null: must be a map"]),
    "python_tag": ("1000.0", "!!python/object/apply:os.getcwd []", ["case.yaml:3: tag !!python/object", "not allowed"]),
    "standard_tag": ("1000.0", "!!float 1000", ["case.yaml:3: tag !!float", "not allowed"]),
    "own_tag": ("1000.0", "!unit 1000", ["case.yaml:3: tag !unit", "not allowed"]),
    "anchor": ("1000.0", "&rho 1000.0", ["case.yaml:3: anchor &rho", "not allowed"]),
    "alias": ("1000.0", "*rho", ["case.yaml:3: alias *rho", "not allowed"]),
    "deep": (GOOD, "a: " + "[" * 10_000, ["case.yaml:1: nested more than"]),
    "duplicate": ("  gap: 0.01", "  gap: 0.01\n  gap: 0.02", ["case.yaml:7: duplicate key geometry.gap", "line 6"]),
    "number_as_key": ("scene: channel", "1: channel", ["case.yaml:1: key '1'", "words"]),
    "map_as_key": ("scene: channel", "? {a: 1}\n: channel", ["case.yaml:1: key", "words"]),
    "endless_integer": ("1000.0", "9" * 5000, ["case.yaml:3: cannot read the value '9999"]),
    "control_character": ("channel", "chan\x07nel", ["case.yaml", "is not YAML"]),
    "unknown_top": (
        "scene: channel",
        "scene: channel\nflud: {}",
        ["case.yaml:2: flud", "nearest: fluid", "allowed: name,"],
    ),
    "unknown_nested": ("density:", "densty:", ["case.yaml:3: fluid.densty = 1000.0: unknown key; nearest: density"]),
    "misplaced": ("scene: channel", "scene: channel\nsamples: [1]", ["case.yaml:2: samples", "nearest: time.samples"]),
    "no_scene": ("scene: channel\n", "", ["case.yaml: scene: is missing"]),
    "missing": ("  density: 1000.0\n", "", ["case.yaml:2: fluid.density: is missing"]),
    "missing_top": ("time:\n  end: 2.7\n", "", ["case.yaml: time: is missing"]),
    "quoted_number": ("1000.0", '"0.5"', ['case.yaml:3: fluid.density = "0.5": must be a number']),
    "word_for_number": ("1000.0", "water", ['case.yaml:3: fluid.density = "water": must be a number']),
    "boolean": ("1000.0", "true", ["case.yaml:3: fluid.density = true: must be a number"]),
    "date": ("1000.0", "2024-01-01", ["case.yaml:3: fluid.density", "must be a number"]),
    "nan": ("1000.0", ".nan", ["case.yaml:3: fluid.density = NaN: must be a finite number"]),
    "infinity": ("0.005", "-.inf", ["case.yaml:9: walls.top.velocity = -Infinity: must be a finite number"]),
    "overflow": ("1000.0", "1e999", ["case.yaml:3: fluid.density = Infinity: must be a finite number"]),
    "negative_density": ("1000.0", "-1", ["case.yaml:3: fluid.density = -1: must be greater than 0"]),
    "zero_viscosity": ("1.0e-3", "0", ["case.yaml:4: fluid.dynamic_viscosity = 0: must be greater than 0"]),
    "negative_gap": ("0.01", "-0.01", ["case.yaml:6: geometry.gap = -0.01: must be greater than 0"]),
    "zero_length": ("0.02", "0.0", ["case.yaml:7: geometry.length = 0.0: must be greater than 0"]),
    "huge_gap": ("0.01", "1e31", ["case.yaml:6: geometry.gap = 1e+31: must be at most 1e+30"]),
    "long_value": ("channel", "c" * 500, ["case.yaml:1: scene", "...", "must be one of annulus"]),
    "unknown_scene": ("channel", "chanel", ['case.yaml:1: scene = "chanel": must be one of', "; nearest: channel"]),
    "number_for_name": ("scene:", "name: 12\nscene:", ["case.yaml:1: name = 12: must be text"]),
    "control_in_key": ("density:", '"den\\nsity":', ["case.yaml:3: fluid.den\\nsity = 1000.0: unknown key"]),
    "long_key": ("density:", "d" * 500 + ":", ["case.yaml:3: fluid.ddd", "ddd... = 1000.0: unknown key"]),
    "decimal_comma": (
        "0.01",
        "0,01",
        ['case.yaml:6: geometry.gap = "0,01": must be a number, with a decimal point: 0.01'],
    ),
    "nothing_moves": ("0.005", "0.0", ["case.yaml:8: walls: nothing moves"]),
}


@pytest.mark.parametrize("case", TEXT_CASES)
def test_bad_text(message, case):
    old, new, wanted = TEXT_CASES[case]
    assert old in GOOD
    text = message(GOOD.replace(old, new, 1))
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


def test_several_mistakes_are_listed_in_the_order_of_the_lines(message):
    bad = GOOD.replace("1000.0", "-1").replace("0.01", "x").replace("2.7", ".nan")
    lines = message(bad).split("\n")
    assert [re.match(r"case.yaml:(\d+):", line).group(1) for line in lines] == ["3", "6", "11"]


def test_more_than_five_mistakes_are_counted(message):
    bad = GOOD + "".join(f"wrong{index}: 1\n" for index in range(7))
    lines = message(bad).split("\n")
    assert len(lines) == 6
    assert lines[-1] == "and 2 more"


def test_a_replaced_value_is_blamed_on_the_override(message):
    text = message(GOOD, "geometry={gap: -1, length: 0.02}")
    assert text.startswith("--set geometry={gap: -1, length: 0.02}: geometry.gap = -1")


def test_of_two_conflicting_values_the_later_one_is_reported(message):
    content = GOOD.replace("0.02\n", "0.025\n") + "discretisation: {particles_across: 50}\n"
    text = message(content, "discretisation.particles_across=51")
    assert text.startswith(
        "--set discretisation.particles_across=51: discretisation.particles_across = 51: 51 particles"
    )
    assert text.endswith(
        "; nearest valid geometry.length: 0.0249019607843 or 0.0250980392157; nearest valid particles_across: 50 or 52"
    )
    assert message(content, "geometry.length=0.0251").startswith(
        "--set geometry.length=0.0251: geometry.length = 0.0251"
    )
    assert message(content.replace("50}", "51}")).startswith("case.yaml:12: discretisation.particles_across = 51")


def test_an_item_of_a_list_is_set_by_its_index(message):
    content = GOOD + "  samples: [1.0, 2.0]\n"
    for index in ("2", "-1", "end"):
        assert message(content, f"time.samples.{index}=1.5") == (
            f"--set time.samples.{index}=1.5: time.samples is a list of 2: {index} must be its index, from 0 on"
        )
    text = message(content, "time.samples.0=-1.5")
    assert text.startswith("--set time.samples.0=-1.5: time.samples.0 = -1.5: ")


def test_an_item_of_a_list_has_its_new_value(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD + "  samples: [1.0, 2.0]\n")
    assert load(path, ["time.samples.0=1.5"]).time.samples == (1.5, 2.0)


def test_whole_numbers_may_be_written_as_floats(tmp_path, message):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    across = load(path, ["discretisation.particles_across=10.0"]).discretisation.particles_across
    assert (across, type(across)) == (10, int)
    for value in ("10.5", "true", "'10'"):
        assert "must be a whole number" in message(GOOD, f"discretisation.particles_across={value}")


def test_not_utf8(message):
    assert "case.yaml:2: is not UTF-8 text" in message(b"scene: channel\nname: \xff\xfe\n")


def test_binary_and_huge_files(message):
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
