"""Which checkpoints fit a config: the message names the keys that differ."""

from pathlib import Path

import pytest

from tisph.errors import ConfigError
from tisph.simulation.checkpoint import require_fit

PATH = Path("checkpoint.h5")
OLD = ["time={end: 2.0, samples: [1.0]}"]


@pytest.fixture
def fit(case):
    """Return a function that asks whether a checkpoint at ``time`` of the old run fits the case with overrides."""

    def check(*overrides, time=1.5, old=OLD):
        require_fit(PATH, case(*old).resolved_yaml(), case(*old, *overrides).resolved_yaml(), time)

    return check


@pytest.mark.parametrize(
    ("later", "old", "time"),
    [
        (["time.end=3.0"], OLD, 1.5),
        (["time.end=3.0", "time.samples=[1.0, 2.5, 3.0]"], OLD, 1.5),
        (["time.end=3.0", "time.samples=[1.0, 2.0, 3.0]", "output.video.frames=240"], OLD, 1.5),
        (["time={end: 3.0, samples: [1.0, 3.0]}"], ["time={end: 2.0, samples: [1.0, 2.0]}"], 2.0),
    ],
)
def test_a_later_end_may_add_and_lose_samples_and_frames(fit, later, old, time):
    fit(*later, old=old, time=time)


@pytest.mark.parametrize(
    ("overrides", "wanted"),
    [
        (["time.end=3.0", "fluid.density=2.0"], ["fluid.density was 1.0, is 2.0"]),
        (["walls.top={amplitude: 1.0, angular_frequency: 2.0}"], ["walls.top.velocity was 0.5, is not given"]),
        (["runtime.threads=1", "initial.seed=3"], ['runtime.threads was "auto", is 1', "initial.seed was 0, is 3"]),
        (["output.video.frames=60"], ["output.video.frames was 120, is 60"]),
        (["output.video=null", "time.end=3.0"], ['output.video was {"fps": 30, "frames": 120', ", is null"]),
        (["time.end=1.8"], ["time.end was 2.0, is 1.8"]),
        (["time.samples=[1.0, 2.0]"], ["time.samples was [1.0], is [1.0, 2.0]"]),
        (["time={end: 3.0, samples: [0.5, 1.0]}"], ["time.samples before t = 2 were [1.0], are [0.5, 1.0]"]),
        (["time={end: 3.0, samples: [3.0]}"], ["time.samples before t = 2 were [1.0], are []"]),
    ],
)
def test_what_differs_is_named(fit, overrides, wanted):
    with pytest.raises(ConfigError) as caught:
        fit(*overrides)
    text = str(caught.value)
    assert text.startswith("checkpoint.h5: the checkpoint is of another config: ")
    assert [part for part in wanted if part not in text] == []


def test_a_sample_that_has_been_passed_is_not_to_be_had(fit):
    with pytest.raises(ConfigError, match=r"time.samples has t = 2, which the checkpoint has passed without a sample"):
        fit("time={end: 3.0, samples: [1.0, 2.0]}", time=2.0)
