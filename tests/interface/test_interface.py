"""``import tisph``: little is imported and shown, and what is asked for becomes the words of the command line."""

import pydoc
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import tisph
from tisph.config.loader import override_texts
from tisph.errors import ConfigError, DivergedError, TisphError
from tisph.interface import _error, _listen
from tisph.results._results import typed

MOST_LINES = 264
"""Of ``help(tisph)``: four screens of 66 lines."""


def test_importing_tisph_imports_nothing_that_takes_time():
    heavy = ("taichi", "numpy", "h5py", "matplotlib", "pydantic", "rich", "jinja2", "typer")
    program = f"import sys, tisph; tisph.__all__; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_is_a_few_screens_and_has_every_public_name():
    text = pydoc.plain(pydoc.render_doc(tisph))
    assert text.count("\n") <= MOST_LINES
    assert set(tisph.__all__) <= set(dir(tisph))
    for name in ("run(", "check(", "open = ", "class Results", "profile_figure", "history", "summary", "exact"):
        assert name in text


def test_overrides_are_yaml_of_plain_values():
    values = {"time.end": np.float64(1.5), "time.samples": np.array([0.5, 1.5]), "output.video": None, "name": "a: b"}
    assert override_texts(values) == ["time.end=1.5", "time.samples=[0.5, 1.5]", "output.video=null", 'name="a: b"']


def test_a_dict_and_a_checked_config_ask_for_what_a_file_does(case, couette):
    checked = case()
    assert tisph.check(checked).numbers == tisph.check(couette).numbers == tisph.check(checked.model_dump()).numbers
    small = {"discretisation.particles_across": 20}
    assert tisph.check(checked, **small).particles == tisph.check(couette, **small).particles == 20 * 40


def test_check_returns_what_the_command_prints(couette, capsys):
    forecast = tisph.check(couette, **{"scheme.type": "wcsph"})
    assert capsys.readouterr() == ("", "")
    assert str(forecast).startswith("case: valid (channel, wcsph, consistent_image)\n  Reynolds number        50")
    assert (forecast.reynolds, forecast.particles) == (pytest.approx(50.0, rel=1e-14), 5000)
    least, most = forecast.steps_range
    assert 1000 < least <= forecast.steps <= most
    assert forecast.run_time < forecast.total_time_range[1]
    assert forecast.resolved == (True,) * len(forecast.numbers["samples"])


def test_an_error_in_a_dict_names_no_file(case):
    with pytest.raises(ConfigError) as raised:
        tisph.check({**case().model_dump(), "time": {"end": -1.0}})
    assert str(raised.value) == "config: time.end = -1.0: must be greater than 0 (at least 1e-30)"
    with pytest.raises(ConfigError, match=r"^--set time.ende=1: time.ende = 1: unknown key; nearest: end"):
        tisph.check(case(), **{"time.ende": 1})


@pytest.mark.parametrize(
    ("status", "kind"), [(1, TisphError), (2, ConfigError), (3, DivergedError), (130, TisphError), (-9, TisphError)]
)
def test_an_exit_status_is_the_error_that_it_stands_for(status, kind):
    error = _error(status, "u is infinite\npartial results are in runs/x")
    assert type(error) is kind
    assert str(error).endswith("u is infinite\npartial results are in runs/x")


def test_events_of_a_run_are_told_from_what_else_it_says():
    shown, said = [], ["warning: it is slow\n", '{"progress": [0.25, "t = 1"]}\n', '{"other": 1}\n']
    found = _listen(SimpleNamespace(stderr=[*said, '{"error": "u is infinite"}\n']), lambda *each: shown.append(each))
    assert (found, shown) == ("u is infinite", [(0.25, "t = 1")])
    # without an error, as after an interrupt or a crash, all else that was said is the message
    assert _listen(SimpleNamespace(stderr=said), lambda *each: None) == 'warning: it is slow\n{"other": 1}'


def test_a_killed_run_has_a_summary_too():
    summary = typed({"status": "failed", "samples": []}, "couette")
    assert (summary.name, summary.status, summary.samples) == ("couette", "failed", ())
    assert summary.cost.steps is None
