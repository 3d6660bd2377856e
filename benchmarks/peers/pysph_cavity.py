"""PySPH's own cavity example, on one thread; prints one line of JSON.

Run it with env-pysph's Python. Side, speed of the lid and density are 1, the Reynolds number 100, the sound speed 10:
all as in the example, as are kernel (quintic spline, h = spacing), steps, walls of five layers and the background
pressure of both schemes; its end is 10. ``loop_seconds`` are seconds of the processor, as in ``pysph_taylor_green.py``.
"""

import tempfile

from pysph.examples import cavity as example
from pysph_serial import argument_parser, report, solved, write

REYNOLDS = 100.0


def main():
    """Set up (compiling at the first time), run the time loop, and report."""
    parser = argument_parser(__doc__.splitlines()[0], across="particles along a side")
    parser.add_argument("--scheme", choices=("tvf", "edac"), default="tvf")
    arguments = parser.parse_args()
    options = ["--scheme", arguments.scheme, "--nx", str(arguments.across)]
    options += ["--re", str(REYNOLDS), "--tf", repr(arguments.end)]
    with tempfile.TemporaryDirectory() as folder:
        application = example.LidDrivenCavity(output_dir=folder)
        loop_seconds = solved(application, [*options, "--disable-output"])
    fluid = application.particles[0]
    write(arguments.particles, fluid)
    report(application.solver, fluid, loop_seconds)


if __name__ == "__main__":
    main()
