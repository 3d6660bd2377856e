"""Whether a checkpoint fits a config: the one that it was made with, or one that goes on for longer."""

import json

from tisph.config import yaml_text
from tisph.config.yaml_text import in_one_line
from tisph.errors import ConfigError

OF_LATER_TIMES = ("time.end", "time.samples", "output.video.frames")
"""Keys that may differ where the end is later: up to the old end they decide nothing but what is looked at."""

MOST_SHOWN = 5

OTHER_STEPS = (
    "the steps before the checkpoint led to the old time.end, so that the bits are not those of a run that had the "
    "later one from the start"
)


def require_fit(path, made_with, asked, time):
    """Raise ConfigError with the keys that forbid a run of ``asked`` to go on from the checkpoint ``path`` at ``time``.

    ``made_with`` and ``asked`` are resolved configs, as YAML.
    """
    old, new = (yaml_text.parse(text).data for text in (made_with, asked))
    times = [data["time"] for data in (old, new)]
    later = times[1]["end"] > times[0]["end"]
    found = [text for key, text in _differences(old, new) if not (later and key in OF_LATER_TIMES)]
    found += _samples(times[0]["end"], *(data["samples"] for data in times), time) if later else []
    if found:
        more = f"; and {len(found) - MOST_SHOWN} more" if len(found) > MOST_SHOWN else ""
        raise ConfigError(
            f"{path}: the checkpoint is of another config: {'; '.join(found[:MOST_SHOWN])}{more}; resume with the one "
            "that it was made with, where only time.end may be later, with samples after the old end and more frames"
        )


def _samples(old_end, old_samples, new_samples, time):
    """Yield what is wrong with samples that a run to the old end had or should have had."""
    early = [[sample for sample in samples if sample < old_end] for samples in (old_samples, new_samples)]
    if early[0] != early[1]:
        yield f"time.samples before t = {old_end:g} were {early[0]}, are {early[1]}"
    if time >= old_end and old_end in new_samples and old_end not in old_samples:
        yield f"time.samples has t = {old_end:g}, which the checkpoint has passed without a sample"


def _differences(old, new, before=""):
    """Yield dotted key and words for all that differs between two nested maps."""
    for key in sorted(old.keys() | new.keys()):
        if isinstance(old.get(key), dict) and isinstance(new.get(key), dict):
            yield from _differences(old[key], new[key], f"{before}{key}.")
        elif old.get(key) != new.get(key):
            was, now = (in_one_line(json.dumps(data[key])) if key in data else "not given" for data in (old, new))
            yield f"{before}{key}", f"{before}{key} was {was}, is {now}"
