"""Manufactured solutions: chosen flows, driven by the body force that makes them solve the equations.

``suites/manufactured.yaml`` chooses a velocity u without divergence that obeys no slip, from a stream function psi, a
pressure p per unit density, for polymers a conformation tensor A, and for heated fluids a temperature T. sympy derives
the body force f, the source Q of the conformation and the source H of the temperature,

    f = Du/Dt + grad p - div S - b,    S = 2 nu D + S_p,    D = (L + L^T)/2,    L = grad u,
    Q = DA/Dt - L A - A L^T + (A - 1)/lambda,    S_p = nu_p/lambda (A - 1) of an Oldroyd-B fluid,
    H = DT/Dt - k/(rho c) lap T - 2 nu D:D/c,    b = -beta (T - T_0) g,

with nu = a(T) nu_0(a(T)^2 2 D:D) of a power law, a(T) being the factor of the viscosity. Axisymmetric tensors have the
components along x, along r and around the axis, and derivatives along paths turn with the axes. Flows start from rest
and grow with time. They run through the public interface, ``tisph.Simulation(config, body_force=...,
conformation_source=...)``; H and the conditions of T at walls are formulas in the config. Source of the method: P. J.
Roache, J. Fluids Eng. 124 (2002) 4-10.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from tisph import scenes
from tisph.config.loader import loaded
from tisph.errors import ConfigError, TisphError
from tisph.geometry.wanted_spacing import GROWTH
from tisph.measures.metrics import relative_difference
from tisph.scenes._scene import Scene
from tisph.snapshot import STRESSES, STRESSES_AROUND, Snapshot
from tisph.studies import checks, suites
from tisph.studies.checks import Criterion
from tisph.studies.expressions import merged
from tisph.studies.processes import Result

DATA = suites.study("manufactured")
CASES, QUICK, END = DATA["cases"], DATA["quick"], DATA["end"]

FLUID = merged(*(DATA["configs"][name]["fluid"] for name in ("all", "polymer")))
DENSITY, RELAXATION_TIME = FLUID["density"], FLUID["rheology"]["relaxation_time"]
MODULUS = (1 - FLUID["rheology"]["solvent_fraction"]) * FLUID["kinematic_viscosity"] / RELAXATION_TIME
HEAT = DATA["configs"]["heated"]["temperature"]
DIFFUSIVITY = HEAT["conductivity"] / (DENSITY * HEAT["heat_capacity"])


def sympy() -> Any:
    """Return the module; ConfigError where it is not installed."""
    try:
        import sympy as module
    except ImportError:
        raise ConfigError("verify manufactured: sympy is missing, which pip install 'tisph[test]' brings") from None
    return module


class Solution:
    """A chosen flow of a case: ``velocity`` (u, v, w), and its ``fields``.

    It is ``axisymmetric`` where its expressions have a velocity around the axis.
    """

    def __init__(self, case: str):
        sp = sympy()
        self.symbols = sp.symbols("x y t", real=True)
        x, y, _ = self.symbols
        self.expressions = dict(zip("xyt", self.symbols, strict=True)) | {"D2": sp.Symbol("D2")}
        for part in ("all", *CASES[case]["solution"]):
            for name, text in DATA["solutions"][part].items():
                self.expressions[name] = sp.sympify(str(text), locals=self.expressions)
        found = self.expressions
        self.axisymmetric = "swirl" in found
        if self.axisymmetric:
            self.velocity = found["psi"].diff(y) / y, -found["psi"].diff(x) / y, found["swirl"]
        elif "psi" in found:
            self.velocity = found["psi"].diff(y), -found["psi"].diff(x), 0
        else:
            self.velocity = found["u"], found["v"], 0
        if "temperature" in found:
            found["heat_source"] = self._heat_source(found["temperature"])

    def _heat_source(self, T: Any) -> Any:
        """Return the source H of a temperature, an expression that is finite on the axis."""
        sp, (x, y, t) = sympy(), self.symbols
        u, around = [sp.expand(each) for each in self.velocity], T.diff(y) / y if self.axisymmetric else 0
        strain = self._strain(sp.Matrix(u)).applyfunc(sp.expand)
        power = (self._viscosity(strain) * 2 * strain * strain).trace()
        conduction = DIFFUSIVITY * sp.expand(T.diff(x, 2) + T.diff(y, 2) + around)
        return T.diff(t) + u[0] * T.diff(x) + u[1] * T.diff(y) - conduction - power / HEAT["heat_capacity"]

    def _strain(self, u: Any) -> Any:
        """Return the rate of strain D (3, 3) of a velocity."""
        gradient, _ = self._gradient(u)
        return (gradient + gradient.T) / 2

    def _viscosity(self, strain: Any) -> Any:
        """Return the viscosity at a rate of strain D (3, 3) and the temperature."""
        factor = sympy().exp(-HEAT["viscosity"]["coefficient"] * self._warmth)
        return factor * self.expressions["viscosity"].subs("D2", 2 * factor**2 * (strain * strain).trace())

    @property
    def _warmth(self) -> Any:
        """Temperature above the reference; 0 without a temperature."""
        return self.expressions.get("temperature", HEAT["reference"]) - HEAT["reference"]

    def formulas(self, section: dict[str, Any]) -> dict[str, Any]:
        """Return a ``section`` of a config with the formulas of expressions in place of their names."""
        found = dict(section)
        for key, value in section.items():
            if isinstance(value, dict):
                found[key] = self.formulas(value)
            elif isinstance(value, str) and value in self.expressions:
                found[key] = str(self.expressions[value])
        return found

    def fields(self) -> dict[str, Callable]:
        """Return functions of x, y and a time by name: velocity, pressure, temperature, stress, force and source."""
        sp, (x, y, t) = sympy(), self.symbols
        u, pressure, found = sp.Matrix(self.velocity), self.expressions["pressure"], {}
        gradient, turn = self._gradient(u)
        strain = self._strain(u)
        stress = 2 * self._viscosity(strain) * strain

        def along_path(field: Any) -> Any:
            return field.diff(t) + u[0] * field.diff(x) + u[1] * field.diff(y)

        if "xx" in self.expressions:
            xx, xy, xz, yy, yz, zz = (self.expressions.get(name, 0) for name in ("xx", "xy", "xz", "yy", "yz", "zz"))
            A = sp.eye(3) + self.expressions["grown"] * sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            excess = A - sp.eye(3)
            stress += MODULUS * excess
            found["source"] = along_path(A) + turn * A + A * turn.T - gradient * A - A * gradient.T
            found["source"] += excess / RELAXATION_TIME
            found["stress"] = DENSITY * MODULUS * excess
        push = sp.Matrix([pressure.diff(x), pressure.diff(y), 0])
        found["force"] = along_path(u) + turn * u + push - self._divergence(stress)
        found["force"] += HEAT["expansion"] * self._warmth * sp.Matrix([*HEAT["gravity"], 0])
        if "temperature" in self.expressions:
            found["temperature"] = sp.Matrix([self.expressions["temperature"]])
        found |= {"velocity": u, "pressure": sp.Matrix([DENSITY * pressure])}
        return {name: self._function(field) for name, field in found.items()}

    def _gradient(self, u: Any) -> tuple[Any, Any]:
        """Return du_a/dx_b, and the angular velocity w/r of the axes along a path, as matrices."""
        sp, (x, y, _) = sympy(), self.symbols
        gradient, turn = sp.zeros(3, 3), sp.zeros(3, 3)
        gradient[:, 0], gradient[:, 1] = u.diff(x), u.diff(y)
        if self.axisymmetric:
            gradient[:, 2] = sp.Matrix([0, -u[2] / y, u[1] / y])
            turn[1, 2], turn[2, 1] = -u[2] / y, u[2] / y
        return gradient, turn

    def _divergence(self, T: Any) -> Any:
        sp, (x, y, _) = sympy(), self.symbols
        force = sp.Matrix([T[a, 0].diff(x) + T[a, 1].diff(y) for a in range(3)])
        if self.axisymmetric:
            force += sp.Matrix([T[0, 1], T[1, 1] - T[2, 2], 2 * T[1, 2]]) / y
        return force

    def _function(self, field: Any) -> Callable:
        """Return a function of x, y, t with the components of a vector, or of a tensor as snapshots order them."""
        if field.shape == (3, 3):
            places = ((0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2))[: 6 if self.axisymmetric else 3]
            field = [field[place] for place in places]
        elif field.shape == (3, 1):
            field = list(field)[: 3 if self.axisymmetric else 2]
        function = sympy().lambdify(self.symbols, list(field), modules="numpy", cse=True)
        if "centre" not in self.expressions:
            return function
        left = sympy().lambdify(self.symbols[2], self.expressions["centre"] - 0.5)
        return lambda x, y, t: function(left(t) + (x - left(t)) % 1.0, y, t)


def config_of(case: str, number: int, balanced: bool = False) -> dict[str, Any]:
    """Return the config of a case with ``number`` particles across; ``balanced``: with the steps of scheme auto."""
    own: dict[str, Any] = {"discretisation": {"particles_across": number}, "time": {"end": END, "samples": [END]}}
    if balanced:
        own["time"] |= {"tolerance": "auto", "cfl": "auto"}
    config = merged(*(DATA["configs"][name] for name in ("all", *CASES[case]["config"])), own)
    if "temperature" in config:
        config["temperature"] = _solution(case).formulas(config["temperature"])
    if case == "rounded":
        config["walls"]["around"]["points"] = _rounded_outline()
    if "refine" in CASES[case]:
        spacing = loaded(config, {}).spacing
        refined = [{**place, "spacing": place["spacing"] * spacing} for place in CASES[case]["refine"]]
        # in proportion to the spacing: the spacing of every place then falls as the number across grows
        growth = GROWTH * CASES[case]["across"][0] / number
        config["discretisation"] |= {"refine": refined, "growth": growth}
    return config


def _rounded_outline(points: int = 120) -> list[list[float]]:
    """Return points of x^2 + y^2 + x^4 + y^4 = 2; the spline of fifth degree through them is off it by 1e-8."""
    angle = np.arange(points) * 2.0 * np.pi / points
    fourth = np.cos(angle) ** 4 + np.sin(angle) ** 4
    radius = np.sqrt((np.sqrt(1.0 + 8.0 * fourth) - 1.0) / (2.0 * fourth))
    return (radius * [np.cos(angle), np.sin(angle)]).T.tolist()


def run(case: str, number: int, balanced: bool = False) -> tuple[Result, str]:
    """Return the errors of a run with ``number`` particles across as a ``Result``, and a message if it failed.

    ``balanced``: see ``config_of``.
    """
    from tisph.simulation.simulation import Simulation  # which starts Taichi

    config, fields, uniform = config_of(case, number, balanced), _fields(case), CASES[case].get("uniform", 0.0)

    def force(x: np.ndarray, y: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        along, *others = fields["force"](x, y, t)
        return along - uniform, *others

    given = {"body_force": force, "conformation_source": fields.get("source")}
    if config["scene"] == "shear_layer":  # which starts with streams of its own
        given["initial_velocity"] = lambda x, y, t: (0.0, 0.0)
    try:
        with Simulation(config, **given) as simulation:
            snapshot = simulation.run_until(END).snapshot
            reference = scenes.of(simulation.config) if CASES[case].get("beside_reference") else None
            counts = {"step": simulation.steps, "particles": len(snapshot.x)}
            sample = {"t_star": END, **counts, **_errors(snapshot, fields, reference)}
    except TisphError as error:
        return Result(Path(), {"status": "failed", "samples": []}), str(error)
    return Result(Path(), {"status": "done", "samples": [sample]}), ""


@cache
def _solution(case: str) -> Solution:
    return Solution(case)


@cache
def _fields(case: str) -> dict[str, Callable]:
    return _solution(case).fields()


def _errors(snapshot: Snapshot, fields: dict[str, Callable], reference: Scene | None = None) -> dict[str, float]:
    """Return relative L2 errors: ``l2`` of the velocity; of pressure, temperature and stress where these are not 0."""
    x, y, t = snapshot.x.astype(float), snapshot.y.astype(float), snapshot.t
    numbers = snapshot.substances or {}

    def off(names: Sequence[str], solution: Callable) -> float:
        values = np.array([numbers.get(name, getattr(snapshot, name, None)) for name in names], dtype=float)
        exact = np.array([np.broadcast_to(each, x.shape) for each in solution(x, y, t)])
        if reference:
            exact = exact + [reference.exact(name, x, y, t) for name in names]
        if names == ["pressure"]:  # known but for a constant
            values, exact = (each - np.mean(snapshot.weight * each) for each in (values, exact))
        error: Any = relative_difference(values, exact, snapshot.weight)  # of an exact solution that is not 0
        return error

    swirls = snapshot.w is not None
    found = {"l2": off("uvw" if swirls else "uv", fields["velocity"])}
    if np.ptp(fields["pressure"](x, y, t)[0]):
        found["l2_pressure"] = off(["pressure"], fields["pressure"])
    if "temperature" in fields:
        found["l2_temperature"] = off(["temperature"], fields["temperature"])
    if "stress" in fields:
        found["l2_stress"] = off([*STRESSES, *(STRESSES_AROUND if swirls else ())], fields["stress"])
    return found


def runs(quick: bool) -> dict[str, Callable]:
    """Return functions that run the cases, by the name of the run."""
    found: dict[str, Callable] = {
        name: partial(run, case, number)
        for case in (QUICK if quick else CASES)
        for name, number in _named(case, quick).items()
    }
    if not quick:
        found |= {f"{case}_balanced": partial(run, case, CASES[case]["across"][-1], True) for case in _with_parts()}
    return found


def _with_parts() -> list[str]:
    """Return the cases whose runs have steps shorter than balanced ones: all but slow flow, and scheme wcsph."""
    return [case for case in CASES if not {"slow", "explicit"} & {*CASES[case]["config"]}]


def _part_of_time(balanced: Result, shorter: Result) -> float:
    """Return the part of the error of the velocity in a run with ``balanced`` steps that ``shorter`` steps remove.

    NaN where a run failed.
    """
    return 1.0 - shorter.last["l2"] / balanced.last["l2"] if balanced.last and shorter.last else math.nan


def criteria(quick: bool) -> list[Criterion]:
    """Return the bounds of all runs, in the order of the table; ConfigError without sympy."""
    sympy()
    return [criterion for case in (QUICK if quick else CASES) for criterion in bounds(case, quick)]


def bounds(case: str, quick: bool) -> Iterator[Criterion]:
    """Yield the bounds of one case."""
    heated = "heated" in CASES[case]["config"]
    named, orders = _named(case, quick), CASES[case].get("orders", DATA["heated_orders" if heated else "orders"])
    quantities = "l2", "l2_pressure", "l2_temperature" if heated else "l2_stress"
    for quantity, bound, least in zip(quantities, CASES[case]["bounds"], orders, strict=False):
        if not quick:
            entry = {"run": list(named)[-1], "t_star": END, "at_most": {quantity: bound}}
            yield from checks.criteria(entry, {*named})
        order = {"order": quantity, "case": case, "runs": named, "t_star": END, "at_least": least}
        yield from checks.criteria(order, {*named})
    if not quick and case in _with_parts():
        pair = f"{case}_balanced", list(named)[-1]
        part = CASES[case].get("time_part", DATA["time_part"])
        yield checks.bounded(case, "part of the steps in the error", part, _part_of_time, pair)


def _named(case: str, quick: bool) -> dict[str, int]:
    """Return numbers of particles across by the names of the runs of a case."""
    return {f"{case}_{number}": number for number in CASES[case]["across"][: 2 if quick else 3]}
