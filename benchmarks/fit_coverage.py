"""Whether the intervals of ``tisph fit`` are right: fits of many noisy data sets whose values are known.

    python benchmarks/fit_coverage.py couette --sets 100
    python benchmarks/fit_coverage.py laws

prints for each key how many of the 95 % intervals contain the true value, and the mean error over the standard error;
then the median of the processor time and of the predictions of a fit, the fits that are called doubtful, and the
largest relative error with data without noise. Noise is 1 % of the largest velocity, or of each value of a rheometer.
Starting points are predicted once for all data sets of a case, so that the first fit has the time of a fit alone.
``hidden`` fits a key on which the data do not depend, ``laws`` and ``polymers`` choose among four laws. In steady shear
FENE-P and linear Phan-Thien-Tanner fluids have the same viscosity and N1: ``polymers`` cannot tell these two apart.
"""

import argparse
import json
import statistics
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from tisph.assessment.measurements import RELATIVE, Measurements
from tisph.config.loader import override_texts
from tisph.studies import fit
from tisph.studies.predictions import Predictor

NOISE = 0.01
RHEOLOGY, VISCOSITY = "fluid.rheology.", "fluid.dynamic_viscosity"
FLUID = {"density": 1.0, "dynamic_viscosity": 1.0}
CHANNEL = {"scene": "channel", "fluid": FLUID, "geometry": {"gap": 1.0, "length": 2.0}, "time": {"end": 2.0}}
ANNULUS = {**CHANNEL, "scene": "annulus", "geometry": {"inner_radius": 1.0, "outer_radius": 2.0}}
COUETTE = {**CHANNEL, "walls": {"top": {"velocity": 1.0}}}
FAST = {**CHANNEL, "walls": {"top": {"velocity": 5.0}}}
ROTATING = {**ANNULUS, "walls": {"inner": {"angular_velocity": 10.0}}}
POLYMER = {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.1}
GIESEKUS = {**POLYMER, "type": "giesekus", "mobility": 0.3}
CARREAU = {"type": "carreau_yasuda", "time": 1.0, "index": 0.5}
PLASTIC = {"type": "herschel_bulkley", "yield_stress": 1.0, "index": 0.6, "reference_rate": 1.0, "regularisation": 1e3}
MODES = {
    "type": "multi_mode",
    "solvent_fraction": 0.1,
    "modes": [
        {"type": "oldroyd_b", "relaxation_time": 10.0, "fraction": 0.6},
        {"type": "oldroyd_b", "relaxation_time": 0.1, "fraction": 0.3},
    ],
}


def profiles(start, end, times):
    """Places and times of profiles along y of 19 points, and the component of the velocity."""
    places = start + (end - start) * (np.arange(19) + 1) / 20
    y = np.tile(places, len(times))
    return "velocity", {"t": np.repeat(times, 19), "x": 0.0 * y + 1.0, "y": y}, ["u"]


def between_cylinders(times):
    """Places on a radius at some times, and the velocity around the axis."""
    kind, at, _ = profiles(1.0, 2.0, times)
    return kind, {**at, "x": at["y"], "y": 0.0 * at["y"]}, ["v"]


RATES = {"shear_rate": np.geomspace(0.01, 100.0, 24)}
SHEAR = "rate", RATES, ["viscosity"]
NORMAL = "rate", {"shear_rate": np.geomspace(0.1, 20.0, 16)}, ["viscosity", "n1"]
MODULI = "frequency", {"angular_frequency": np.geomspace(0.01, 100.0, 24)}, ["storage_modulus", "loss_modulus"]

CASES = {
    "couette": (COUETTE, POLYMER, profiles(0.0, 1.0, [0.3, 0.8, 2.0]), ["relaxation_time", "solvent_fraction"]),
    "carreau": (ROTATING, CARREAU, between_cylinders([0.1, 0.3, 1.0]), ["", "time", "index"]),
    "giesekus": (
        FAST,
        GIESEKUS,
        profiles(0.0, 1.0, [0.3, 1.0, 4.0]),
        ["relaxation_time", "solvent_fraction", "mobility"],
    ),
    "one_mode": (COUETTE, POLYMER, MODULI, ["", "relaxation_time", "solvent_fraction"]),
    "two_modes": (
        COUETTE,
        MODES,
        MODULI,
        ["", "modes.0.relaxation_time", "modes.1.relaxation_time", "modes.0.fraction", "modes.1.fraction"],
    ),
    "carreau_curve": (
        COUETTE,
        {**CARREAU, "fraction_at_infinity": 0.05},
        SHEAR,
        ["", "time", "index", "fraction_at_infinity"],
    ),
    "plastic_curve": (COUETTE, PLASTIC, SHEAR, ["", "yield_stress", "index"]),
    "hidden": (COUETTE, POLYMER, SHEAR, ["", "relaxation_time"]),
}
"""Config, fluid, kind and places of the data, and free keys, of which the empty one is the viscosity."""

BOUNDS = {
    "": (0.1, 10.0), "relaxation_time": (0.1, 10.0), "solvent_fraction": (0.01, 0.9), "time": (0.1, 10.0),
    "index": (0.3, 1.0), "mobility": (0.01, 0.9), "modes.0.relaxation_time": (1.0, 100.0), "extensibility": (0.01, 0.9),
    "modes.1.relaxation_time": (0.01, 1.0), "modes.0.fraction": (0.05, 0.9), "modes.1.fraction": (0.02, 0.9),
    "fraction_at_infinity": (0.001, 0.5), "yield_stress": (0.1, 10.0), "maximum_extension": (5.0, 500.0),
}  # fmt: skip

