"""A judgement as text, as JSON and as a picture."""

import json

from tisph.report.plots import profile_figure
from tisph.text_table import format_table

NUMBERS, PICTURE = "comparison.json", "comparison.png"

ERRORS = {"l2": "L2 error", "rms": "rms error / U", "linf": "largest error / U"}

BLIND = (
    "Slope and intercept are those of a straight line through the probes. They are blind to every error that is\n"
    "symmetric about mid-gap, so they can verify nothing by themselves: read L2, centreline and wall shear."
)


def text(judgement, name):
    """What is printed: a table with a column for each sample, then words."""
    samples = judgement.samples
    parts = [_heading(samples, name), format_table(_header(samples), _rows(samples))]
    if any(each.numbers.get("slope") is not None for each in samples):
        parts.append(BLIND)
    return "\n\n".join([*parts, "\n".join(_findings(judgement))])


def _heading(samples, name):
    lines = [f"against the reference of {name}:"]
    for path in dict.fromkeys(each.path for each in samples):
        own = [each for each in samples if each.path == path]
        scene = own[0].scene
        spacing = f"{scene.spacing:.4g} {scene.units.length}"
        lines.append(f"  {path}: {own[0].aligned.points} points, spacing {spacing}")
        lines += [f"    {note}" for note in dict.fromkeys(note for each in own for note in each.aligned.notes)]
    return "\n".join(lines)


def _header(samples):
    several = len({each.path for each in samples}) > 1
    return ["", *(f"{each.path.stem if several else ''} t = {each.numbers['t']:g}".strip() for each in samples)]


def _rows(samples):
    rows = [["t*", *(f"{each.numbers['t_star']:.4g}" for each in samples)]]
    rows.append(["resolved", *("yes" if each.numbers["resolved"] else "no" for each in samples)])
    for key, label in ERRORS.items():
        rows.append([label, *("-" if each.numbers[key] is None else f"{each.numbers[key]:.3e}" for each in samples)])
    keys = dict.fromkeys(key for each in samples for key in each.numbers)
    for key in keys:
        if f"{key}_exact" in keys:
            rows.append([f"{key.replace('_', ' ')} (exact)", *(_beside(each.numbers, key) for each in samples)])
    return rows


def _beside(numbers, key):
    value, exact = numbers.get(key), numbers.get(f"{key}_exact")
    if value is None or exact is None:
        return "-"
    return f"{value:.5g} ({exact:.5g}{_off(value, exact)})"


def _off(value, exact):
    """How far a number is off, in words: nothing beside an exact one of 0."""
    if not exact:
        return ""
    ratio = value / exact
    if abs(ratio - 1) > 1:
        return f", {ratio:.2g} times"
    return f", {100 * abs(ratio - 1):.2g} % off" if abs(ratio - 1) > 1e-8 else ""


def _findings(judgement):
    for each in judgement.samples:
        yield f"t = {each.numbers['t']:g}, {each.across} across: error {each.location['words']}"
        if not each.numbers["resolved"]:
            yield f"  not resolved: {each.numbers['reason']}"
    yield from judgement.trends
    for t, order in judgement.orders.items():
        yield f"t = {t:g}: the error falls with the power {order:.2g} of the spacing"
    for label, found in judgement.diagnoses.items():
        yield from _diagnosis(label, found)


def _diagnosis(label, found):
    if not found.explaining:
        if found.fits:
            yield f"{label}: no single fault that is looked for explains the error"
        return
    several = len(found.explaining) > 1
    yield f"{label}: what would explain the error" + (", and cannot be told apart by these data:" if several else ":")
    for each in found.explaining:
        yield f"  {each.words}; the rms error would fall from {found.error:.2e} U to {each.remain:.2e} U"
    if several:
        yield "  data of more times, or of a flow with another drive, may tell them apart"


def write(judgement, folder):
    """Write numbers and picture into ``folder``, in place of those of an earlier comparison; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    numbers, picture = folder / NUMBERS, folder / PICTURE
    numbers.write_text(json.dumps(_as_data(judgement), indent=1), encoding="utf-8")
    finest = min(each.scene.spacing for each in judgement.samples)
    shown = [each for each in judgement.samples if each.scene.spacing == finest]
    profile_figure(shown[0].scene, [each.aligned.snapshot for each in shown]).save(picture)
    return numbers, picture


def _as_data(judgement):
    samples = [
        {
            "file": str(each.path),
            "points": each.aligned.points,
            "spacing": float(each.scene.spacing),
            "placed": list(each.aligned.notes),
            **each.numbers,
            "where": each.location,
        }
        for each in judgement.samples
    ]
    diagnoses = {
        label: {
            "rms": found.error,
            "explained_by": [each.fault.name for each in found.explaining],
            "words": [each.words for each in found.explaining],
            "fits": {each.fault.name: {"value": each.value, "rms_that_remains": each.remain} for each in found.fits},
        }
        for label, found in judgement.diagnoses.items()
    }
    return {
        "samples": samples,
        "trends": judgement.trends,
        "orders": {str(t): order for t, order in judgement.orders.items()},
        "diagnoses": diagnoses,
    }
