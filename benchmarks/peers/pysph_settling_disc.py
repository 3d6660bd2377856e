"""A disc that settles in a closed box, with PySPH on one thread; prints one line of JSON.

Run it with env-pysph's Python. The case is that of Glowinski et al. (2001) and of Wan and Turek (2006), in cgs units.
PySPH has no example of it; its equations are put together here in two ways. ``akinci`` is what its examples of bodies
in a fluid do, with laminar viscosity, its viscosity of rigid bodies, and a background pressure. ``adami`` is its
transport velocity scheme: the disc is one more wall, and the fluid's forces on it are summed up, with two short
equations that PySPH does not have. There is no gravity on the fluid, the disc is pulled by its weight less its
buoyancy: for an incompressible fluid that is the same flow, and ten times the disc's speed is a sound speed enough.
"""

import argparse
import tempfile

import numpy as np
from pysph.base.kernels import CubicSpline, QuinticSpline
from pysph.base.utils import get_particle_array_rigid_body, get_particle_array_tvf_fluid, get_particle_array_wcsph
from pysph.solver.application import Application
from pysph.solver.solver import Solver
from pysph.sph import rigid_body as rigid
from pysph.sph.basic_equations import SummationDensity, XSPHCorrection
from pysph.sph.equation import Equation, Group
from pysph.sph.integrator import EPECIntegrator, PECIntegrator
from pysph.sph.integrator_step import TransportVelocityStep, WCSPHStep
from pysph.sph.wc import basic, viscosity
from pysph.sph.wc import transport_velocity as tvf
from pysph_serial import report, solved

SIZE, START, RADIUS, GAP = (2.0, 6.0), (1.0, 4.0), 0.125, 0.0625
DENSITY, DISC_DENSITY, VISCOSITY, SOUND, REYNOLDS = 1.0, 1.25, 0.1, 60.0, 17.42
STIFFNESS, PULL = DENSITY * SOUND**2, -981.0 * (1.0 - DENSITY / DISC_DENSITY)


class Friction(Equation):
    """The opposite of what ``SolidWallNoSlipBC`` does to the fluid; comes last, and makes forces of accelerations."""

    def loop(self, d_idx, s_idx, d_m, d_V, s_V, d_au, d_av, d_ug, d_vg, s_u, s_v, DWIJ, XIJ, R2IJ, EPS):
        """Add the friction of one particle of the fluid."""
        slope = (XIJ[0] * DWIJ[0] + XIJ[1] * DWIJ[1]) / (R2IJ + EPS)
        factor = 0.1 * slope * (1.0 / (d_V[d_idx] * d_V[d_idx]) + 1.0 / (s_V[s_idx] * s_V[s_idx])) / d_m[d_idx]
        d_au[d_idx] += factor * (d_ug[d_idx] - s_u[s_idx])
        d_av[d_idx] += factor * (d_vg[d_idx] - s_v[s_idx])

    def post_loop(self, d_idx, d_m, d_au, d_av, d_fx, d_fy):
        """Set the force of everything on this particle."""
        d_fx[d_idx] = d_m[d_idx] * d_au[d_idx]
        d_fy[d_idx] = d_m[d_idx] * d_av[d_idx]


class Carried(Equation):
    """Gives the particles of the disc its acceleration, of which their pressure makes use."""

    def initialize(self, d_idx, d_au, d_av, d_ac):
        """Set it."""
        d_au[d_idx] = d_ac[0]
        d_av[d_idx] = d_ac[1]


