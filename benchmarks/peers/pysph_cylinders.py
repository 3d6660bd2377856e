"""PySPH's own example of periodic cylinders in a channel, on one thread; prints one line of JSON.

Run it with env-pysph's Python. All is as in the example but for the number of particles, of which it has 96 across the
channel (42 hours), and the end, which is given in radius^2/viscosity. The drag is what its own function makes of its
last output; it divides that by a nominal velocity, which is taken out again, and the superficial velocity is that of
the particles. ``loop_seconds`` are seconds of the processor, as in ``pysph_taylor_green.py``, without that output.
"""

import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from unittest.mock import MagicMock

import numpy as np
from pysph_serial import argument_parser, report, solved, write

THEIRS = "nx = 144"
"""The line of the example that says how many particles there are along the period, 1.5 times the height."""


def main():
    """Set up (compiling at the first time), run the time loop, and report."""
    parser = argument_parser(__doc__.splitlines()[0], across="particles between the walls")
    arguments = parser.parse_args()
    example = example_with(round(1.5 * arguments.across))
    end = arguments.end * example.a**2 / example.nu
    with tempfile.TemporaryDirectory() as folder:
        application = example.PeriodicCylinders(output_dir=folder)
        loop_seconds = solved(application, ["--tf", repr(end), "--pfreq", "1000000"])
        application.read_info(application.info_filename)
        sys.modules["matplotlib"] = MagicMock()  # not in this environment: the function draws a picture, too
        drag = application._plot_cd_vs_t()[1][-1] * example.Umax
    fluid = application.particles[0]
    write(arguments.particles, fluid)
    real = fluid.tag == 0
    velocity = float(np.sum(fluid.m[real] * fluid.u[real])) / (example.rho0 * example.L * example.H)
    # the drag is one over the dynamic viscosity
    report(application.solver, fluid, loop_seconds, drag=float(drag), superficial_velocity=velocity)


def example_with(number):
    """The example's module with so many particles along the period: it has no option for that."""
    path = Path(find_spec("pysph.examples.periodic_cylinders").origin)
    text = path.read_text(encoding="utf-8")
    if THEIRS not in text:
        raise RuntimeError(f"{path} has no line {THEIRS}")
    module = ModuleType("periodic_cylinders")
    module.__file__ = str(path)
    exec(compile(text.replace(THEIRS, f"nx = {number}"), path, "exec"), vars(module))
    return module


if __name__ == "__main__":
    main()
