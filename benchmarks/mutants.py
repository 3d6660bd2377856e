"""Change the program in small ways, one at a time, and count the changes that the tests notice.

    python benchmarks/mutants.py exact measures --count 60 --out mutants
    python benchmarks/mutants.py --count 200 --out mutants     # all folders of FOLDERS; goes on where it was stopped

Each change is applied to a copy of the repository, on which the tests of TESTS run until one fails. What survives is
printed with the line as it was and as it is; results.jsonl in the folder of --out keeps every outcome.

mutmut leaves out functions with a decorator, which is every kernel; cosmic-ray changes numbers by whole units alone,
and most of what it draws are operators that no program survives. What is asked here is whether a few per cent are seen.
"""

import argparse
import ast
import concurrent.futures
import json
import os
import queue
import random
import resource
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ["exact", "measures", "numerics", "rheology", "schemes"]

MEMORY = 6 << 30
"""Bytes a test run may use; the tests need a sixth of it."""

NOT_COPIED = (".git", ".venv", "media", "__pycache__", "runs", "mutants")

EXPLICIT = ["numerics/test_operators", "walls/test_*", "schemes/test_wcsph_stress", "schemes/test_units"]
IMPLICIT = ["schemes/test_channel" + name for name in ("_modes", "_accuracy", "")]
IMPLICIT += ["schemes/test_shifting"]
TWO_DIMENSIONAL = ["two_dimensional", "curved_walls", "bodies_in_flow", "corner_singularities"]
TWO_DIMENSIONAL = ["schemes/test_" + name for name in (*TWO_DIMENSIONAL, "channel_polymer", "viscoelastic_stress")]
POLYMER = ["schemes/test_channel_polymer", "schemes/test_viscoelastic_stress*"]
LAYERS = "schemes/test_estimate_layers"
CHOICE = ["schemes/test_auto", "schemes/test_protocol", "schemes/test_step_control"]
WALLS = ["walls/test_wall_treatments"]
TESTS = {
    "exact": ["exact/test_*", "scenes/test_channel"],
    "exact/couette": ["exact/test_couette", "scenes/test_channel"],
    "exact/_c": ["exact/test_c*", "exact/test_*", "scenes/test_channel"],
    "exact/linear": ["measures/test_rheometry*", "exact/test_*", "scenes/test_channel"],
    "exact/sliding": ["exact/test_sliding_corner", "exact/test_cavity"],
    "exact/uniform_shear": ["measures/test_rheometry"],
    "measures": ["measures/test_*", "studies/test_checks", "studies/test_walls*", "studies/test_extrapolation"],
    "measures/fits": [
        "measures/test_fits",
        "report/test_*",
        "schemes/test_bodies_in_flow",
        "schemes/test_curved_walls",
    ],
    "measures/resolution": [
        "measures/test_resolution",
        "scenes/test_cell",
        "schemes/test_corner_singularities",
        "simulation/test_run",
    ],
    "studies/": ["studies/test_*"],
    "rheometry/viscometers": [
        "measures/test_rheometry*",
        "measures/test_viscometers",
        "schemes/test_scheduled_cylinders",
    ],
    "rheometry/rheometers": ["measures/test_rheometry*", "schemes/test_scheduled_*"],
    "measures/channel": ["measures/test_metrics", "measures/test_channel"],
    "numerics": [
        "numerics/test_least_squares",
        "numerics/test_two_level",
        "numerics/test_viscous_solver",
        *IMPLICIT,
    ],
    "numerics/least_squares": ["numerics/test_least_squares", "schemes/test_curved_walls", *IMPLICIT],
    "numerics/auxiliary_grid": ["numerics/test_two_level", "numerics/test_viscous_solver"],
    "numerics/bicgstab": ["numerics/test_two_level", "numerics/test_viscous_solver", "schemes/test_two_dimensional"],
    "schemes": [*CHOICE, *EXPLICIT],
    "schemes/_local_newton": ["schemes/test_log_conformation", LAYERS, *POLYMER, "rheology/test_laws_in_kernels"],
    "schemes/_momentum": [
        "walls/test_impulse",
        "schemes/test_channel",
        "walls/test_wall_treatments",
        "schemes/test_wcsph",
    ],
    "schemes/auto": [*CHOICE, "config/test_*"],
    "schemes/wcsph/_time_step": ["schemes/test_shifting", "cli/test_check", *EXPLICIT],
    "schemes/wcsph/_bodies": ["schemes/test_wcsph_loads", "schemes/test_wcsph"],
    "numerics/shifting": ["schemes/test_two_dimensional", *IMPLICIT],
    "schemes/wcsph": [*CHOICE, "schemes/test_wcsph_*", *EXPLICIT],
    "schemes/_estimate": [
        "schemes/test_estimate",
        LAYERS,
        "cli/test_check",
        "studies/test_stability",
    ],
    "schemes/implicit/planar/viscoelastic_stress": ["schemes/test_log_conformation", *POLYMER],
    "schemes/implicit/planar/open_ends": [
        "schemes/test_parts_of_open_ends",
        "schemes/test_open_ends",
        "scenes/test_outline",
    ],
    "schemes/implicit/planar/flow_rate": ["schemes/test_parts_of_open_ends", "schemes/test_open_ends"],
    "schemes/implicit/planar/free_bodies": [
        "schemes/test_parts_of_free_bodies",
        "observers/test_free_bodies",
        "scenes/test_suspension_stress",
        "schemes/test_slow_flow",
        "schemes/test_free_bodies",
    ],
    "schemes/implicit/planar/mean_velocity": [
        "schemes/test_parts_of_tubes",
        "schemes/test_slow_flow",
        "schemes/test_axisymmetric",
    ],
    "schemes/implicit/planar/time_levels": [
        "schemes/test_two_dimensional_parts",
        "schemes/test_coordinates",
        "schemes/test_log_conformation",
        "schemes/test_two_dimensional",
        "schemes/test_axisymmetric",
    ],
    "schemes/implicit/planar/wall_": [
        "schemes/test_two_dimensional_parts",
        "schemes/test_coordinates",
        "schemes/test_parts_of_tubes",
        "schemes/test_curved_walls",
        "schemes/test_slow_flow",
        "schemes/test_axisymmetric",
    ],
    "numerics/stokes": ["schemes/test_parts_of_tubes", "schemes/test_slow_flow", "schemes/test_open_ends"],
    "scenes/_stream": [
        "scenes/test_inlet_profiles",
        "scenes/test_outline",
        "observers/test_open_ends",
        "config/test_ends",
        "schemes/test_open_ends",
    ],
    "scenes/_cell": [
        "scenes/test_cell",
        "observers/test_free_bodies",
        "bodies/test_bodies",
        "scenes/test_suspension_stress",
    ],
    "schemes/implicit/planar": [
        "schemes/test_two_dimensional_parts",
        "schemes/test_log_conformation",
        "house/test_layers",
        *TWO_DIMENSIONAL,
    ],
    "schemes/_step_control": [
        "schemes/test_step_control",
        "schemes/test_two_dimensional_parts",
        *IMPLICIT,
    ],
    "schemes/implicit/channel": [
        "schemes/test_channel_stages",
        LAYERS,
        "schemes/test_scheduled_walls",
        *IMPLICIT,
    ],
    "schemes/implicit/channel/wall_pair": ["walls/test_impulse", LAYERS, *POLYMER, *IMPLICIT],
    "schemes/implicit/channel/models": [*POLYMER, "schemes/test_wcsph_stress", "rheology/test_laws_in_kernels"],
    "schemes/implicit/channel/walls": [
        "schemes/test_channel_stages",
        *POLYMER,
        "schemes/test_scheduled_walls",
        *IMPLICIT,
    ],
    "schemes/implicit/channel/stress_controlled": ["schemes/test_scheduled_walls"],
    "schemes/implicit/channel/ghosts": ["numerics/test_viscous_solver", "walls/test_wall_treatments", *IMPLICIT],
    "schemes/implicit/channel/step": [
        "numerics/test_point_cloud",
        "schemes/test_channel_stages",
        *IMPLICIT,
    ],
    "schemes/implicit": ["config/test_*", *CHOICE, "schemes/test_channel"],
    "rheology": [
        "rheology/test_laws",
        "config/test_flows",
        "rheology/test_laws_in_kernels",
        "schemes/test_wcsph_stress",
    ],
    "schemes/wcsph/operators": EXPLICIT,
    "schemes/wcsph/walls": [
        *WALLS,
        "walls/test_impulse",
        "schemes/test_wcsph_stress",
        "schemes/test_channel",
    ],
    "schemes/wcsph/walls/_circles": ["schemes/test_wcsph", "walls/test_wall_treatments"],
    "schemes/wcsph/walls/_dummies": ["schemes/test_wcsph", "walls/test_wall_treatments"],
    "schemes/wcsph/walls/_consistent": [
        "walls/test_wall_treatments",
        "schemes/test_wcsph_stress",
        "schemes/test_channel",
        "schemes/test_channel_accuracy",
    ],
}
"""Tests of a folder or file of the package, the quickest first; the longest name that fits counts."""

