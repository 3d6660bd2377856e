"""How good the estimates of ``tisph run --estimate-error`` are: beside exact errors, and beside a much finer run."""

import numpy as np

from tisph import scenes
from tisph.config.schema import Config
from tisph.folder import Folder
from tisph.measures.fits import interpolated
from tisph.observers.samples import read_samples
from tisph.studies.checks import Check
from tisph.studies.error_estimate import Coarser
from tisph.studies.processes import read_result, run_config
from tisph.studies.store import config_text

BOUND = 3.0
"""Factor between the estimated and the true error."""

FINER = 2
"""Times as many particles across in the run that stands for the truth where there is no exact one."""

CASES = {
    "taylor_green_estimate": {
        "scene": "taylor_green",
        "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
        "geometry": {"length": 1.0},
        "initial": {"velocity": 1.0, "jitter": 0.2},
        "discretisation": {"particles_across": 50},
        "time": {"end": 2.0, "samples": [0.5, 1.0, 2.0]},
    },
    "shear_layer_estimate": {
        "scene": "shear_layer",
        "fluid": {"density": 1.0, "kinematic_viscosity": 2e-3},
        "geometry": {"length": 1.0},
        "initial": {"velocity": 1.0, "thickness": 1 / 30, "jitter": 0.1},
        "discretisation": {"particles_across": 64},
        "time": {"end": 1.6, "samples": [0.4, 0.8, 1.2, 1.6]},
    },
}


def checks(folder):
    """Run the cases in ``folder`` and yield a ``Check`` of each field at each sample: estimated error over true one."""
    for name, data in CASES.items():
        root, config = folder / name, Config.model_validate({"name": name, **data})
        estimate, result = _estimated(config, data, root)
        true = _true_errors(config, data, root, result)
        for sample, errors in zip(estimate.get("samples", []), true, strict=False):
            for field, error in errors.items():
                found = sample["fields"][field]["error"]
                factor = np.nan if found is None else found / error
                passed = bool(1 / BOUND <= factor <= BOUND)
                quantity = f"stated error of {field} over {error:.1e} at t = {sample['t']:g}"
                yield Check(name, quantity, factor, f"1/{BOUND:g} to {BOUND:g}", passed)


def _estimated(config, data, root):
    """Estimates of a run, as in its summary, and its ``Result``."""
    result = _run(data, root)
    coarser = Coarser(config, root)
    coarser.run()
    coarser.report()
    return read_result(root).summary["error_estimate"], result


def _run(data, root):
    path = root.with_suffix(".yaml")
    path.write_text(config_text(root.name, data), encoding="utf-8")
    return run_config(path, root)[0]


def _true_errors(config, data, root, result):
    """Relative L2 errors of velocity and pressure of each sample over the particles: a list of dicts."""
    scene = scenes.of(config)
    if scene.fields:
        return [{"velocity": each["l2"], "pressure": each["l2_pressure"]} for each in result.summary["samples"]]
    across = {"particles_across": FINER * config.particles_across}
    finer = {**data, "discretisation": across}
    truth = _run(finer, root.with_name(f"{root.name}_finer"))
    finer = scenes.of(Config.model_validate({"name": config.name, **finer}))
    pairs = zip(*(read_samples(Folder(each.folder).samples) for each in (result, truth)), strict=True)
    return [_differences(*pair, finer) for pair in pairs]


def _differences(snapshot, truth, scene):
    """Relative L2 differences of velocity and pressure from ``truth``, a snapshot of ``scene``."""
    positions = [np.stack([each.x, each.y], axis=1) for each in (snapshot, truth)]
    ours, theirs = (np.stack([each.u, each.v, each.pressure], axis=1) for each in (snapshot, truth))
    theirs = interpolated(scene, positions[1], theirs, positions[0])
    ours[:, 2] -= ours[:, 2].mean()
    theirs[:, 2] -= theirs[:, 2].mean()
    parts = {"velocity": [0, 1], "pressure": [2]}
    return {
        name: float(np.linalg.norm((ours - theirs)[:, part]) / np.linalg.norm(theirs[:, part]))
        for name, part in parts.items()
    }
