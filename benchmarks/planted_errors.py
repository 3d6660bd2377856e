"""Change one term of the equations by a few per cent, and see which rows of ``tisph verify manufactured`` fail.

What no manufactured flow has, open ends and bodies that the flow carries, has tests instead of rows.

    python benchmarks/planted_errors.py                 # all terms, some minutes
    python benchmarks/planted_errors.py hoop body       # those whose name contains one of the words

Each error is planted in a copy of the package, in which the two coarser runs of one case are made and judged as with
``--quick``, or one test is run. A term whose error nothing notices makes the exit status 1.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
SCHEME, WALLS = "implicit/planar/scheme.py", "implicit/planar/wall_boundary.py"
LOG = "implicit/planar/log_conformation"
STEP, COORDINATES = "implicit/planar/equations.py", "implicit/planar/time_levels.py"
POLYMER = "implicit/planar/viscoelastic_stress.py"
ENDS, BODIES, LIMITS = (f"implicit/planar/{name}.py" for name in ("open_ends", "free_bodies", "step_limits"))
ROWS, PASSING = "test_open_ends::test_the_outlets_rows", "test_open_ends::test_particles_pass_evenly"
HEAT = "implicit/planar/transport.py"
BALL, SOLVED = "test_slow_flow::test_without_inertia_the_force", "test_scatter_of_steps::test_errors_of_a_solution"

ERRORS = {
    "none": ("pipe", STEP, "", ""),
    "convection along paths": ("square", COORDINATES, "+= self.step_w", "+= 0.95 * self.step_w"),
    "pressure gradient": ("channel", STEP, "x -= dt * gradient", "x -= 0.95 * dt * gradient"),
    "viscosity": ("square", SCHEME, "viscosity = self.prob", "viscosity = 0.95 * self.prob"),
    "hoop term of the divergence": ("pipe", COORDINATES, "return 2.0 * value", "return 1.9 * value"),
    "hoop terms of viscosity": ("pipe", "../numerics/least_squares.py", "2.0 * self.app", "1.9 * self.app"),
    "radius along paths": ("pipe", COORDINATES, "velocity.y * ratio", "velocity.y * (0.95 + 0.05 * ratio)"),
    "circulation along paths": ("taylor_couette", COORDINATES, "ratio * ratio", "ratio ** 1.9"),
    "centripetal term": ("taylor_couette", COORDINATES, "velocity[i].z ** 2", "0.95 * velocity[i].z ** 2"),
    "body force along x": ("pipe", SCHEME, "dt * force\n", "dt * force * [0.95, 1.0, 1.0]\n"),
    "body force along r": ("pipe", SCHEME, "dt * force\n", "dt * force * [1.0, 0.95, 1.0]\n"),
    "body force around the axis": ("pipe", SCHEME, "dt * force\n", "dt * force * [1.0, 1.0, 0.95]\n"),
    "body force along y": ("annulus", SCHEME, "dt * force\n", "dt * force * [1.0, 0.95]\n"),
    "Neumann rows, viscous part": ("channel", WALLS, "along - viscosity", "along - 0.95 * viscosity"),
    "Neumann rows, acceleration": ("channel", WALLS, "(along -", "(0.95 * along -"),
    "stress divergence": ("square_oldroyd_b", POLYMER, "by_x[0] + by_y[1]", "by_x[0] + 0.95 * by_y[1]"),
    "hoop stress": ("pipe_oldroyd_b", POLYMER, "stress[2] - stress[3]", "stress[2] - 0.95 * stress[3]"),
    "stress around the axis": ("pipe_oldroyd_b", POLYMER, "2.0 * stress[RT]", "1.9 * stress[RT]"),
    "upper-convected, extension": ("square_oldroyd_b", LOG + ".py", "scaled * stretch", "scaled * 0.95 * stretch"),
    "upper-convected, shear": ("annulus_oldroyd_b", LOG + ".py", "2.0 * scaled * strain", "1.9 * scaled * strain"),
    "upper-convected, with swirl": ("pipe_oldroyd_b", LOG + "_with_swirl.py", "* scaled -", "* 0.95 * scaled -"),
    "power law": ("square_power_law", "../rheology/power_law.py", "0.5 * (par", "0.48 * (par"),
    "conduction of heat": ("heated_pipe", HEAT, "dt * each.diff", "dt * 0.95 * each.diff"),
    "viscous heating": ("heated_pipe", HEAT, "each.heating * power", "0.95 * each.heating * power"),
    "source of heat": ("heated_box", HEAT, "(each.source(", "(0.95 * each.source("),
    "heat through a wall": ("heated_box", HEAT, "-condition.flux", "-0.95 * condition.flux"),
    "buoyancy": ("heated_box", HEAT, "values - each.ref", "0.95 * values - each.ref"),
    "viscosity at a temperature": ("heated_pipe", HEAT, "result * each.factor(values)", "each.factor(0.95 * values)"),
    "slope at an outlet": (ROWS, ENDS, "outlet_slope = support", "outlet_slope = 0.95 * support"),
    "particles that are due": (PASSING, ENDS, "self.due + gained", "self.due + 1.03 * gained"),
    "fluid that bodies displace": (BALL, BODIES, "inertia.displaced * acc", "inertia.displaced * 0.98 * acc"),
    "residual in slow flow": (SOLVED, LIMITS, "TOGETHER = 0.03", "TOGETHER = 0.1"),
}  # fmt: skip
"""By the name of a term: the case that is run, or file and beginning of a test below tests/schemes, then a file (below
tisph/schemes), a text in it and its replacement."""

JUDGE = """
import sys
from pathlib import Path
from tisph.studies import manufactured
from tisph.studies.suites import Suite
from tisph.studies.verify import Runner
runner = Runner(Suite("", manufactured.runs(False)), Path())
for each in map(runner.judge, manufactured.bounds(sys.argv[1], quick=True)):
    print(f"{each.quantity} {each.value:.3g} ({each.bound})" if not each.passed else "", end=";")
