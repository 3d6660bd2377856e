"""Pages of the gallery: their files are whole, their configs load, and a number out of its bound is named."""

import _gallery as gallery
import pytest

from tisph import config

FLOWS = gallery.flows()
JOBS = {job.name: job for name, flow in FLOWS.items() for job in gallery.jobs(name, flow)}
SUMMARY = {"samples": [{"l2": 1.0e-3, "drag": 2.0, "drag_top": -1.5}, {"l2": 2.0e-5, "drag": 2.02, "drag_exact": 2.0}]}


def test_there_are_twelve_pages_with_two_exercises_each():
    assert len(FLOWS) >= 12
    assert {name: len(flow["try"]) for name, flow in FLOWS.items()} == dict.fromkeys(FLOWS, 2)


@pytest.mark.parametrize("name", JOBS)
def test_settings_of_a_page_are_those_of_a_config(name):
    assert config.load(JOBS[name].config, JOBS[name].settings).name


@pytest.mark.parametrize("name", FLOWS)
def test_each_number_in_a_text_is_asserted(name):
    flow = FLOWS[name]
    texts = [(flow[key], flow["numbers"]) for key in ("question", "story")]
    texts += [(exercise["answer"], exercise["numbers"]) for exercise in flow["try"]]
    for text, checks in texts:
        used = set(gallery.re.findall(r"<<(\w+)>>", text))
        assert used <= {check["name"] for check in checks}
        assert all("below" in check or {"equals", "within"} <= set(check) for check in checks)


def test_a_number_out_of_its_bound_is_named():
    small = {"name": "error", "key": "samples.0.l2", "below": 1.0e-4}
    near = {"name": "drag", "key": "samples.-1.drag", "equals": "samples.-1.drag_exact", "within": 1.0e-3}
    lines = gallery.failures("page", SUMMARY, [small, near])
    assert lines == [
        "gallery page page: error (samples.0.l2) is 0.001, not below 0.0001",
        "gallery page page: drag (samples.-1.drag) is 2.02, not 2 within 0.001",
    ]
    assert gallery.failures("page", SUMMARY, [small | {"below": 2.0e-3}, near | {"within": 0.02}]) == []


def test_a_number_that_is_not_finite_is_out_of_its_bound():
    check = {"name": "error", "key": "samples.0.l2", "below": 1.0}
    assert gallery.failures("page", {"samples": [{"l2": float("nan")}]}, [check])


def test_a_key_may_be_a_sum():
    assert gallery.value(SUMMARY, "samples.0.drag + samples.0.drag_top") == 0.5


def test_texts_show_the_numbers_of_the_run():
    checks = [{"name": "error", "key": "samples.-1.l2"}, {"name": "drag", "key": "samples.-1.drag"}]
    assert gallery.filled("<<error>> and <<drag>>", SUMMARY, checks) == "2.0e-5 and 2.02"
    with pytest.raises(KeyError):
        gallery.filled("<<lift>>", SUMMARY, checks)


def test_a_run_is_made_again_when_its_settings_change():
    job = JOBS["couette"]
    assert gallery.Job(job.name, job.config, (*job.settings, "initial.seed=1")).stamp() != job.stamp()
