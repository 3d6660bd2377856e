"""Manufactured solutions: flows that are chosen, and driven by the forces that the equations then ask for.

Chosen are a velocity u without divergence that obeys no slip, from a stream function psi, a pressure p per unit
density, and for polymers a conformation tensor A. sympy derives the body force f and the source Q of the conformation,

    f = Du/Dt + grad p - div T,    T = 2 nu D + S,    D = (L + L^T)/2,    L = grad u,
    Q = DA/Dt - L A - A L^T + (A - 1)/lambda,    S = nu_p/lambda (A - 1) of an Oldroyd-B fluid,

with nu = nu(2 D:D) of a power law. Axisymmetric tensors have the components along x, along r and around the axis, and
derivatives along paths turn with the axes. Flows start from rest and grow with time. They run through the public
interface, ``tisph.Simulation(config, body_force=..., conformation_source=...)``. Source of the method: P. J. Roache, J.
Fluids Eng. 124 (2002) 4-10.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from tisph import scenes
from tisph.errors import ConfigError, TisphError
from tisph.schemes._supported import AROUND_BODIES
from tisph.snapshot import STRESSES, STRESSES_AROUND
from tisph.studies import checks
from tisph.studies.checks import Criterion
from tisph.studies.flows import merged
from tisph.studies.processes import Result

DENSITY, VISCOSITY, INDEX = 2.0, 0.05, 0.6
RELAXATION_TIME, SOLVENT_FRACTION = 0.5, 0.4
MODULUS = (1 - SOLVENT_FRACTION) * VISCOSITY / RELAXATION_TIME


def sympy() -> Any:
    """Return the module; ConfigError where it is not installed."""
    try:
        import sympy as module
    except ImportError:
        raise ConfigError("verify manufactured: sympy is missing, which pip install 'tisph[test]' brings") from None
    return module


def symbols() -> tuple[Any, Any, Any]:
    """Return the symbols x, y (the radius r in axisymmetric flow) and t."""
    return sympy().symbols("x y t", real=True)


@dataclass(frozen=True)
class Solution:
    """Expressions of x, y and t: ``velocity`` (u, v, w), ``pressure`` per unit density, 3 x 3 ``conformation`` or None.

    ``viscosity``: nu as an expression of 2 D:D, of the solvent where there is a polymer. ``centre``: expression of t;
    expressions hold for the periodic copy of a place that is nearest to it along x, in a period of 1.
    """

    velocity: tuple
    pressure: Any
    conformation: Any = None
    axisymmetric: bool = False
    viscosity: Callable = lambda rate_squared: VISCOSITY
    centre: Any = None

    def fields(self) -> dict[str, Callable]:
        """Return functions of arrays x, y and a time: ``velocity``, ``pressure``, ``stress``, ``force``, ``source``."""
        sp, (x, y, t) = sympy(), symbols()
        u, found = sp.Matrix(self.velocity), {}
        gradient, turn = self._gradient(u)
        strain = (gradient + gradient.T) / 2
        stress = 2 * self.viscosity(2 * (strain * strain).trace()) * strain

        def along_path(field):
            return field.diff(t) + u[0] * field.diff(x) + u[1] * field.diff(y)

        if self.conformation is not None:
            A, excess = self.conformation, self.conformation - sp.eye(3)
            stress += MODULUS * excess
            found["source"] = along_path(A) + turn * A + A * turn.T - gradient * A - A * gradient.T
            found["source"] += excess / RELAXATION_TIME
            found["stress"] = DENSITY * MODULUS * excess
        push = sp.Matrix([self.pressure.diff(x), self.pressure.diff(y), 0])
        found["force"] = along_path(u) + turn * u + push - self._divergence(stress)
        found |= {"velocity": u, "pressure": sp.Matrix([DENSITY * self.pressure])}
        return {name: self._function(field) for name, field in found.items()}

    def _gradient(self, u):
        """Return du_a/dx_b, and the angular velocity w/r of the axes along a path, as matrices."""
        sp, (x, y, _) = sympy(), symbols()
        gradient, turn = sp.zeros(3, 3), sp.zeros(3, 3)
        gradient[:, 0], gradient[:, 1] = u.diff(x), u.diff(y)
        if self.axisymmetric:
            gradient[:, 2] = sp.Matrix([0, -u[2] / y, u[1] / y])
            turn[1, 2], turn[2, 1] = -u[2] / y, u[2] / y
        return gradient, turn

    def _divergence(self, T):
        sp, (x, y, _) = sympy(), symbols()
        force = sp.Matrix([T[a, 0].diff(x) + T[a, 1].diff(y) for a in range(3)])
        if self.axisymmetric:
            force += sp.Matrix([T[0, 1], T[1, 1] - T[2, 2], 2 * T[1, 2]]) / y
        return force

    def _function(self, field):
        """Return a function of x, y, t with the components of a vector, or of a tensor as snapshots order them."""
        if field.shape == (3, 3):
            places = ((0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2))[: 6 if self.axisymmetric else 3]
            field = [field[place] for place in places]
        elif field.shape == (3, 1):
            field = list(field)[: 3 if self.axisymmetric else 2]
        function = sympy().lambdify(symbols(), list(field), modules="numpy", cse=True)
        if self.centre is None:
            return function
        left = sympy().lambdify(symbols()[2], self.centre - 0.5)
        return lambda x, y, t: function(left(t) + (x - left(t)) % 1.0, y, t)


@dataclass(frozen=True)
class Case:
    """A flow: its config without resolution and times, a function that makes its ``Solution``, and three resolutions.

    ``bounds``: relative L2 errors of velocity and pressure, and of the stress of a polymer, at the finest resolution;
    ``orders``: least powers of the spacing with which they fall. ``uniform``: acceleration along x that the config, or
    what keeps a mean velocity, adds to the body force. With ``beside_reference`` the velocity comes on top of the one
    that the scene has as a reference: the equations of parallel flow are linear.
    """

    config: dict
    solution: Callable[[], Solution]
    resolutions: tuple[int, ...]
    bounds: tuple[float, ...]
    orders: tuple[float, ...] = (3.5, 2.5, 2.5)
    uniform: float = 0.0
    beside_reference: bool = False
    end: float = 0.5

    def run(self, number: int) -> tuple[Result, str]:
        """Return the errors of a run with ``number`` particles across as a ``Result``, and a message if it failed."""
        from tisph.simulation.simulation import Simulation  # which starts Taichi

        fields = _fields(self.solution)

        def force(x, y, t):
            along, *others = fields["force"](x, y, t)
            return along - self.uniform, *others

        given = {"body_force": force, "conformation_source": fields.get("source")}
        if self.config["scene"] == "shear_layer":  # which starts with streams of its own
            given["initial_velocity"] = lambda x, y, t: (0.0, 0.0)
        times = {"time": {"end": self.end, "samples": [self.end]}, "discretisation": {"particles_across": number}}
        config = merged(SHARED, self.config, times)
        try:
            with Simulation(config, **given) as simulation:
                snapshot = simulation.run_until(self.end).snapshot
                reference = scenes.of(simulation.config) if self.beside_reference else None
                sample = {"t_star": self.end, "step": simulation.steps, **_errors(snapshot, fields, reference)}
        except TisphError as error:
            return Result(Path(), {"status": "failed", "samples": []}), str(error)
        return Result(Path(), {"status": "done", "samples": [sample]}), ""


@cache
def _fields(solution):
    return solution().fields()


def _errors(snapshot, fields, reference=None):
    """Return relative L2 errors: ``l2`` of the velocity, ``l2_pressure`` and ``l2_stress`` where they are not 0."""
    x, y, t = snapshot.x.astype(float), snapshot.y.astype(float), snapshot.t

    def off(names, exact):
        values = np.array([getattr(snapshot, name) for name in names], dtype=float)
        exact = np.array([np.broadcast_to(each, x.shape) for each in exact(x, y, t)])
        if reference:
            exact = exact + [reference.exact(name, x, y, t) for name in names]
        if names == ["pressure"]:  # known but for a constant
            values, exact = values - values.mean(), exact - exact.mean()
        return float(np.linalg.norm(values - exact) / np.linalg.norm(exact))

    swirls = snapshot.w is not None
    found = {"l2": off("uvw" if swirls else "uv", fields["velocity"])}
    if np.ptp(fields["pressure"](x, y, t)[0]):
        found["l2_pressure"] = off(["pressure"], fields["pressure"])
    if "stress" in fields:
        found["l2_stress"] = off([*STRESSES, *(STRESSES_AROUND if swirls else ())], fields["stress"])
    return found


SHARED = {
    "fluid": {"density": DENSITY, "kinematic_viscosity": VISCOSITY},
    "initial": {"jitter": 0.2, "seed": 0},
    "time": {"tolerance": 1e-7},
}
OLDROYD_B = {"type": "oldroyd_b", "relaxation_time": RELAXATION_TIME, "solvent_fraction": SOLVENT_FRACTION}
POLYMER = {"fluid": {"rheology": OLDROYD_B}}
DRIVEN = {"reference": {"velocity": 1.0}}
EXPLICIT = merged(DRIVEN, {"scheme": {"type": "wcsph"}, "time": {"tolerance": "auto"}})
NEARLY_INCOMPRESSIBLE = merged(EXPLICIT, {"scheme": {"equation_of_state": {"type": "tait", "sound_speed": 50.0}}})
SWING = {"amplitude": 0.8, "angular_frequency": 2.0, "phase": "sin"}
MOVING = {"amplitude": [0.3, 0.1], "angular_amplitude": 0.6, "angular_frequency": 3.0, "phase": "sin"}

SQUARE = {"scene": "shear_layer", "geometry": {"length": 1.0}, "initial": {"velocity": 1.0, "thickness": 0.04}}
RADII = {"inner_radius": 1.0, "outer_radius": 2.0}
TURNED = {"geometry": RADII, "walls": {"inner": SWING, "outer": {"angular_velocity": 0.0}}}
ANNULUS = {"scene": "annulus", **TURNED}
PIPE = {"scene": "pipe", "geometry": {"radius": 1.0, "length": 2.0}, "walls": {}, "drive": {"acceleration": 0.4}}
CHANNEL = {"scene": "channel", "geometry": {"gap": 1.0, "length": 1.0}, "walls": {}}
SPHERE = {"tube_radius": 1.0, "sphere_radius": 0.4, "length": 2.0}
RING = {"type": "polygon", "corners": [[0, 1], [1, 1], [1, 2], [0, 2]]}


def _circle(motion):
    return {"bodies": [{"type": "circle", "centre": [0.5, 0.5], "radius": 0.2, "motion": motion}]}


def _from_rest(t):
    return sympy().sin(2 * t) ** 2


def _swing(t):
    return SWING["amplitude"] * sympy().sin(SWING["angular_frequency"] * t)


def _planar(psi, pressure, **others):
    x, y, _ = symbols()
    return Solution((psi.diff(y), -psi.diff(x), 0), pressure, **others)


def _of_revolution(psi, swirl, pressure, **others):
    x, y, _ = symbols()
    return Solution((psi.diff(y) / y, -psi.diff(x) / y, swirl), pressure, axisymmetric=True, **others)


def _polymer(flow, rows):
    """Return the solution of a polymer in a ``flow``, whose A - 1 has the rows xx, xy, xz; yy, yz; zz."""
    sp, (_, _, t) = sympy(), symbols()
    (xx, xy, xz), (yy, yz), (zz,) = rows
    excess = _from_rest(t) * sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return flow(conformation=sp.eye(3) + excess, viscosity=lambda rate_squared: SOLVENT_FRACTION * VISCOSITY)


def _thinning(config, flow, rate, *others):
    """Return the ``Case`` of a power law, which begins to thin at the shear ``rate``, in the same ``flow``."""

    def viscosity(rate_squared):
        return VISCOSITY * (1 + rate_squared / rate**2) ** ((INDEX - 1) / 2)

    law = {"type": "power_law", "index": INDEX, "reference_rate": rate, "least_rate": rate}
    return Case(merged(config, {"fluid": {"rheology": law}}), lambda: flow(viscosity=viscosity), *others)


def _square(**others):
    sp, (x, y, t) = sympy(), symbols()
    a, b, grown = 2 * sp.pi * x, 2 * sp.pi * y, _from_rest(t)
    psi = grown * (sp.sin(a) * sp.sin(b) + 0.4 * sp.cos(a - b)) / (2 * sp.pi)
    return _planar(psi, 0.5 * grown * sp.cos(a) * sp.sin(b + 0.3), **others)


def _square_polymer():
    sp, (x, y, _) = sympy(), symbols()
    a, b = 2 * sp.pi * x, 2 * sp.pi * y
    rows = (0.8 + 0.4 * sp.sin(a), 0.3 * sp.cos(a) * sp.sin(b), 0), (0.5 + 0.3 * sp.cos(a + b), 0), (0,)
    return _polymer(_square, rows)


def _channel():
    """Return the flow around a circle at rest; the window makes polynomials periodic."""
    sp, (x, y, t) = sympy(), symbols()
    wall, circle, window = y * (1 - y), (x - 0.5) ** 2 + (y - 0.5) ** 2 - 0.04, sp.cos(sp.pi * (x - 0.5)) ** 6
    psi = 20 * _from_rest(t) * (wall * circle) ** 2 * window * (1 + 0.5 * sp.sin(2 * sp.pi * x))
    return _planar(psi, _from_rest(t) * (0.4 * sp.sin(2 * sp.pi * x) * sp.cos(sp.pi * y) + 0.3 * y))


def _moving_circle():
    """Return a flow that is a rigid motion at the circle, blended with rest at the walls."""
    sp, (x, y, t) = sympy(), symbols()
    rate, starts = MOVING["angular_frequency"], 1 - sp.cos(MOVING["angular_frequency"] * t)
    (u, v), turning = MOVING["amplitude"], MOVING["angular_amplitude"]
    along, across = x - 0.5 - u * starts / rate, y - 0.5 - v * starts / rate
    wall, circle, window = y * (1 - y), along**2 + across**2 - 0.04, sp.cos(sp.pi * along) ** 6
    rigid = (u * across - v * along - turning * (along**2 + across**2) / 2) * sp.sin(rate * t)
    near = wall**2 * window / (circle**2 + wall**2 * window)
    psi = rigid * near + 10 * _from_rest(t) * (wall * circle) ** 2 * window
    pressure = _from_rest(t) * (0.4 * sp.sin(2 * sp.pi * x) * sp.cos(sp.pi * y) + 0.3 * y)
    return _planar(psi, pressure, centre=x - along)


def _annulus(**others):
    x, y, t = symbols()
    s, grown = x**2 + y**2, _from_rest(t)
    psi = -_swing(t) / 6 * (4 * s - s**2 / 2) + 0.04 * grown * (s - 1) ** 2 * (4 - s) ** 2 * (x + 0.5 * x * y)
    return _planar(psi, 0.3 * grown * (x * y + x), **others)


def _annulus_polymer():
    x, y, _ = symbols()
    return _polymer(_annulus, ((0.5 + 0.1 * x**2, 0.15 * x * y, 0), (0.4 + 0.1 * y, 0), (0,)))


def _parallel_annulus():
    """Return u_theta = B(r) g(t): B and the viscous force vanish at r = 1 and 2, the pressure balances u_theta^2/r."""
    sp, (x, y, t) = sympy(), symbols()
    r, a, b = sp.symbols("r a b")
    profile = (r - 1) * (2 - r) * (1 + a * r + b * r**2)
    pull = profile.diff(r, 2) + profile.diff(r) / r
    ((first, second),) = sp.linsolve([pull.subs(r, 1), pull.subs(r, 2)], a, b)
    profile = profile.subs({a: first, b: second})
    pressure = sp.integrate((profile**2 / r).expand(), r)
    swirl, pressure = (each.subs(r, sp.sqrt(x**2 + y**2)) for each in (_from_rest(t) * profile / r, pressure))
    return Solution((-y * swirl, x * swirl, 0), _from_rest(t) ** 2 * pressure)


def _parallel_channel():
    sp, (_, y, t) = sympy(), symbols()
    return Solution((_from_rest(t) * sp.sin(2 * sp.pi * y), 0, 0), 0 * y)


def _eccentric():
    x, y, t = symbols()
    inner, outer, grown = (x - 0.5) ** 2 + y**2 - 1, 4 - x**2 - y**2, _from_rest(t)
    turning = -_swing(t) / 2 * (inner + 1) * outer**2 / (inner**2 + outer**2)
    return _planar(turning + 0.05 * grown * (inner * outer) ** 2 * (1 + 0.5 * y), 0.3 * grown * (x * y + x))


def _rounded():
    x, y, t = symbols()
    psi = 0.5 * _from_rest(t) * (1 - (x**2 + y**2 + x**4 + y**4) / 2) ** 2 * (1 + 0.3 * x + 0.4 * y)
    return _planar(psi, 0.3 * _from_rest(t) * (x * y + x))


def _rounded_outline(points=120):
    """Return points of x^2 + y^2 + x^4 + y^4 = 2; the spline of fifth degree through them is off it by 1e-8."""
    angle = np.arange(points) * 2.0 * np.pi / points
    fourth = np.cos(angle) ** 4 + np.sin(angle) ** 4
    radius = np.sqrt((np.sqrt(1.0 + 8.0 * fourth) - 1.0) / (2.0 * fourth))
    return (radius * [np.cos(angle), np.sin(angle)]).T.tolist()


def _pipe(**others):
    sp, (x, y, t) = sympy(), symbols()
    wave, grown = sp.pi * x, _from_rest(t)
    swirl = grown * y * (1 - y**2) * (1 + 0.5 * sp.cos(wave))
    psi = 0.3 * grown * y**2 * (1 - y**2) ** 2 * (1 + sp.sin(wave))
    return _of_revolution(psi, swirl, 0.4 * grown * sp.sin(wave + 0.4) * (1 + y**2), **others)


def _pipe_polymer():
    sp, (x, y, _) = sympy(), symbols()
    wave = sp.pi * x
    around = 0.4 + 0.2 * sp.cos(wave)
    shear = 0.3 * y * sp.cos(wave), 0.2 * y * (1 + 0.5 * sp.sin(wave))
    return _polymer(
        _pipe, ((0.6 + 0.3 * sp.sin(wave), *shear), (around + 0.2 * y**2, 0.2 * y**2 * sp.cos(wave)), (around,))
    )


def _between_cylinders():
    sp, (x, y, t) = sympy(), symbols()
    grown, walls = _from_rest(t), (y**2 - 1) * (4 - y**2)
    swirl = _swing(t) * y * (4 - y**2) / 3 + 0.1 * grown * walls * sp.cos(sp.pi * x)
    return _of_revolution(0.1 * grown * walls**2 * sp.cos(sp.pi * x), swirl, 0.4 * grown * sp.sin(sp.pi * x + 0.4) * y)


def _end_plates():
    sp, (x, y, t) = sympy(), symbols()
    grown, walls = _from_rest(t), (y**2 - 1) * (4 - y**2) * x * (1 - x)
    swirl = _swing(t) * y + grown * walls * (y + x)
    return _of_revolution(grown * walls**2 * (1 + 0.5 * x), swirl, 0.4 * grown * sp.sin(sp.pi * x + 0.4) * y)


def _sphere(swing=True):
    sp, (x, y, t) = sympy(), symbols()
    sphere, tube, window = (x - 1) ** 2 + y**2 - 0.16, 1 - y**2, sp.cos(sp.pi * (x - 1) / 2) ** 6
    psi = 2 * _from_rest(t) * y**2 * (sphere * tube) ** 2 * window * (1 + 0.5 * sp.sin(sp.pi * x))
    swirl = _swing(t) * y * sphere / (sphere + tube * window) if swing else psi / y
    return _of_revolution(psi, swirl, 0.4 * _from_rest(t) * sp.sin(sp.pi * x + 0.4) * (1 + y**2))


BODY_ON_AXIS = {
    "scene": "region",
    "coordinates": "axisymmetric",
    "geometry": {"length": 2.0, "height": 1.0},
    "bodies": [{"type": "circle", "centre": [1.0, 0.0], "radius": 0.4, "motion": "fixed"}],
    "turning": [{"wall": "top", **SWING}],
}
KEPT = {"scene": "sphere_in_tube", "geometry": SPHERE, "sphere": {"velocity": 0.0}, "closure": "no_flux"}
TAYLOR_COUETTE = merged({"scene": "taylor_couette"}, TURNED, {"geometry": {"length": 2.0}})
END_PLATES = {"scene": "region", "coordinates": "axisymmetric", "walls": {"around": RING}}
ROUNDED = {"scene": "region", "walls": {"around": {"type": "curve", "points": _rounded_outline()}}}
ECCENTRIC = {"scene": "eccentric_annulus", **merged(TURNED, {"geometry": {"eccentricity": 0.5}})}
STARTED = {"walls": {"inner": {"angular_velocity": 0.8}, "outer": {"angular_velocity": 0.0}}}
AT_REST = {"walls": {"inner": {"angular_velocity": 0.0}, "outer": {"angular_velocity": 0.0}}}

CASES = {
    "square": Case(SQUARE, _square, (20, 28, 40), (3e-5, 2e-4)),
    "square_oldroyd_b": Case(merged(SQUARE, POLYMER), _square_polymer, (20, 28, 40), (3e-5, 2e-4, 5e-4)),
    "square_power_law": _thinning(SQUARE, _square, 6.0, (20, 28, 40), (1e-4, 1e-3)),
    "channel": Case(
        merged(CHANNEL, _circle("fixed"), {"drive": {"acceleration": 2.0}}),
        _channel,
        (32, 40, 56),
        (5e-4, 2e-5),
        uniform=2.0,
    ),
    "moving_circle": Case(merged(CHANNEL, _circle(MOVING)), _moving_circle, (32, 40, 56), (3e-3, 5e-3)),
    "annulus": Case(ANNULUS, _annulus, (16, 20, 28), (1e-4, 2e-3)),
    "annulus_oldroyd_b": Case(merged(ANNULUS, POLYMER), _annulus_polymer, (16, 24, 28), (1e-4, 1e-3, 5e-4)),
    "annulus_power_law": _thinning(ANNULUS, _annulus, 4.0, (16, 20, 28), (5e-4, 5e-3)),
    "annulus_started": Case(
        {"scene": "annulus", "geometry": RADII, **STARTED},
        _parallel_annulus,
        (16, 20, 28),
        (2e-5,),
        (3.0,),
        beside_reference=True,
    ),
    "eccentric": Case(ECCENTRIC, _eccentric, (20, 28, 36), (3e-4, 1e-2)),
    "rounded": Case(merged(ROUNDED, DRIVEN), _rounded, (36, 48, 60), (1e-4, 1e-3)),
    "pipe": Case(PIPE, _pipe, (20, 28, 40), (1e-5, 1e-5), uniform=0.4),
    "pipe_oldroyd_b": Case(merged(PIPE, POLYMER), _pipe_polymer, (16, 24, 32), (2e-5, 3e-5, 3e-5), uniform=0.4),
    "pipe_power_law": _thinning(PIPE, _pipe, 0.7, (20, 28, 40), (2e-5, 2e-5), (3.5, 2.5), 0.4),
    "taylor_couette": Case(TAYLOR_COUETTE, _between_cylinders, (16, 20, 28), (5e-5, 2e-4)),
    "end_plates": Case(
        merged(END_PLATES, {"turning": [{"wall": "around", **SWING}]}), _end_plates, (16, 24, 32), (2e-5, 4e-4)
    ),
    "sphere": Case(BODY_ON_AXIS, _sphere, (20, 28, 40), (5e-5, 1e-4)),
    "sphere_no_flux": Case(
        merged(KEPT, DRIVEN), lambda: _sphere(swing=False), (20, 28, 40), (3e-4, 1e-4), uniform=-0.7
    ),
}
for _name in ("fixed_image", "virtual_image", "comoving_image", "consistent_image", "adami"):
    _config = merged(CHANNEL, {"walls": {"treatment": {"type": _name}}}, EXPLICIT)
    CASES[f"wcsph_channel_{_name}"] = Case(_config, _parallel_channel, (20, 30, 40), (2e-3,), (1.5,))
    if _name in AROUND_BODIES:
        _config = merged(
            {"scene": "annulus", "geometry": RADII}, AT_REST, {"walls": _config["walls"]}, NEARLY_INCOMPRESSIBLE
        )
        _least = 1.2 if _name == "adami" else 1.5  # whose averages sit at another depth than the wall's mirror points
        CASES[f"wcsph_annulus_{_name}"] = Case(_config, _parallel_annulus, (12, 16, 24), (2e-3,), (_least,))
"""Flows by name. Bounds are one to two times the errors that runs had; scheme ``wcsph`` is of the second order."""

QUICK = ("square", "channel", "annulus_oldroyd_b", "pipe", "wcsph_channel_consistent_image")
"""Cases whose two coarser runs stand for all."""


def runs(quick: bool) -> dict[str, Callable]:
    """Return functions that run the cases, by the name of the run."""
    return {
        run: partial(CASES[name].run, number)
        for name in (QUICK if quick else CASES)
        for run, number in _named(name, quick).items()
    }


def criteria(quick: bool) -> list[Criterion]:
    """Return the bounds that the runs are held to, in the order of the table; ConfigError without sympy."""
    sympy()
    return [criterion for name in (QUICK if quick else CASES) for criterion in bounds(name, quick)]


def bounds(name: str, quick: bool) -> Iterator[Criterion]:
    """Yield the bounds of one case."""
    case, named = CASES[name], _named(name, quick)
    for quantity, bound, least in zip(("l2", "l2_pressure", "l2_stress"), case.bounds, case.orders, strict=False):
        if not quick:
            yield from checks.criteria(
                {"run": list(named)[-1], "t_star": case.end, "at_most": {quantity: bound}}, {*named}
            )
        order = {"order": quantity, "case": name, "runs": named, "t_star": case.end, "at_least": least}
        yield from checks.criteria(order, {*named})


def _named(name, quick):
    """Return numbers of particles across by the names of the runs of a case."""
    return {f"{name}_{number}": number for number in CASES[name].resolutions[: 2 if quick else 3]}
