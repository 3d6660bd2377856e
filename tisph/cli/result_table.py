"""The result of a run as a short table, and what it took."""

from tisph.text_table import format_table

FORCES = ("drag", "lift", "torque", "wall_shear")
"""How the names of those numbers begin that are shown first; a scene without any shows what else is of its flow."""

PARTS = {
    "loop": "in the steps",
    "compile": "compiling",
    "output": "for output",
    "import": "getting ready",
}
"""Parts of the cost in ``summary.json``, and what they are called."""

MOST_NUMBERS = 4
MOST_SAMPLES = 10


def result_text(config, scene, summary):
    """Return a table of the last samples in ``summary`` (contents of ``summary.json``), and the time used, as text.

    The error is that of the velocity, against the reference; without one it is the estimate of ``--estimate-error``,
    where there is one. Numbers are in the units of the config.
    """
    texts, samples = [], summary["samples"]
    if samples:
        numbers = [name for name in scene.flow_quantities if name.startswith(FORCES)] or scene.flow_quantities
        numbers = [name for name in numbers if name in samples[0]][:MOST_NUMBERS]
        error = "rms error / U" if scene.vanishing_scale else "L2 error"
        titles = (name.replace("_", " ") for name in numbers)
        changes = [name for name in samples[0] if name.endswith("_change")]  # by which a flow is called steady
        judged = (title for name in changes for title in (name.replace("_", " "), "steady"))
        header = ("sample", f"t [{config.units.time}]", error, *titles, "resolved", *judged)
        estimates = (summary.get("error_estimate") or {}).get("samples") or [None] * len(samples)
        rows = [
            (str(index), f"{sample['t']:g}", _error(scene, sample, estimate), *_cells(sample, numbers, changes))
            for index, (sample, estimate) in enumerate(zip(samples, estimates, strict=True))
        ]
        texts.append(format_table(header, rows[-MOST_SAMPLES:]))
        if len(rows) > MOST_SAMPLES:
            texts.append(f"{len(rows) - MOST_SAMPLES} earlier samples are in summary.json")
        shown = list(enumerate(samples))[-MOST_SAMPLES:]
        texts += [f"sample {index} is not resolved: {each['reason']}" for index, each in shown if not each["resolved"]]
        if samples[-1].get("steady_reason"):
            texts.append(f"sample {len(samples) - 1} is not steady: {samples[-1]['steady_reason']}")
    contacts = _contacts(summary.get("numbers", {}), config.units)
    return "\n".join([*texts, *contacts, _time_used(summary["cost"])])


def _contacts(numbers, units):
    """Yield what there is to say of free bodies that have touched."""
    if numbers.get("contacts"):
        count, duration = numbers["contacts"], numbers["contact_time"]
        times = "once" if count == 1 else f"{count} times"
        yield (
            f"bodies touched {times}, for {duration:.3g} {units.time} in all: a model keeps them apart then, "
            "and what follows depends on it"
        )


def _error(scene, sample, estimate):
    value = sample["rms" if scene.vanishing_scale else "l2"]
    if value is not None:
        return f"{value:.2e}"
    value = estimate and estimate["fields"].get("velocity", {}).get("error")
    return "none" if value is None else f"{value:.1e} (estimate)"


def _cells(sample, numbers, changes):
    yield from ("none" if sample[name] is None else f"{sample[name]:.5g}" for name in numbers)
    yield "yes" if sample["resolved"] else "no"
    for name in changes:
        yield from ("none" if sample[name] is None else f"{sample[name]:.1e}", "yes" if sample["steady"] else "no")


def _time_used(cost):
    parts = ", ".join(f"{cost[f'wall_{part}_s']:.2g} s {words}" for part, words in PARTS.items())
    return f"{cost['steps']} steps, {cost['wall_total_s']:.3g} s: {parts}"
