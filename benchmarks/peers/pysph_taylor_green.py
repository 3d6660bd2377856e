"""PySPH's own Taylor-Green example, on one thread; prints one line of JSON.

Run it with env-pysph's Python. Period, speed and density are 1, the Reynolds number 100, the sound speed 10: all as in
the example, as are kernel (quintic spline, h = spacing), steps and the background pressure of both schemes. With
``--perturb`` 0.2 its particles start up to 0.2 spacings off a lattice, to one side; tisph's start as far to either.

``loop_seconds`` are seconds of the processor: one thread can have no more of them than of the clock's. What else the
machine does counts less then, but it still counts: compare what was timed on a quiet one.
"""

import tempfile

from pysph.examples import taylor_green as example
from pysph_serial import argument_parser, report, solved, write

REYNOLDS = 100.0
PERTURBATION = 0.2


def main():
    """Set up (compiling at the first time), run the time loop, and report."""
    parser = argument_parser(__doc__.splitlines()[0], across="particles along the period")
    parser.add_argument("--scheme", choices=("tvf", "edac"), default="tvf")
    arguments = parser.parse_args()
    options = ["--disable-output", "--scheme", arguments.scheme, "--nx", str(arguments.across)]
    options += ["--re", str(REYNOLDS), "--perturb", str(PERTURBATION), "--tf", repr(arguments.end)]
    with tempfile.TemporaryDirectory() as folder:
        application = example.TaylorGreen(output_dir=folder)
        loop_seconds = solved(application, options)
    (fluid,) = application.particles
    write(arguments.particles, fluid)
    flow = {"length": example.L, "speed": example.U, "kinematic_viscosity": example.U * example.L / REYNOLDS}
    report(application.solver, fluid, loop_seconds, **flow)


if __name__ == "__main__":
    main()
