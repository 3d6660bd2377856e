"""Benchmark 2D-1 of Schaefer and Turek (1996) with PySPH's own inlet and outlet, on one thread; prints a line of JSON.

Run it with env-pysph's Python, or by ``measure.py --case cylinder_in_stream --code pysph-edac``:

    env-pysph/bin/python pysph_cylinder_in_stream.py --across 41 --end 4 --particles particles.txt

PySPH's example of flow past a cylinder (EDAC) is changed only where the benchmark asks for it: walls without slip,
a parabola at the inlet and at the start, and a cylinder off the centre line. Lengths are in metres. The unit of
velocity is the largest of the inflow, 0.3 m/s, and the density is 1000, as in the example; its Reynolds number is then
30, and a second is 0.3 of its units of time. ``--end`` is in seconds. The outermost particles of the example's cylinder
are on its circle, so the cylinder is half a spacing too large (``--inside 0``); by default these particles are half a
spacing further in. The example's own function finds the drag from the output; the result is a mean over t > 2.5 s, and
``drag_range`` is the spread. ``loop_seconds`` are seconds of the processor, as in ``pysph_taylor_green.py``, with the
output.
"""

import contextlib
import sys
import tempfile
from unittest.mock import MagicMock

import numpy as np
from pysph.base.utils import get_particle_array
from pysph.examples import flow_past_cylinder_2d as example
from pysph.sph.equation import Equation
from pysph.sph.wc.edac import EDACScheme
from pysph_serial import argument_parser, report, solved, write

LENGTH, HEIGHT, DIAMETER, CENTRE = 2.2, 0.41, 0.1, (0.2, 0.2)
SECOND, MEAN, REYNOLDS, DRAG = 0.3, 2.0 / 3.0, 30.0, 5.579535
METHODS = ("donothing", "mirror", "hybrid", "mod_donothing", "characteristic")


class Parabola(Equation):
    """Velocity of a fully developed flow with the largest velocity ``speed``."""

    def __init__(self, dest, sources, speed, half_height):
        self.speed = speed
        self.half_height = half_height
        super().__init__(dest, sources)

    def loop(self, d_idx, d_u, d_v, d_w, d_y, d_uref):
        """Set it, and the reference velocity of the outlets that have one."""
        if d_idx == 0:
            d_uref[0] = self.speed
        d_u[d_idx] = self.speed * (1.0 - (d_y[d_idx] / self.half_height) ** 2)
        d_v[d_idx] = 0.0
        d_w[d_idx] = 0.0


class Stream(example.WindTunnel):
    """The example as the benchmark; ``inside``: spacings from the circle in to the cylinder's outermost particles."""

    def __init__(self, across, method, inside, **options):
        self.across, self.method, self.inside = across, method, inside
        super().__init__(**options)

    def consume_user_options(self):
        """Sizes of the benchmark in place of the example's."""
        self.options.dc, self.options.re, self.options.io_method = DIAMETER, REYNOLDS, self.method
        self.options.nx = DIAMETER / HEIGHT * self.across
        self.options.Lt, self.options.Wt = 2.0 * LENGTH / DIAMETER, HEIGHT / DIAMETER
        super().consume_user_options()

    def create_scheme(self):
        """The example's, with walls that are solids as the cylinder is."""
        found = {"rho0": example.rho, "c0": example.c0, "pb": example.p0}
        return EDACScheme(["fluid"], ["solid", "wall"], dim=2, h=None, nu=None, **found)

    def _create_solid(self):
        dx, volume = self.dx, self.dx**2
        rings = [(r, np.rint(2.0 * np.pi * r / dx)) for r in np.arange(DIAMETER / 2 - self.inside * dx, 0.0, -dx)]
        disc = np.concatenate([r * np.exp(2j * np.pi * np.arange(n) / n) for r, n in rings])
        disc += complex(CENTRE[0], CENTRE[1] - HEIGHT / 2)
        same = {"m": volume * example.rho, "rho": example.rho, "h": self.h, "V": 1.0 / volume}
        return get_particle_array(name="solid", x=disc.real, y=disc.imag, **same)

    def create_particles(self):
        """The example's, with the parabola as their velocity."""
        particles = super().create_particles()
        for array in particles:
            if array.name not in ("solid", "wall"):
                sign = -1.0 if array.name == "ghost_inlet" else 1.0
                array.u[:] = array.uhat[:] = sign * (1.0 - (array.y / self.Wt) ** 2)
        return particles

    def _get_io_info(self):
        inlet, outlet, manager = super()._get_io_info()
        signs = {"ghost_inlet": -1.0, "inlet": 1.0}
        inlet.equations = [Parabola(name, [], sign * example.umax, self.Wt) for name, sign in signs.items()]
        return inlet, outlet, manager


def main():
    """Set up (compiling at the first time), run the time loop, and report."""
    parser = argument_parser(__doc__.splitlines()[0], across="particles between the walls")
    parser.add_argument("--method", choices=METHODS, default=METHODS[0], help="PySPH's outlet")
    parser.add_argument("--inside", type=float, default=0.5, help="spacings from the circle to the outermost particles")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(sys.stderr):
        application = Stream(arguments.across, arguments.method, arguments.inside, output_dir=folder)
        frequency = str(2 * arguments.across)  # about 50 of them in four seconds
        loop_seconds = solved(application, ["--tf", repr(SECOND * arguments.end), "--pfreq", frequency])
        application.read_info(application.info_filename)
        sys.modules["matplotlib"] = MagicMock()  # not in this environment: the function draws a picture, too
        t, drag, _ = application._plot_force_vs_t()
    fluid = application.particles[0]
    write(arguments.particles, fluid)
    last = drag[t > SECOND * min(2.5, 0.9 * arguments.end)] / MEAN**2  # the example divides by the largest velocity
    found = {"drag_coefficient": float(last.mean()), "error": float(abs(last.mean() / DRAG - 1.0))}
    report(application.solver, fluid, loop_seconds, **found, drag_range=[float(last.min()), float(last.max())])


if __name__ == "__main__":
    main()