SWAPS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Pow: "*", ast.FloorDiv: "*", ast.Mod: "*"}
SWAPS |= {ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "=="}
SWAPS |= {ast.And: "or", ast.Or: "and"}


def tests_of(path):
    """Test files for a file of the package, without repetitions."""
    name = path.relative_to(ROOT / "tisph").as_posix()
    best = max((key for key in TESTS if name.startswith(key)), key=len)
    found = [file for pattern in TESTS[best] for file in sorted(ROOT.glob(f"tests/{pattern}.py"))]
    return [str(file.relative_to(ROOT)) for file in dict.fromkeys(found)]


def replacements(node):
    """Yield (place before, place after, text) for what may stand between two places instead of what does."""
    if not hasattr(node, "lineno"):
        return
    begin, end = (node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)
    if isinstance(node, ast.Expr) and "loop_config" in ast.unparse(node):  # changes the speed alone
        return
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield begin, end, repr(node.value + 1 if type(node.value) is int else node.value * 1.05 or 0.05)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield begin, (node.operand.lineno, node.operand.col_offset), ""
    elif isinstance(node, ast.AugAssign) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
        yield begin, end, "pass"
    between = {
        ast.BinOp: lambda: [(node.left, node.op, node.right)],
        ast.Compare: lambda: zip([node.left, *node.comparators], node.ops, node.comparators, strict=False),
        ast.BoolOp: lambda: [(node.values[0], node.op, node.values[1])],
    }
    for left, operator, right in between.get(type(node), list)():
        if type(operator) in SWAPS:
            yield (left.end_lineno, left.end_col_offset), (right.lineno, right.col_offset), SWAPS[type(operator)]


