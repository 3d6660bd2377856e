"""Cost of a particle and step, of each scheme and size, or of each part of the program.

    python benchmarks/step.py --output new.json
    python benchmarks/step.py --parts --output parts.json
    python -m pyperf compare_to old.json new.json --table

Every number is seconds per fluid particle and step: of the processor on one thread, so that what else the machine does
hardly counts, and of the clock on two. Every case runs in processes of its own. To interleave cases, repeat the command
with ``--processes 1 --append FILE`` in place of ``--output FILE``.
"""

import json
import tempfile
import time
from functools import cache
from pathlib import Path

import pyperf

from tisph import runtime, scenes, schemes
from tisph.config import load
from tisph.simulation.state import start_values
from tisph.studies.expressions import merged

COUETTE = {
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 2.0},
    "walls": {"bottom": {"velocity": 0.0}, "top": {"velocity": 0.5}},
    "initial": {"jitter": 0.1},
    # 20 neighbours within the kernel, in the bulk of a lattice: pi 2.6^2 less the particle itself
    "discretisation": {"kernel": "wendland_c2", "smoothing_ratio": 1.3},
    "output": {"video": None},
}
"""Couette flow at Re = 50 on particles that are not quite on a lattice."""

EXPLICIT = {
    "initial": {"state": "developed"},
    "scheme": {"type": "wcsph", "equation_of_state": {"sound_speed": 5.0}},
    "time": {"end": 1000.0},
}
"""Steady flow, so that every step and every time between two rebuilds is like the next."""

IMPLICIT = {
    "initial": {"state": "exact", "time": 1.0},
    "scheme": {"type": "implicit"},
    "time": {"end": 1000.0, "cfl": 1.0},
}
"""Start-up flow once its layers are resolved, in steps of one length."""

SCHEMES = {
    "consistent": EXPLICIT,
    "standard": merged(EXPLICIT, {"scheme": {"operators": "standard"}}),
    "implicit": IMPLICIT,
}
"""Changes of the config by name: the explicit scheme goes by that of its operators."""

OSCILLATING = {"walls": {"top": {"velocity": None, "amplitude": 0.5, "angular_frequency": 0.5}}}
DRIVEN = {"drive": {"acceleration": 1e-3}}
FROM_REST = {"initial": {"state": "rest"}, "time": {"end": 100.0}}
POLYMER = {
    "fluid": {
        "kinematic_viscosity": 0.01,
        "rheology": {"type": "oldroyd_b", "relaxation_time": 1.0, "solvent_fraction": 0.5},
    }
}
# steps of spacing / wall velocity / 2, all alike: those that follow the flow differ from case to case
EVEN_STEPS = {"scheme": {"type": "implicit"}, "time": {"cfl": 0.5, "tolerance": 3e-5}}
PARTS = {
    scheme: {name: merged(base, FROM_REST, part) for name, part in {"nothing": {}, **parts}.items()}
    for scheme, base, parts in (
        (
            "explicit",
            EXPLICIT,
            {
                "polymer stress": POLYMER,
                "pressure cutoff": {"scheme": {"equation_of_state": {"pressure_cutoff": -1.0}}},
                "artificial viscosity": {"scheme": {"artificial_viscosity": 0.1}},
                "body acceleration": DRIVEN,
                "oscillating wall": OSCILLATING,
            },
        ),
        (
            "implicit",
            EVEN_STEPS,
            {
                "body acceleration": DRIVEN,
                "oscillating wall": OSCILLATING,
                "jitter": {"initial": {"jitter": 0.2, "seed": 0}},
            },
        ),
    )
}
"""Cases with one part each, beside the same without it."""

WARM_UP = {"wcsph": 64, "implicit": 3}
"""Steps before the first that is timed: they compile, and the momentum balance is computed less often afterwards."""


def cases(parts, across):
    """Yield (name, config) of the cases."""
    if parts:
        for scheme, changes in PARTS.items():
            for name, change in changes.items():
                yield f"{scheme}, {name}", sized(change, 50, 1)
        return
    for number in across:
        for threads in (1, 2):
            for precision in ("f64", "f32"):
                for scheme, change in SCHEMES.items():
                    config = merged(sized(change, number, threads), {"discretisation": {"precision": precision}})
                    yield f"{scheme}, {2 * number**2} particles, {precision}, {threads} threads", config


def sized(change, across, threads):
    """The config with a number of particles across the channel and of threads."""
    return merged(COUETTE, change, {"discretisation": {"particles_across": across}, "runtime": {"threads": threads}})


@cache
def started(text):
    """Return the scheme of a config, as text, once it has taken its first steps: one in a process."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.yaml"
        path.write_text(text, encoding="utf-8")
        config = load(path, ())
    scene = scenes.of(config)
    threads = config.runtime.threads
    runtime.start(config.discretisation.precision, threads)
    chosen, _ = schemes.resolve(config)
    scheme = schemes.build(chosen, scene, [config.time.end], threads == 1)
    scheme.start(*start_values(scene, config.initial))
    while scheme.steps < WARM_UP[chosen.scheme.type]:
        scheme.advance()
    return scheme


def seconds_of_steps(times, config):
    """Return the seconds that so many steps take, of the processor on one thread."""
    scheme = started(json.dumps(config))  # JSON is YAML
    clock = time.process_time if config["runtime"]["threads"] == 1 else time.perf_counter
    last = scheme.steps + times
    began = clock()
    while scheme.steps < last:
        scheme.advance()
    return clock() - began


def main():
    """Measure all cases."""
    runner = pyperf.Runner(values=3, processes=5, min_time=0.5, add_cmdline_args=pass_on)
    runner.argparser.add_argument("--parts", action="store_true", help="what each part of the program adds")
    runner.argparser.add_argument("--across", type=int, nargs="+", default=[50, 224], help="particles across")
    options = runner.parse_args()
    for name, config in cases(options.parts, options.across):
        each = config["discretisation"]["particles_across"] ** 2 * 2
        runner.bench_time_func(name, seconds_of_steps, config, inner_loops=each)


def pass_on(command, options):
    """Give a worker process the options of this script."""
    command += ["--parts"] if options.parts else ["--across", *map(str, options.across)]


if __name__ == "__main__":
    main()