"""


def failed_rows(name: str, folder: Path) -> list[str]:
    """Return the rows or tests that fail with the error ``name`` planted in a copy of the package in ``folder``."""
    case, file, text, other = ERRORS[name]
    shutil.copytree(ROOT / "tisph", folder / "tisph", ignore=shutil.ignore_patterns("__pycache__"))
    path = folder / "tisph" / "schemes" / file
    source = path.read_text(encoding="utf-8")
    if text not in source:
        raise SystemExit(f"{path.name} no longer has {text!r}: name the term as it is now")
    path.write_text(source.replace(text, other) if text else source, encoding="utf-8")
    tested, is_test, test = case.partition("::")
    command = [sys.executable, "-c", JUDGE, case]
    if is_test:
        shutil.copytree(ROOT / "tests", folder / "tests")
        shutil.copy(ROOT / "pyproject.toml", folder)
        command = [sys.executable, "-m", "pytest", "-q", "--tb=no", f"tests/schemes/{tested}.py", "-k", test]
    ended = subprocess.run(
        command, cwd=folder, env={**os.environ, "PYTHONPATH": str(folder)}, capture_output=True, text=True
    )
    if is_test:
        return [line.split("::")[1].split()[0] for line in ended.stdout.splitlines() if line.startswith("FAILED")]
    rows = [row for row in ended.stdout.rpartition("\n")[2].split(";") if row]
    return rows if ended.returncode == 0 else [f"the run fails: {ended.stderr.strip().splitlines()[-1]}"]


def main() -> int:
    """Print a table of terms, cases and rows that fail; return whether an error goes unnoticed."""
    print("| term | case | rows or tests that fail |\n|---|---|---|")
    unnoticed = False
    for name in ERRORS:
        if sys.argv[1:] and not any(word in name for word in sys.argv[1:]):
            continue
        with tempfile.TemporaryDirectory() as folder:
            rows = failed_rows(name, Path(folder))
        unnoticed |= bool(rows) == (name == "none")
        print(f"| {name} | {ERRORS[name][0]} | {', '.join(rows) or '-'} |", flush=True)
    return int(unnoticed)


if __name__ == "__main__":
    raise SystemExit(main())