def candidates(path):
    """All changes of a file, as (path, place before, place after, text)."""
    skipped = set()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        texts = getattr(node, "decorator_list", []) if not isinstance(node, ast.JoinedStr | ast.Raise) else [node]
        skipped |= {inner for text in texts for inner in ast.walk(text)}
    return [(path, *found) for node in ast.walk(tree) if node not in skipped for found in replacements(node)]


def mutated(source, begin, end, text):
    """The source with another text between two places; parentheses around an operator stay."""
    lines = source.encode().splitlines(keepends=True)
    first, last = (sum(map(len, lines[: line - 1])) + column for line, column in (begin, end))
    source = source.encode()
    if text in ("", *SWAPS.values()):
        operator = source[first:last].strip(b"() \n")
        first += source[first:last].index(operator)
        last = first + len(operator)
    return (source[:first] + text.encode() + source[last:]).decode()


def outcome_of(tree, tests, seconds):
    """Run files of tests in a copy until one fails, each for so much processor time and MEMORY.

    Returns "survives", "noticed" or "timeout", and what failed. Files are run one by one, since pytest would put those
    that run kernels first. All copies have one home, so one cache of compiled kernels.
    """
    home = {"HOME": str(tree.parents[1] / "home"), "PYTHONDONTWRITEBYTECODE": ""}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    environment = {**os.environ, "PYTHONPATH": str(tree), **home}

    def limits():
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))

    run = {"cwd": tree, "env": environment, "capture_output": True, "preexec_fn": limits, "text": True}
    for file in tests:
        ended = subprocess.run([*command, file], **run)
        last = next((line for line in ended.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))), "")
        if ended.returncode:
            return ("timeout" if ended.returncode < 0 else "noticed"), last
    return "survives", ""