LAWS = {
    "laws": (
        SHEAR,
        {
            "newtonian": {"type": "newtonian"},
            "power_law": {"type": "power_law", "index": 0.6, "reference_rate": 1.0, "least_rate": 1e-4},
            "carreau_yasuda": CARREAU,
            "herschel_bulkley": PLASTIC,
        },
    ),
    "polymers": (
        NORMAL,
        {
            "oldroyd_b": POLYMER,
            "giesekus": {**GIESEKUS, "mobility": 0.2},
            "phan_thien_tanner": {**POLYMER, "type": "phan_thien_tanner", "extensibility": 0.1, "form": "linear"},
            "fene_p": {**POLYMER, "type": "fene_p", "maximum_extension": 50.0},
        },
    ),
}


def keys_of(names):
    """Free keys by their short names."""
    return [fit.Key(RHEOLOGY + name if name else VISCOSITY, *BOUNDS[name]) for name in names]


def predictor_of(folder, config, fluid, places):
    """A predictor for measurements at the places, which are all 1 so far."""
    path = Path(folder) / "case.yaml"
    path.write_text(json.dumps({**config, "name": "case", "fluid": {**FLUID, "rheology": fluid}}))
    kind, at, names = places
    rows = len(next(iter(at.values())))
    return Predictor(str(path), [], Measurements(kind, at, {name: np.ones(rows) for name in names}), Path(folder), 1)


def noisy(data, predicted, size, random):
    """The measurements with the predicted values and noise."""
    measured = {name: predicted[name] for name in data.measured}
    exact = replace(data, measured=measured)
    found = {}
    for (name, values), scale in zip(measured.items(), exact.scales, strict=True):
        noise = size * random.standard_normal(len(values))
        found[name] = values * np.exp(noise) if data.kind in RELATIVE else values + scale * noise
    return replace(exact, measured=found)


def coverage(name, sets, first):
    """Print coverage, bias, time and predictions of one case."""
    config, fluid, places, names = CASES[name]
    keys = keys_of(names)
    with tempfile.TemporaryDirectory() as folder:
        predictor = predictor_of(folder, config, fluid, places)
        true = {key.name: fit.value_at(predictor.config, key.name) for key in keys}
        z = np.array([key.place(true[key.name]) for key in keys])
        # the config has other values than the data, which would otherwise be the first start
        [predicted] = predictor([true])
        other = {key.name: key.value(0.5 * one + 0.3) for key, one in zip(keys, z, strict=True)}
        changed = override_texts({key: value for key, value in other.items() if ".fraction" not in key})
        predictor = Predictor(predictor.path, changed, predictor.measurements, predictor.folder, 1)
        clean = predictor.measurements
        predictor.measurements = noisy(clean, predicted, 0.0, np.random.default_rng(0))
        exact = fit.Problem(name, predictor, keys, fit.noise_of(predictor.measurements, None)).solve()
        off = max(abs(exact.values[key.name] / true[key.name] - 1.0) for key in keys)
        random, errors, times, predictions, doubtful, inside = np.random.default_rng(first), [], [], [], [], []
        for _ in range(sets):
            predictor.measurements = noisy(clean, predicted, NOISE, random)
            began, known = time.process_time(), len(predictor.known)
            found = fit.Problem(name, predictor, keys, fit.noise_of(predictor.measurements, None)).solve()
            times.append(time.process_time() - began)
            predictions.append(len(predictor.known) - known)
            error = np.sqrt(np.diag(found.covariance))
            errors.append((found.z - z) / error)
            inside.append(np.abs(found.z - z) < found.t * error)
            doubtful.append(found.complaints)
    for key, right, shift in zip(keys, np.sum(inside, axis=0), np.mean(errors, axis=0), strict=True):
        print(f"{name}: {key.name}: {right} of {sets} intervals right, mean error {shift:+.2f} standard errors")
    print(
        f"{name}: median {statistics.median(times):.2f} s of processor time, {statistics.median(predictions):g} new "
        f"predictions; {sum(map(bool, doubtful))} of {sets} doubtful; data without noise: {off:.1e}"
    )
    for text, count in sorted({str(each): doubtful.count(each) for each in doubtful if each}.items()):
        print(f"  {count} times {text}")


def choice(name, sets, first):
    """Print how often the right one of four laws is chosen."""
    places, laws = LAWS[name]
    known = {law: [part for part in fluid if part in BOUNDS] for law, fluid in laws.items()}
    random, right, total = np.random.default_rng(first), 0, 0
    with tempfile.TemporaryDirectory() as folder:
        predictors = {}
        for law, fluid in laws.items():
            (Path(folder) / law).mkdir()
            predictors[law] = predictor_of(Path(folder) / law, COUETTE, fluid, places)
        for truth, fluid in laws.items():
            values = {VISCOSITY: 1.0, **{RHEOLOGY + part: fluid[part] for part in known[truth]}}
            [predicted] = predictors[truth]([values])
            wrong = []
            for _ in range(sets):
                data = noisy(predictors[truth].measurements, predicted, NOISE, random)
                fits = []
                for law, predictor in predictors.items():
                    predictor.measurements = data
                    keys = keys_of(["", *known[law]])
                    fits.append(fit.Problem(law, predictor, keys, fit.noise_of(data, None)).solve())
                chosen = fit.best(fits)
                right, total = right + (chosen.law == truth), total + 1
                wrong += [chosen.law] if chosen.law != truth else []
            print(f"{name}: {truth}: {sets - len(wrong)} of {sets} right{'; else ' if wrong else ''}{', '.join(wrong)}")
    print(f"{name}: {right} of {total} right")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("cases", nargs="+", choices=[*CASES, *LAWS])
    parser.add_argument("--sets", type=int, default=20, help="number of data sets, of each law for laws")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    for one in asked.cases:
        (choice if one in LAWS else coverage)(one, asked.sets, asked.seed)
