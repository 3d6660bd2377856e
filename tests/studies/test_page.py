"""The verification page's case: its table, and what runs for it. Nothing is simulated."""

import pytest

from tisph.errors import ConfigError
from tisph.studies import verify


def page_summary(status="done", **changes):
    sample = {"t": 1.8, "t_star": 0.018, "slope": 0.343, "slope_exact": 0.35, "intercept": -0.0973, "l2": 0.0013}
    sample |= {"centreline": 0.0042, "centreline_exact": 0.0041, "density_variation": 2e-5}
    sample |= {"wall_shear_bottom": 4e-11, "wall_shear_bottom_exact": 3.9e-11}
    sample |= {"wall_shear_top": 2.1e-5, "wall_shear_top_exact": 2.11e-5, **changes}
    return {"status": status, "numbers": {"reynolds": 50.0, "mach": 0.1}, "samples": [sample]}


def test_the_page_table_survives_runs_that_did_not():
    """A sample that is not finite gives dashes, a run without samples its status."""
    broken = page_summary("diverged", slope=None, l2=None)
    text = verify.page_table({"re50": broken, "re5": {"status": "failed", "samples": []}})
    rows = [line for line in text.splitlines() if line.startswith("| re")][1:]
    assert [part in rows[0] for part in ("re50 (diverged)", " - ")] == [True, True]
    assert "re5 (failed)" in rows[1]


@pytest.fixture
def page_configs(monkeypatch, tmp_path):
    """A checkout with the configs of two readings, as the working directory."""
    (tmp_path / "configs").mkdir()
    for name in ("re50", "developed"):
        (tmp_path / "configs" / f"vm_sph_001_{name}.yaml").write_text(f"name: {name}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(verify, "READINGS", {"re50": "water", "developed": "linear"})
    return tmp_path


def test_the_page_needs_every_reading_to_finish(fake_process, page_configs, monkeypatch, capsys):
    seen, outcomes = fake_process
    monkeypatch.setattr(verify, "page_table", lambda summaries: f"table of {', '.join(summaries)}")
    assert verify.run_page() is True
    assert [config["name"] for config in seen] == ["re50", "developed"]
    assert capsys.readouterr().out.endswith("table of re50, developed\n\n2 of 2 readings reached their end\n")
    outcomes["developed"] = "diverged: velocity of particle 7"
    assert verify.run_page() is False
    output = capsys.readouterr().out
    assert "developed did not finish: diverged" in output
    assert output.endswith("\n1 of 2 readings reached their end; FAIL: developed\n")


def test_without_the_pages_configs_the_message_says_where_they_are(page_configs, monkeypatch):
    monkeypatch.setattr(verify, "READINGS", {"no_such_reading": ""})
    with pytest.raises(ConfigError, match="vm_sph_001_no_such_reading"):
        verify.run_page()


def test_rounding_errors_are_not_shown_as_numbers():
    exact = page_summary(slope=0.5 + 1e-16, slope_exact=0.5, intercept=-1e-17)
    row = verify.page_table({"developed": exact}).splitlines()[2]
    assert row.count("< 1e-6 %") == 2
    assert "-0.00000" not in row