def judge(mutant, trees, seconds):
    """Apply a change to a free copy, run the tests, and take it back."""
    path, begin, end, text = mutant
    tree = trees.get()
    copy = tree / path.relative_to(ROOT)
    source = copy.read_text(encoding="utf-8")  # whatever has become of the original since
    changed = mutated(source, begin, end, text)
    try:
        copy.write_text(changed, encoding="utf-8")
        outcome, by = outcome_of(tree, tests_of(path), seconds)
    finally:
        copy.write_text(source, encoding="utf-8")
        trees.put(tree)
    was, now = (content.splitlines()[begin[0] - 1].strip() for content in (source, changed))
    return {"key": key(mutant), "outcome": outcome, "by": by, "was": was, "now": now}


def key(mutant):
    """What tells a change from all others, for results.jsonl."""
    path, begin, end, text = mutant
    return [f"{path.relative_to(ROOT)}:{begin[0]}", begin[1], *end, text]


def copies(folder, number):
    """A queue of copies of the repository."""
    trees = queue.Queue()
    for tree in (folder.resolve() / f"copy{count}" / "tisph" for count in range(number)):
        shutil.rmtree(tree, ignore_errors=True)
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*NOT_COPIED))
        trees.put(tree)
    return trees


def main():
    """Draw the changes, run what has no outcome yet, print what survives."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", default=FOLDERS, help="below tisph/ (default: %(default)s)")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument(
        "--seconds", type=int, default=300, help="of processor time for a file of tests; what takes longer is a timeout"
    )
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    roots = [ROOT / "tisph" / part for part in options.parts]
    files = [file for root in roots for file in ([root] if root.is_file() else sorted(root.rglob("*.py")))]
    found = [candidate for file in files for candidate in candidates(file)]
    drawn = random.Random(options.seed).sample(found, min(options.count, len(found)))
    trees, log = copies(options.out, options.processes), options.out / "results.jsonl"
    known = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    known = {json.dumps(outcome["key"]): outcome for outcome in known}
    with concurrent.futures.ThreadPoolExecutor(options.processes) as pool, log.open("a") as file:
        new = [mutant for mutant in drawn if json.dumps(key(mutant)) not in known]
        running = [pool.submit(judge, mutant, trees, options.seconds) for mutant in new]
        for outcome in (done.result() for done in concurrent.futures.as_completed(running)):
            known[json.dumps(outcome["key"])] = outcome
            print(json.dumps(outcome), file=file, flush=True)
            print(outcome["outcome"], outcome["key"][0], outcome["now"], flush=True)
    left = [outcome for mutant in drawn if (outcome := known[json.dumps(key(mutant))])["outcome"] != "noticed"]
    print(f"seed {options.seed}: {len(found)} changes, {len(drawn)} drawn, {len(left)} not noticed")
    for outcome in left:
        print(f"{outcome['outcome']} {outcome['key'][0]}\n  - {outcome['was']}\n  + {outcome['now']}")


if __name__ == "__main__":
    main()
