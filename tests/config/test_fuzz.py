"""Whatever stands in a config file is a Config or one ConfigError, never another exception."""

import random
import re

import pytest

from tisph.config import Config, load
from tisph.errors import ConfigError

GOOD = """\
name: couette
scene: channel
units: {length: cm, mass: g, time: s}
fluid:
  density: 1.0
  dynamic_viscosity: 1.0e-2
  rheology: {type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}
geometry: {gap: 1.0, length: 2.0}
walls:
  treatment: {type: consistent_image}
  bottom: {velocity: 0.0}
  top: {velocity: 0.5}
drive: {acceleration: 0.02}
initial: {state: rest, jitter: 0.2, seed: 3}
discretisation: {particles_across: 25, kernel: wendland_c2, smoothing_ratio: 1.2, precision: f64}
scheme:
  type: wcsph
  equation_of_state: {type: tait, gamma: 7, sound_speed: 5.0}
time: {end: 2.7, samples: [1.8, 2.7], cfl: 0.2}
tracers: {count: 10, x: centre}
output:
  video: {fps: 30, frames: 100, width: 640, height: 480, color_by: speed}
  checkpoint_every: 0.5
runtime: {arch: cpu, threads: 2}
"""
SHORT = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 1.0e-2}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
time: {end: 2.7}
"""
HEATED = """\
temperature:
  conductivity: 1.0
  heat_capacity: 1.0
  initial: sin(pi*x)*exp(-y)
  source: 0.1
  walls: {top: 1.0, bottom: {flux: 0.1*t}}
  viscosity: {type: arrhenius, activation_temperature: 2.0}
  reference: 300.0
  unit: K
scalars: [{name: dye, diffusivity: 0.1, walls: {top: 1.0}, initial: max(x,y)}]
"""
WORDS = re.findall(r"[\w.]+|[^\w\s]|\n *", GOOD)

HOSTILE = [
    *("null", "~", "true", "yes", "on", "''", '""', "[]", "{}", "{null: 1}", "{1: 2}", "[[[[]]]]", "? a", "- a", "<<"),
    *("0", "-0.0", "1e-320", "1e308", "1e999", "-1e999", ".nan", ".inf", "-.Inf", "0x1F", "0o17", "0b1", "1_000"),
    *("9" * 400, "-" + "9" * 5000, "1e" + "9" * 400, "0." + "0" * 400 + "1", "1:30", "190:20:30.15", "+.5", "5."),
    *("2024-01-01", "2024-02-31", "0000-00-00", "2001-12-14t21:59:43.10-05:00", "9999-99-99 99:99:99", "0001-01-01"),
    *("!!int 3", "!!python/name:os.system", "!", "!<x> 1", "&a 1", "*a", "&a [*a]", "%YAML 1.1", "---", "...", "`"),
    *(r'"\ud800"', r'"\0"', r'"\x7f"', r'"\u2028"', r'"\U0010ffff"', '"\\\n"', "'", '"', "|", ">", "|2\n  x", "# x"),
    *("a" * 3000, "ä", "\u202e", "\ufeff", "\u0085", "__class__", "__init__", "model_config", "type", "..", "0.0.0"),
    *("<word>", "<or auto>", "{type: {}}", "{type: []}", "{type: null}", "{type: _images}", "{type: ../x}", "{text}"),
    *("{type: 1, 2: 3}", "{type: wcsph, type: wcsph}", "{loc: [1], ctx: {}}", "%(x)s", "{0}", "{a: {b: {c: {d: e}}}}"),
]


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    """Return a function that loads text or bytes, with overrides, and returns the Config or the error's message."""
    path = tmp_path_factory.mktemp("fuzz") / "case.yaml"

    def load_text(content, *overrides):
        path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass"))
        try:
            result = load(path, overrides)
        except ConfigError as error:
            message = str(error)
            assert message
            assert message.replace("\n", "").isprintable(), ascii(message)
            assert len(message) < 5000
            return message
        assert isinstance(result, Config)
        path.write_text(result.resolved_yaml(), encoding="utf-8")
        assert load(path) == result
        return result

    return load_text


@pytest.mark.parametrize("most", [1, pytest.param(5, marks=pytest.mark.slow)])
@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: ascii(text[:20]))
def test_hostile_keys_and_values_anywhere(outcome, text, most):
    draw = random.Random(text)
    values = list(re.finditer(r"(?<=: )[\w.]+(?=[,}\n])", GOOD))
    keys = list(re.finditer(r"\w+(?=:)", GOOD))
    for match in draw.sample(values, most) + draw.sample(keys, most):
        outcome(GOOD[: match.start()] + text + GOOD[match.end() :])
    lines = GOOD.splitlines()
    for place in draw.sample(range(len(lines) + 1), most):
        outcome("\n".join([*lines[:place], text, *lines[place:]]))
    for override in (f"fluid.{text}=1", text, f"walls.treatment={text}"):
        outcome(SHORT, override)


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: ascii(text[:20]))
def test_hostile_keys_and_values_of_a_temperature(outcome, text):
    draw = random.Random(text)
    values = list(re.finditer(r"(?<=: )[\w.*(),+-]+?(?=[,}\n])", HEATED))
    keys = list(re.finditer(r"\w+(?=:)", HEATED))
    for match in draw.sample(values, 2) + draw.sample(keys, 1):
        outcome(SHORT + HEATED[: match.start()] + text + HEATED[match.end() :])


MORE = [pytest.param(seed, marks=pytest.mark.slow) for seed in range(6, 40)]


@pytest.mark.parametrize("seed", [*range(6), *MORE])
def test_mutations_of_a_good_file(outcome, seed):
    draw = random.Random(seed)
    good = refused = 0
    for _ in range(25):
        words = list(WORDS)
        for _ in range(draw.randint(1, 4)):
            place = draw.randrange(len(words))
            action = draw.choice(["drop", "double", "swap", "other", "hostile", "cut"])
            if action == "drop":
                del words[place]
            elif action == "double":
                words.insert(place, words[place])
            elif action == "swap":
                other = draw.randrange(len(words))
                words[place], words[other] = words[other], words[place]
            elif action == "other":
                words[place] = draw.choice(WORDS)
            elif action == "hostile":
                words[place] = draw.choice(HOSTILE)
            else:
                del words[place : place + draw.randint(1, 30)]
        text = "".join(word if word in ",:" or word.startswith("\n") else f" {word}" for word in words)
        result = outcome(text.lstrip())
        good, refused = good + isinstance(result, Config), refused + isinstance(result, str)
    assert refused > 0


@pytest.mark.parametrize("seed", [0, 1, *MORE])
def test_damaged_bytes_of_a_good_file(outcome, seed):
    draw = random.Random(seed)
    for _ in range(60):
        content = bytearray(GOOD.encode())
        for _ in range(draw.randint(1, 5)):
            content[draw.randrange(len(content))] = draw.randrange(256)
        outcome(bytes(content[: draw.choice([len(content), draw.randrange(len(content))])]))
