"""Errors of the layer at a wall by its depth in particle spacings: what ``measures/resolution.py`` rests on.

    python benchmarks/resolution.py

prints a table, part of which is in docs/reference/files.md: L2 error of the velocities, and error of the wall shear
over its exact value (at an oscillating wall over its amplitude), in one run a line; a minute or two on two threads. An
infinite plate that starts or oscillates has no other length than the depth of its layer, so that nothing else matters
but the wall treatment, which obeys the momentum equation here.
"""

import json
import math
import tempfile
from pathlib import Path

from tisph import simulation
from tisph.config import load, yaml_text
from tisph.studies.expressions import merged

DEPTHS = (0.5, 1.0, 2.0, 3.0, 4.0)
ROWS = 40
START = {
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 0.4},
    "walls": {"treatment": {"type": "consistent_image"}, "bottom": {"velocity": 0.0}, "top": {"velocity": 0.5}},
    "discretisation": {"particles_across": ROWS},
    "scheme": {"type": "wcsph"},
    "output": {"video": None},
}
POLYMER = merged(
    START,
    {
        "fluid": {
            "kinematic_viscosity": 1.0,
            "rheology": {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.1},
        }
    },
)
SCHEMES = {
    "wcsph": {},
    **{f"implicit, order {n}": {"scheme": {"type": "implicit", "operators": {"order": n}}} for n in (2, 4)},
}


def errors(config, times, amplitude=None):
    """Run to the last of ``times``; return (L2 error, error of the wall shear) of every sample."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.yaml"
        text = yaml_text.dump({**config, "name": "case", "time": {"end": times[-1], "samples": list(times)}})
        path.write_text(text, encoding="utf-8")
        run = simulation.run(load(path), Path(folder) / "run", video=False)
        samples = json.loads((run / "summary.json").read_text(encoding="utf-8"))["samples"]
    shears = [(sample["wall_shear_top"], sample["wall_shear_top_exact"]) for sample in samples]
    shear_errors = [abs(found - exact) / (amplitude or abs(exact)) for found, exact in shears]
    return list(zip([sample["l2"] for sample in samples], shear_errors, strict=True))


def started(config, viscosity):
    """Errors of a wall that starts, by depth sqrt(viscosity t)."""
    return errors(config, [(depth / ROWS) ** 2 / viscosity for depth in DEPTHS])


def oscillating(config, depth):
    """The largest errors in a period of an oscillating wall with half its penetration depth ``depth``."""
    nu, speed = config["fluid"]["kinematic_viscosity"], 0.5
    frequency = nu / (2.0 * (depth / ROWS) ** 2)
    top = {"walls": {"top": {"amplitude": speed, "angular_frequency": frequency}}}
    plain = {key: value for key, value in config.items() if key != "walls"}
    moving = merged(
        plain, {"walls": {"treatment": config["walls"]["treatment"]}}, top, {"initial": {"state": "developed"}}
    )
    found = errors(moving, [k / frequency for k in (4, 5, 6, 7, 8)], speed * math.sqrt(nu * frequency))
    return tuple(max(column) for column in zip(*found, strict=True))


def main():
    """Print the table."""
    print("| depth in spacings | " + " | ".join(f"{depth:g}" for depth in DEPTHS) + " |")
    print("|---" * (len(DEPTHS) + 1) + "|")
    for name, scheme in SCHEMES.items():
        config = merged(START, scheme)
        show(f"wall that starts, {name}", started(config, 0.01))
        show(f"wall that oscillates, {name}", [oscillating(config, depth) for depth in DEPTHS])
    show("wall that starts, Oldroyd-B, wcsph", started(POLYMER, 0.1))


def show(name, found):
    """Print a line: L2 error and error of the wall shear in per cent at each depth."""
    print(f"| {name} | " + " | ".join(f"{100 * l2:.2g}, {100 * shear:.2g}" for l2, shear in found) + " |", flush=True)


if __name__ == "__main__":
    main()
