"""Manufactured solutions: flows that are chosen, and driven by the forces that the equations then ask for.

Chosen are a velocity u without divergence that obeys no slip, from a stream function psi, a pressure p over the density,
and for polymers a conformation tensor A. sympy derives the body force f and the source Q of the conformation,

    f = Du/Dt + grad p - div T,    T = 2 nu D + S,    D = (L + L^T)/2,    L = grad u,
    Q = DA/Dt - L A - A L^T + (A - 1)/lambda,    S = nu_p/lambda (A - 1) of an Oldroyd-B fluid,

with nu = nu(2 D:D) of a power law. Axisymmetric tensors have the components along x, r and around the axis, and
derivatives along paths turn with the axes. Flows start from rest and grow with time, and run through the public
interface, ``tisph.Simulation(config, body_force=..., conformation_source=...)``. Source of the method: P. J. Roache, J.
Fluids Eng. 124 (2002) 4-10.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from tisph.errors import ConfigError, TisphError
from tisph.schemes._supported import AROUND_BODIES
from tisph.studies.flows import across, at_times, merged
from tisph.studies.processes import Result
from tisph.studies.verification.criteria import at_most, order

DENSITY, VISCOSITY = 2.0, 0.05
RELAXATION_TIME, SOLVENT_FRACTION = 0.5, 0.4
INDEX = 0.6


def symbols() -> tuple[Any, Any, Any]:
    """Return the symbols x, y (the radius r in axisymmetric flow) and t; ConfigError without sympy."""
    try:
        import sympy
    except ImportError:
        raise ConfigError("verify manufactured: sympy is missing, which pip install 'tisph[test]' brings") from None
    return sympy.symbols("x y t", real=True)


@dataclass(frozen=True)
class Solution:
    """Expressions of x, y and t: ``velocity`` (u, v, w), ``pressure`` over density, ``conformation`` (3 x 3 or None).

    ``viscosity``: nu as an expression of 2 D:D, of the solvent where there is a polymer.
    """

    velocity: tuple
    pressure: Any
    conformation: Any = None
    axisymmetric: bool = False
    viscosity: Callable = lambda rate_squared: VISCOSITY

    def fields(self) -> dict[str, Callable]:
        """Return functions of arrays x, y and a time: ``velocity``, ``pressure``, ``stress``, ``force``, ``source``."""
        from sympy import Matrix, eye

        x, y, t = symbols()
        u = Matrix(self.velocity)
        gradient, turn = self._gradient(u)
        strain = (gradient + gradient.T) / 2
        viscosity = self.viscosity(2 * sum((strain * strain)[i, i] for i in range(3)))
        stress, found = 2 * viscosity * strain, {}

        def along_path(field):
            return field.diff(t) + u[0] * field.diff(x) + u[1] * field.diff(y)

        if self.conformation is not None:
            A, modulus = self.conformation, (1 - SOLVENT_FRACTION) * VISCOSITY / RELAXATION_TIME
            stress += modulus * (A - eye(3))
            change = along_path(A) + turn * A + A * turn.T
            found["source"] = change - gradient * A - A * gradient.T + (A - eye(3)) / RELAXATION_TIME
            found["stress"] = DENSITY * modulus * (A - eye(3))
        push = Matrix([self.pressure.diff(x), self.pressure.diff(y), 0])
        found["force"] = along_path(u) + turn * u + push - self._divergence(stress)
        return {name: self._function(field) for name, field in found.items()} | {
            "velocity": self._function(u),
            "pressure": self._function(Matrix([DENSITY * self.pressure])),
        }

    def _gradient(self, u):
        """Return du_a/dx_b, and the angular velocity w/r of the axes along a path as a matrix."""
        from sympy import Matrix, zeros

        x, y, _ = symbols()
        gradient, turn = zeros(3, 3), zeros(3, 3)
        gradient[:, 0], gradient[:, 1] = u.diff(x), u.diff(y)
        if self.axisymmetric:
            gradient[:, 2] = Matrix([0, -u[2] / y, u[1] / y])
            turn[1, 2], turn[2, 1] = -u[2] / y, u[2] / y
        return gradient, turn

    def _divergence(self, T):
        from sympy import Matrix

        x, y, _ = symbols()
        force = Matrix([T[a, 0].diff(x) + T[a, 1].diff(y) for a in range(3)])
        if self.axisymmetric:
            force += Matrix([T[0, 1], T[1, 1] - T[2, 2], 2 * T[1, 2]]) / y
        return force

    def _function(self, field):
        """Return a function of x, y, t with the components of a vector, or of a tensor as configs order them."""
        from sympy import lambdify

        if field.shape == (3, 3):
            places = ((0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2))[: 6 if self.axisymmetric else 3]
            field = [field[place] for place in places]
        elif field.shape == (3, 1):
            field = list(field)[: 3 if self.axisymmetric else 2]
        return lambdify(symbols(), list(field), modules="numpy", cse=True)


@dataclass(frozen=True)
class Case:
    """A flow: its config without resolution and times, a function that makes its ``Solution``, and its ``end``.

    ``resolutions``: particles across of three runs; ``bounds``: relative L2 errors of velocity and pressure, and of the
    stress of a polymer, at the finest; ``orders``: least power of the spacing with which they fall.
    """

    config: dict
    solution: Callable[[], Solution]
    resolutions: tuple[int, ...]
    bounds: tuple[float, ...]
    orders: tuple[float, ...] = (3.5, 2.5, 2.5)
    end: float = 0.5
    initially: Callable | None = None

    def run(self, number: int) -> tuple[Result, str]:
        """Run the flow with ``number`` particles across; return the errors as a ``Result``, and a message if it failed."""
        import tisph

        fields = _fields(self.solution)
        given = {"body_force": fields["force"], "conformation_source": fields.get("source")}
        config = merged(SHARED, self.config, across(number), at_times([self.end]))
        drive = config.get("drive", {}).get("acceleration", 0.0)
        if drive:
            given["body_force"] = lambda x, y, t: [fields["force"](x, y, t)[0] - drive, *fields["force"](x, y, t)[1:]]
        if config["scene"] == "shear_layer":
            given["initial_velocity"] = lambda x, y, t: (0.0, 0.0)
        try:
            with tisph.Simulation(config, **given) as simulation:
                sample = {"t_star": self.end, **_errors(simulation.run_until(self.end).snapshot, fields)}
                sample |= {"step": simulation.steps, "resolved": True}
        except TisphError as error:
            return Result(Path(), {"status": "failed", "samples": []}), str(error)
        return Result(Path(), {"status": "done", "samples": [sample]}), ""


@cache
def _fields(solution):
    return solution().fields()


def _errors(snapshot, fields):
    """Return relative L2 errors of the velocity ``l2``, of ``l2_pressure`` and, with a polymer, ``l2_stress``."""
    x, y, t = snapshot.x.astype(float), snapshot.y.astype(float), snapshot.t

    def off(names, exact, mean=0.0):
        values = np.array([getattr(snapshot, name) for name in names], dtype=float)
        exact = np.array([np.broadcast_to(each, x.shape) for each in exact(x, y, t)])
        apart = values - exact
        return float(np.linalg.norm(apart - mean * apart.mean()) / np.linalg.norm(exact - mean * exact.mean()))

    swirls = snapshot.w is not None
    found = {"l2": off("uvw" if swirls else "uv", fields["velocity"])}
    found["l2_pressure"] = off(["pressure"], fields["pressure"], mean=1.0)
    if "stress" in fields:
        from tisph.snapshot import STRESSES, STRESSES_AROUND

        found["l2_stress"] = off([*STRESSES, *(STRESSES_AROUND if swirls else ())], fields["stress"])
    return found


EXPLICIT = {"scheme": {"type": "wcsph"}, "time": {"tolerance": "auto"}, "reference": {"velocity": 1.0}}
SHARED = {
    "fluid": {"density": DENSITY, "kinematic_viscosity": VISCOSITY},
    "initial": {"jitter": 0.2, "seed": 0},
    "time": {"tolerance": 1e-6},
}
POLYMER = {
    "fluid": {
        "rheology": {
            "type": "oldroyd_b",
            "relaxation_time": RELAXATION_TIME,
            "solvent_fraction": SOLVENT_FRACTION,
        }
    }
}
SWING = {"amplitude": 0.8, "angular_frequency": 2.0, "phase": "sin"}

SQUARE = {"scene": "shear_layer", "geometry": {"length": 1.0}, "initial": {"velocity": 1.0, "thickness": 0.04}}
ANNULUS = {
    "scene": "annulus",
    "geometry": {"inner_radius": 1.0, "outer_radius": 2.0},
    "walls": {"inner": SWING, "outer": {"angular_velocity": 0.0}},
}
PIPE = {"scene": "pipe", "geometry": {"radius": 1.0, "length": 2.0}, "walls": {}, "drive": {"acceleration": 0.4}}


def _from_rest(t):
    from sympy import sin

    return sin(2 * t) ** 2


def _swing(t):
    from sympy import sin

    return SWING["amplitude"] * sin(SWING["angular_frequency"] * t)


def _planar(psi, pressure, **others):
    x, y, _ = symbols()
    return Solution((psi.diff(y), -psi.diff(x), 0), pressure, **others)


def _of_revolution(psi, swirl, pressure, **others):
    x, y, _ = symbols()
    return Solution((psi.diff(y) / y, -psi.diff(x) / y, swirl), pressure, axisymmetric=True, **others)


def _square(**others):
    from sympy import cos, pi, sin

    x, y, t = symbols()
    a, b, grown = 2 * pi * x, 2 * pi * y, _from_rest(t)
    psi = grown * (sin(a) * sin(b) + 0.4 * cos(a - b)) / (2 * pi)
    return _planar(psi, 0.5 * grown * cos(a) * sin(b + 0.3), **others)


def _square_polymer():
    from sympy import Matrix, cos, eye, pi, sin

    x, y, t = symbols()
    a, b = 2 * pi * x, 2 * pi * y
    shear = 0.3 * cos(a) * sin(b)
    stretch = Matrix([[0.8 + 0.4 * sin(a), shear, 0], [shear, 0.5 + 0.3 * cos(a + b), 0], [0, 0, 0]])
    return _square(conformation=eye(3) + _from_rest(t) * stretch, viscosity=_solvent)


def _eccentric():
    x, y, t = symbols()
    inner, outer, grown = (x - 0.5) ** 2 + y**2 - 1, 4 - x**2 - y**2, _from_rest(t)
    turning = -_swing(t) / 2 * (inner + 1) * outer**2 / (inner**2 + outer**2)
    return _planar(turning + 0.05 * grown * (inner * outer) ** 2 * (1 + 0.5 * y), 0.3 * grown * (x * y + x))


def _rounded():
    x, y, t = symbols()
    grown = _from_rest(t)
    psi = 0.5 * grown * (1 - x**4 - y**4) ** 2 * (1 + 0.3 * x + 0.4 * y)
    return _planar(psi, 0.3 * grown * (x * y + x))


def _rounded_outline(points=400):
    """Return points of x^4 + y^4 = 1; the spline through them is off it by less than 1e-8."""
    angle = np.arange(points) * 2.0 * np.pi / points
    radius = (np.cos(angle) ** 4 + np.sin(angle) ** 4) ** -0.25
    return (radius * [np.cos(angle), np.sin(angle)]).T.tolist()


MOVING = {"amplitude": [0.3, 0.1], "angular_amplitude": 0.6, "angular_frequency": 3.0, "phase": "sin"}


def _moving_circle():
    from sympy import cos, pi, sin

    x, y, t = symbols()
    rate = MOVING["angular_frequency"]
    speeds, turning = [a * sin(rate * t) for a in MOVING["amplitude"]], MOVING["angular_amplitude"] * sin(rate * t)
    along, across = (
        place - 0.5 - a * (1 - cos(rate * t)) / rate for place, a in zip((x, y), MOVING["amplitude"], strict=True)
    )
    wall, circle, window = y * (1 - y), along**2 + across**2 - 0.2**2, cos(pi * along) ** 6
    rigid = speeds[0] * across - speeds[1] * along - turning * (along**2 + across**2) / 2
    near = wall**2 * window / (circle**2 + wall**2 * window)
    psi = rigid * near + 10 * _from_rest(t) * (wall * circle) ** 2 * window
    return _planar(psi, _from_rest(t) * (0.4 * sin(2 * pi * x) * cos(pi * y) + 0.3 * y))


def _between_cylinders(plates=False):
    from sympy import cos, pi, sin

    x, y, t = symbols()
    grown, walls = _from_rest(t), (y**2 - 1) * (4 - y**2)
    pressure = grown * (0.4 * sin(pi * x + 0.4) * y)
    if plates:
        walls = walls * x * (1 - x)
        return _of_revolution(grown * walls**2 * (1 + 0.5 * x), _swing(t) * y + grown * walls * (y + x), pressure)
    swirl = _swing(t) * y * (4 - y**2) / 3 + 0.1 * grown * walls * cos(pi * x)
    return _of_revolution(0.1 * grown * walls**2 * cos(pi * x), swirl, pressure)


def _around_sphere():
    from sympy import cos, pi, sin

    x, y, t = symbols()
    sphere, tube, window, grown = (x - 1) ** 2 + y**2 - 0.16, 1 - y**2, cos(pi * (x - 1) / 2) ** 6, _from_rest(t)
    psi = 2 * grown * y**2 * (sphere * tube) ** 2 * window * (1 + 0.5 * sin(pi * x))
    swirl = _swing(t) * y * sphere / (sphere + tube * window)
    return _of_revolution(psi, swirl, grown * (0.4 * sin(pi * x + 0.4) * (1 + y**2)))


def _solvent(rate_squared):
    return SOLVENT_FRACTION * VISCOSITY


def _channel_with_circle():
    from sympy import cos, pi, sin

    x, y, t = symbols()
    wall, circle, window = y * (1 - y), (x - 0.5) ** 2 + (y - 0.5) ** 2 - 0.2**2, cos(pi * (x - 0.5)) ** 6
    psi = 20 * _from_rest(t) * (wall * circle) ** 2 * window * (1 + 0.5 * sin(2 * pi * x))
    return _planar(psi, _from_rest(t) * (0.4 * sin(2 * pi * x) * cos(pi * y) + 0.3 * y))


def _annulus(**others):
    x, y, t = symbols()
    s, grown = x**2 + y**2, _from_rest(t)
    psi = -_swing(t) / 6 * (4 * s - s**2 / 2) + 0.15 * grown * (s - 1) ** 2 * (4 - s) ** 2 * (x + 0.5 * x * y)
    return _planar(psi, 0.3 * grown * (x * y + x), **others)


def _annulus_polymer():
    from sympy import Matrix, eye

    x, y, t = symbols()
    shear = 0.15 * x * y
    stretch = Matrix([[0.5 + 0.1 * x**2, shear, 0], [shear, 0.4 + 0.1 * y, 0], [0, 0, 0]])
    return _annulus(conformation=eye(3) + _from_rest(t) * stretch, viscosity=_solvent)


def _pipe(**others):
    from sympy import cos, pi, sin

    x, y, t = symbols()
    grown = _from_rest(t)
    psi = grown * (0.3 * y**2 * (1 - y**2) ** 2 * (1 + sin(pi * x)))
    swirl = grown * y * (1 - y**2) * (1 + 0.5 * cos(pi * x))
    return _of_revolution(psi, swirl, grown * (0.4 * sin(pi * x + 0.4) * (1 + y**2)), **others)


def _pipe_polymer():
    from sympy import Matrix, cos, eye, pi, sin

    x, y, t = symbols()
    wave = pi * x
    xr, xt, rt = 0.3 * y * cos(wave), 0.2 * y * (1 + 0.5 * sin(wave)), 0.2 * y**2 * cos(wave)
    around = 0.4 + 0.2 * cos(wave)
    stretch = Matrix([[0.6 + 0.3 * sin(wave), xr, xt], [xr, around + 0.2 * y**2, rt], [xt, rt, around]])
    return _pipe(conformation=eye(3) + _from_rest(t) * stretch, viscosity=_solvent)


def _thinning(config, solution, rate, *others):
    """Return the ``Case`` of a power law in the flow of another one; about the shear ``rate`` it begins to thin."""

    def viscosity(rate_squared):
        return VISCOSITY * (1 + rate_squared / rate**2) ** ((INDEX - 1) / 2)

    law = {"type": "power_law", "index": INDEX, "reference_rate": rate, "least_rate": rate}
    fluid = {"fluid": {"rheology": law}}
    return Case(merged(config, fluid), lambda: solution(viscosity=viscosity), *others)


def _explicit_channel():
    from sympy import pi, sin

    _, y, t = symbols()
    return Solution((_from_rest(t) * sin(2 * pi * y), 0, 0), 0 * y)


def _explicit_annulus():
    """Return the flow u_theta = B(r) g(t) whose B and viscous force both vanish at r = 1 and 2, without other forces."""
    from sympy import integrate, linsolve, sqrt
    from sympy import symbols as named

    x, y, t = symbols()
    r, a, b = named("r a b", positive=True)
    profile = (r - 1) * (2 - r) * (1 + a * r + b * r**2)
    pull = profile.diff(r, 2) + profile.diff(r) / r
    ((first, second),) = linsolve([pull.subs(r, 1), pull.subs(r, 2)], a, b)
    profile = 8 * profile.subs({a: first, b: second})
    pressure = integrate((profile**2 / r).expand(), r).subs(r, sqrt(x**2 + y**2))
    swirl = (_from_rest(t) * profile / r).subs(r, sqrt(x**2 + y**2))
    return Solution((-y * swirl, x * swirl, 0), _from_rest(t) ** 2 * pressure)


CASES = {
    "square": Case(SQUARE, _square, (20, 28, 40), (1e-3, 1e-3)),
    "square_oldroyd_b": Case(merged(SQUARE, POLYMER), _square_polymer, (20, 28, 40), (1e-3, 1e-3, 1e-3)),
    "square_power_law": _thinning(SQUARE, _square, 6.0, (20, 28, 40), (1e-3, 1e-3)),
    "channel_circle": Case(
        {
            "scene": "channel",
            "geometry": {"gap": 1.0, "length": 1.0},
            "walls": {},
            "bodies": [{"type": "circle", "centre": [0.5, 0.5], "radius": 0.2, "motion": "fixed"}],
            "drive": {"acceleration": 2.0},
        },
        _channel_with_circle,
        (32, 40, 56),
        (1e-3, 1e-3),
    ),
    "annulus": Case(ANNULUS, _annulus, (12, 16, 24), (1e-3, 1e-3)),
    "annulus_oldroyd_b": Case(merged(ANNULUS, POLYMER), _annulus_polymer, (12, 16, 24), (1e-3, 1e-3, 1e-3)),
    "annulus_power_law": _thinning(ANNULUS, _annulus, 1.0, (12, 16, 24), (1e-3, 1e-3)),
    "eccentric": Case(
        {
            "scene": "eccentric_annulus",
            "geometry": {"inner_radius": 1.0, "outer_radius": 2.0, "eccentricity": 0.5},
            "walls": {"inner": SWING, "outer": {"angular_velocity": 0.0}},
        },
        _eccentric,
        (16, 20, 28),
        (1e-3, 1e-3),
    ),
    "rounded": Case(
        {
            "scene": "region",
            "walls": {"around": {"type": "curve", "points": _rounded_outline()}},
            "reference": {"velocity": 1.0},
        },
        _rounded,
        (24, 32, 44),
        (1e-3, 1e-3),
    ),
    "moving_circle": Case(
        {
            "scene": "channel",
            "geometry": {"gap": 1.0, "length": 1.0},
            "walls": {},
            "bodies": [{"type": "circle", "centre": [0.5, 0.5], "radius": 0.2, "motion": MOVING}],
        },
        _moving_circle,
        (32, 40, 56),
        (1e-3, 1e-3),
    ),
    "taylor_couette": Case(
        {
            "scene": "taylor_couette",
            "geometry": {"inner_radius": 1.0, "outer_radius": 2.0, "length": 2.0},
            "walls": {"inner": SWING, "outer": {"angular_velocity": 0.0}},
        },
        _between_cylinders,
        (12, 16, 24),
        (1e-3, 1e-3),
    ),
    "end_plates": Case(
        {
            "scene": "region",
            "coordinates": "axisymmetric",
            "walls": {"around": {"type": "polygon", "corners": [[0, 1], [1, 1], [1, 2], [0, 2]]}},
            "turning": [{"wall": "around", **SWING}],
        },
        lambda: _between_cylinders(plates=True),
        (16, 24, 32),
        (1e-3, 1e-3),
    ),
    "sphere": Case(
        {
            "scene": "region",
            "coordinates": "axisymmetric",
            "geometry": {"length": 2.0, "height": 1.0},
            "bodies": [{"type": "circle", "centre": [1.0, 0.0], "radius": 0.4, "motion": "fixed"}],
            "turning": [{"wall": "top", **SWING}],
        },
        _around_sphere,
        (20, 28, 40),
        (1e-3, 1e-3),
    ),
    "pipe": Case(PIPE, _pipe, (16, 24, 32), (1e-3, 1e-3)),
    "pipe_oldroyd_b": Case(merged(PIPE, POLYMER), _pipe_polymer, (16, 24, 32), (1e-3, 1e-3, 1e-3)),
    "pipe_power_law": _thinning(PIPE, _pipe, 0.7, (16, 24, 32), (1e-3, 1e-3)),
}

for _name in ("fixed_image", "virtual_image", "comoving_image", "consistent_image", "adami"):
    _treatment = {"walls": {"treatment": {"type": _name}}}
    _flow = {"scene": "channel", "geometry": {"gap": 1.0, "length": 0.5}}
    CASES[f"wcsph_channel_{_name}"] = Case(
        merged(_flow, _treatment, EXPLICIT), _explicit_channel, (20, 30, 40), (1e-2,), (1.5,)
    )
    if _name in AROUND_BODIES:
        CASES[f"wcsph_annulus_{_name}"] = Case(
            merged(ANNULUS, {"walls": {"inner": {"angular_velocity": 0.0}, **_treatment["walls"]}}, EXPLICIT),
            _explicit_annulus,
            (12, 16, 24),
            (1e-2,),
            (1.5,),
        )

QUICK = ("square", "channel_circle", "annulus_oldroyd_b", "pipe")
"""Cases whose two coarser runs stand for all."""


def runs(quick: bool) -> dict[str, Callable]:
    """Return functions that run the cases, by the name of the run."""
    return {
        run: partial(CASES[name].run, number) for name in _chosen(quick) for run, number in _named(name, quick).items()
    }


def criteria(quick: bool) -> list:
    """Return the bounds that the runs are held to, in the order of the table."""
    symbols()
    return [criterion for name in _chosen(quick) for criterion in _bounds(name, quick)]


def _chosen(quick):
    return QUICK if quick else tuple(CASES)


def _named(name, quick):
    """Return numbers of particles across by the names of the runs of a case."""
    return {f"{name}_{number}": number for number in CASES[name].resolutions[: 2 if quick else 3]}


def _bounds(name, quick):
    case, named = CASES[name], _named(name, quick)
    quantities = ("l2", "l2_pressure", "l2_stress")
    for quantity, bound, least in zip(quantities, case.bounds, case.orders, strict=False):
        if not quick:
            yield at_most(list(named)[-1], case.end, quantity, bound)
        yield order(name, named, case.end, least, quantity)
