"""PySPH on the case of ``couette_case.py``; prints one line of JSON.

Run it with env-pysph's Python; OMP_NUM_THREADS sets the number of threads. The set-up is that of PySPH's own
Couette example: transport velocity (TVF), quintic spline with h = spacing, walls of Adami dummy particles, PEC
integrator (one evaluation of all forces a step), linked-list neighbours, options at their defaults. ``--scheme edac``
evolves the pressure with artificial compressibility (EDAC) instead, set up as in PySPH's cavity example. ``--tuned``
takes what makes it faster without changing the result: neighbours cached during a step, and no wall particles beyond
the reach of the kernel.
"""

import os
import tempfile
import time

import couette_case as case
import numpy as np
import pysph
from pysph.base.nnps import DomainManager
from pysph.base.utils import get_particle_array
from pysph.solver.application import Application
from pysph.solver.output import dump
from pysph.sph.scheme import TVFScheme
from pysph.sph.wc.edac import EDACScheme

EXAMPLE_LAYERS = 5
"""Layers of wall particles in PySPH's example."""

REACHED_LAYERS = 3
"""Layers that a quintic spline (support 3 h) sees from the fluid: the outer two have no influence."""


class PlaneCouette(Application):
    """Fluid between two walls of dummy particles, periodic in x."""

    def __init__(self, arguments, output_dir):
        self.spacing = case.spacing(arguments.across)
        self.layers = REACHED_LAYERS if arguments.tuned else EXAMPLE_LAYERS
        self.step = case.time_step(arguments)
        self.steps = arguments.steps
        self.make_scheme = {"tvf": self.transport_velocity, "edac": self.evolved_pressure}[arguments.scheme]
        super().__init__(output_dir=output_dir)

    def create_domain(self):
        """Periodic in x."""
        return DomainManager(xmin=0.0, xmax=case.LENGTH, periodic_in_x=True)

    def create_scheme(self):
        """The scheme of the command line, with the background pressure of the examples, density * sound speed^2."""
        scheme = self.make_scheme(
            ["fluid"],
            ["walls"],
            dim=2,
            rho0=case.DENSITY,
            c0=case.SOUND_SPEED,
            nu=case.KINEMATIC_VISCOSITY,
            pb=case.DENSITY * case.SOUND_SPEED**2,
        )
        scheme.configure_solver(dt=self.step, tf=self.steps * self.step)
        return scheme

    def transport_velocity(self, *arrays, pb, **fluid):
        """Pressure from the density."""
        return TVFScheme(*arrays, p0=pb, pb=pb, h0=self.spacing, **fluid)

    def evolved_pressure(self, *arrays, **fluid):
        """Pressure with an equation of its own."""
        return EDACScheme(*arrays, h=self.spacing, **fluid)

    def create_particles(self):
        """Square lattice, with the particles outside the gap as walls."""
        columns = np.arange(round(case.LENGTH / self.spacing))
        rows = np.arange(-self.layers, round(case.GAP / self.spacing) + self.layers)
        x, y = (self.spacing * (index.ravel() + 0.5) for index in np.meshgrid(columns, rows))
        inside = (y > 0) & (y < case.GAP)
        fluid = get_particle_array(name="fluid", x=x[inside], y=y[inside])
        walls = get_particle_array(name="walls", x=x[~inside], y=y[~inside])
        self.scheme.setup_properties([fluid, walls])
        for array in (fluid, walls):
            array.rho[:] = case.DENSITY
            array.m[:] = case.DENSITY * self.spacing**2
            array.V[:] = 1 / self.spacing**2  # PySPH's V is the number density
            array.h[:] = self.spacing
        walls.u[walls.y > case.GAP] = case.WALL_VELOCITY
        return [fluid, walls]


def main():
    """Set up (compiling at the first time), run the time loop alone against the clock, and report."""
    parser = case.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--scheme", choices=("tvf", "edac"), default="tvf")
    parser.add_argument("--tuned", action="store_true", help="cached neighbours, three wall layers")
    arguments = parser.parse_args()
    threads = int(os.environ.get("OMP_NUM_THREADS", os.cpu_count()))
    options = ["--quiet", "--disable-output"]
    options += ["--openmp"] if threads > 1 else []
    options += ["--cache-nnps"] if arguments.tuned else []
    with tempfile.TemporaryDirectory() as folder:
        application = PlaneCouette(arguments, folder)
        application.setup(options)
        start = time.perf_counter()
        application.solver.solve(show_progress=False)
        loop_seconds = time.perf_counter() - start
    if application.solver.count != arguments.steps:
        raise RuntimeError(f"PySPH took {application.solver.count} steps instead of {arguments.steps}")
    fluid = application.particles[0]
    if arguments.profile:
        case.write_profile(arguments.profile, zip(fluid.y.tolist(), fluid.u.tolist(), strict=True))
    if arguments.dump:
        solver = application.solver
        dump(
            arguments.dump,
            application.particles,
            {"t": solver.t, "dt": solver.dt, "count": solver.count},
            compress=True,
        )
    case.report(
        version=pysph.__version__,
        across=arguments.across,
        steps=arguments.steps,
        loop_seconds=loop_seconds,
        threads=threads,
    )


if __name__ == "__main__":
    main()