class SettlingDisc(Application):
    """The case; ``rows`` are time, height and downward speed of the disc after every step."""

    def __init__(self, spacing, coupling, **options):
        self.spacing, self.adami, self.rows = spacing, coupling == "adami", []
        self.h = spacing if self.adami else 1.2 * spacing
        super().__init__(**options)

    def create_particles(self):
        """A lattice with walls of three layers, without those in the disc; this is made of rings."""
        dx, volume = self.spacing, self.spacing**2
        x, y = np.meshgrid(*(np.arange(-2.5 * dx, size + 3.0 * dx, dx) for size in SIZE))
        inside = (x > 0.0) & (x < SIZE[0]) & (y > 0.0) & (y < SIZE[1])
        fluid = inside & (np.hypot(x - START[0], y - START[1]) > RADIUS)
        rings = [(r, np.rint(2.0 * np.pi * r / dx)) for r in np.arange(RADIUS - 0.5 * dx, 0.0, -dx)]
        disc = complex(*START) + np.concatenate([r * np.exp(2j * np.pi * np.arange(n) / n) for r, n in rings])
        mass = DISC_DENSITY * np.pi * RADIUS**2 / disc.size
        same = {"rho": DENSITY, "h": self.h, "V": 1.0 / volume if self.adami else volume}  # as either set has it
        extra = dict.fromkeys(("wij", "uf", "vf", "wf", "ug", "vg", "wg", "auhat", "avhat", "awhat"), 0.0)
        fluids = get_particle_array_tvf_fluid if self.adami else get_particle_array_wcsph
        return [
            fluids(name="fluid", x=x[fluid], y=y[fluid], m=DENSITY * volume, **same),
            get_particle_array_rigid_body(name="wall", x=x[~inside], y=y[~inside], m=DENSITY * volume, **same, **extra),
            get_particle_array_rigid_body(name="disc", x=disc.real, y=disc.imag, m=mass, **same, **extra),
        ]

    def create_solver(self):
        """Kernel and integrator as in PySPH's examples, the steps those of its transport velocity scheme."""
        if self.adami:
            kernel = QuinticSpline(dim=2)
            scheme = PECIntegrator(fluid=TransportVelocityStep(), disc=rigid.EulerStepRigidBody())
        else:
            kernel = CubicSpline(dim=2)
            scheme = EPECIntegrator(fluid=WCSPHStep(), disc=rigid.RK2StepRigidBody())
        return Solver(kernel=kernel, dim=2, integrator=scheme, dt=0.25 * self.h / (1.1 * SOUND), tf=1.0)

    def create_equations(self):
        """One of the sets; ``ViscosityRigidBody`` only counts pairs that approach: 16 nu, where it would else be 8."""
        solids, every, nu = ["wall", "disc"], ["fluid", "wall", "disc"], VISCOSITY / DENSITY
        if self.adami:
            forces = [
                tvf.MomentumEquationPressureGradient("fluid", every, pb=STIFFNESS),
                tvf.MomentumEquationViscosity("fluid", ["fluid"], nu=nu),
                tvf.SolidWallNoSlipBC("fluid", solids, nu=nu),
                tvf.MomentumEquationArtificialStress("fluid", ["fluid"]),
                tvf.MomentumEquationPressureGradient("disc", ["fluid"], pb=STIFFNESS, gy=PULL),
                Friction("disc", ["fluid"]),
            ]
            first = [tvf.SummationDensity("fluid", every), Carried("disc", None)]
            state = [tvf.SetWallVelocity(solid, ["fluid"]) for solid in solids]
            state += [tvf.StateEquation("fluid", None, p0=STIFFNESS, rho0=DENSITY)]
            last = [tvf.SolidWallPressureBC(solid, ["fluid"], rho0=DENSITY, p0=STIFFNESS) for solid in solids]
        else:
            forces = [
                basic.MomentumEquation("fluid", ["fluid"], c0=SOUND, alpha=0.0, beta=0.0),
                viscosity.LaminarViscosity("fluid", ["fluid"], nu=nu),
                rigid.AkinciRigidFluidCoupling("fluid", solids, fluid_rho=DENSITY),
                rigid.ViscosityRigidBody("fluid", solids, rho0=DENSITY * self.spacing**4, nu=16.0 * nu),
                XSPHCorrection("fluid", ["fluid"], eps=0.0),
            ]
            first = [rigid.BodyForce(solid, None, gy=PULL) for solid in solids]  # that of the wall moves nothing
            state = [SummationDensity("fluid", ["fluid"]), rigid.SummationDensityBoundary("fluid", solids, DENSITY)]
            last = [basic.TaitEOS("fluid", None, rho0=DENSITY, c0=SOUND, gamma=7.0, p0=0.05 * STIFFNESS)]
        motion = [rigid.RigidBodyMoments("disc", None)], [rigid.RigidBodyMotion("disc", None)]
        return [Group(equations=group) for group in (first, state, last, forces, *motion)]

    def post_step(self, solver):
        """Note where the disc is; the end is when it is near the floor."""
        disc = self.particles[2]
        self.rows.append((solver.t, float(np.mean(disc.y)), -float(disc.vc[1])))
        if self.rows[-1][1] <= RADIUS + GAP:
            solver.tf = solver.t


def main():
    """Set up (compiling at the first time), run the time loop, and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spacing", type=float, default=1.0 / 24.0, help="of the particles")
    parser.add_argument("--coupling", choices=("akinci", "adami"), default="akinci")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        application = SettlingDisc(arguments.spacing, arguments.coupling, output_dir=folder)
        loop_seconds = solved(application, ["--disable-output"])
    t, y, speed = np.array(application.rows).T
    reynolds = DISC_DENSITY * speed.max() * 2.0 * RADIUS / VISCOSITY
    found = {"largest_speed": speed.max(), "at": t[speed.argmax()], "reynolds": reynolds}
    found["gap_time"] = float(np.interp(RADIUS + GAP, y[:-3:-1], t[:-3:-1])) if y[-1] <= RADIUS + GAP else None
    report(application.solver, application.particles[0], loop_seconds, error=reynolds / REYNOLDS - 1.0, **found)


if __name__ == "__main__":
    main()
