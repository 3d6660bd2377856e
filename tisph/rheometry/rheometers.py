"""Rheometry: material functions from the columns of a run's ``history.csv``, beside theory and reference.

A reading has a ``title``, lines of text, and curves for a picture. "Apparent" is the usual evaluation of a rheometer:
stress at the moving wall over the nominal shear rate (its speed over the gap), as if the shear rate were uniform and
the fluid had no inertia. Its error is the difference from the linear theory of the fluid.

A rheometer of two cylinders is evaluated as a plane one. The stress at the moving cylinder, of radius a, is its torque
per length over 2 pi a^2. The nominal shear rate there is the shear rate of steady flow of a fluid of constant
viscosity, 2 W b^2/(a^2 - b^2) with the radius b of the other cylinder and the angular velocity W. Without inertia it
holds for all linear fluids.

Where the velocity of a wall follows a schedule, the reading is a step strain or a flow curve. Beside it is the response
of the law to the same nominal shear rate without inertia (``uniform_shear``). Inertia and a non-uniform shear rate
cause the difference between this response and the reference of the run. The size of the strain, or a ramp too fast for
the relaxation of the fluid, causes the difference between this response and the linear theory of a step, or steady
shear.

Suspensions and viscometers around an axis are evaluated at the end of a run (``viscometers``).
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from tisph.config.schema import Config
from tisph.errors import ConfigError, UnsolvedError
from tisph.exact._fluids import Rheology
from tisph.exact.heated_shear import Wall
from tisph.exact.linear_viscoelasticity import Spectrum, corrected_viscosity, cylinder_apparent_viscosity
from tisph.exact.uniform_shear import REMEMBERED, UniformShear
from tisph.geometry.motion import Schedule
from tisph.measures.channel import integral
from tisph.measures.flow import FlowInBox
from tisph.measures.heat import sheared, wall_of_shear
from tisph.measures.steadiness import CHANGE, LAST
from tisph.rheometry.viscometers import (
    SHOWN,
    VISCOMETERS,
    Axes,
    Reading,
    Table,
    at_rows,
    normal_curves,
    normal_stress,
    over_time,
    read_suspension,
    read_viscometer,
)
from tisph.scenes._cell import Cell
from tisph.scenes._channel import SIDES, Channel
from tisph.scenes._scene import Scene
from tisph.scenes.annulus import Annulus

NAMES = """
strain modulus_at_the_end modulus_at_the_end_reference modulus_at_the_end_without_inertia modulus_at_the_end_linear
inertia_gone_at normal_over_shear_stress_at_the_end off_reference off_by_inertia off_by_memory fastest_rate
angular_frequency third_harmonic storage_modulus_apparent loss_modulus_apparent storage_modulus_reference_apparent
loss_modulus_reference_apparent storage_modulus_corrected_for_inertia loss_modulus_corrected_for_inertia
storage_modulus_linear_theory loss_modulus_linear_theory shear_rate viscosity_at_the_end
viscosity_at_the_end_reference normal_stress_coefficient_at_the_end normal_stress_coefficient_at_the_end_reference
compliance_at_the_end compliance_at_the_end_reference recovered_strain recovered_strain_reference
ringing_frequency_run ringing_frequency_reference ringing_frequency_linear_theory ringing_damping_run
ringing_damping_reference ringing_damping_linear_theory wall_stress rate flow_rate apparent_rate velocity
wall_factor reynolds viscosity area_fraction relative_viscosity_walls relative_viscosity_walls_error
relative_viscosity_bodies relative_viscosity_bodies_error relative_viscosity_contacts contacts
nahme_number lowered_by_heat
"""
NUMBERS = frozenset(NAMES.split())
"""Names of the numbers of all readings."""

Stresses: TypeAlias = tuple[np.ndarray, np.ndarray]
"""Shear stress and first normal stress difference at some times."""


@dataclass(frozen=True)
class Sheared:
    """The fluid of a ``flow`` that is sheared across a ``gap``; ``top``: the motion of its upper wall.

    ``apparent_viscosity``: function of a complex viscosity and an angular frequency, of ``Channel.apparent_viscosity``.
    """

    flow: FlowInBox
    gap: float
    top: Any
    apparent_viscosity: Callable[[complex, float], complex]


def as_plane(annulus: Annulus, table: Table) -> tuple[Sheared, Any, Table]:
    """Return an equivalent plane gap, its moving upper wall, and the columns of the history of that wall.

    Its ``gap`` is 1, so that the speed of the wall is the nominal shear rate. ConfigError unless exactly one cylinder
    moves.
    """
    moving = [name for name in ("inner", "outer") if getattr(annulus, name).largest_speed]
    if len(moving) != 1:
        raise ConfigError("a rheometer has one moving cylinder and one at rest")
    if "torque_inner_exact" not in table:
        raise ConfigError("its history has no torques beside the exact ones: it has not ended")
    radii = annulus.inner_radius, annulus.outer_radius
    own, other = radii if moving == ["inner"] else radii[::-1]
    wall = getattr(annulus, moving[0]).scaled(2 * other**2 / abs(own**2 - other**2))
    # the torque on the moving cylinder is opposite to its motion
    columns = {name: -table[f"torque_{moving[0]}{name}"] / (2 * np.pi * own**2) for name in ("", "_exact")}
    plane = Sheared(
        annulus,
        1.0,
        wall,
        lambda viscosity, frequency: cylinder_apparent_viscosity(viscosity, frequency, annulus.density, own, other),
    )
    shears = {f"wall_shear{name}": values for name, values in columns.items()}
    normals = {f"n1{end}": table[f"n1_{moving[0]}{end}"] for end in ("", "_exact") if f"n1_{moving[0]}{end}" in table}
    same = {name: table[name] for name in ("t", "resolved") if name in table}
    return plane, wall, {**same, "strain": wall.displacement(table["t"]), **shears, **normals}


SMALL = 0.01
"""Largest effect of inertia on a modulus, over the modulus, when inertia is negligible."""

FASTEST = 0.1
"""Least shear rate at which a flow curve is judged, over the largest."""

NOTHING = 1e-9
"""Largest strain that counts as 0, over the strain of the largest speed."""

TINY = 0.01
"""Least shear rate of drawn viscosities, over the largest: below, the stress depends on earlier rates."""

POINTS = 101
"""Points of the steady flow curve."""


def uniform_shear(rheology: Rheology, flow: FlowInBox) -> UniformShear:
    """Return the law of the fluid in uniform shear; ``flow`` has its viscosities."""
    if not rheology.carries_stress:
        fluid = rheology.law(flow.kinematic_viscosity, flow.density)
        return UniformShear(lambda rate: flow.density * fluid.viscosity(rate**2) * rate)
    solvent = flow.density * flow.solvent_viscosity
    return UniformShear(lambda rate: solvent * rate, rheology.laws(flow.dynamic_viscosity))


def read_schedule(config: Config, plane: Sheared, fluid: Spectrum, wall: Schedule, table: Table) -> Reading:
    """Return the reading of a step strain where the ``wall`` rests for longer than it moved, else of a flow curve.

    ``fluid``: its ``Spectrum``; ``table``: columns of the history for a moving upper wall. A wall that returns to its
    start leaves no strain.
    """
    law, end = uniform_shear(config.fluid.rheology, plane.flow), wall.times[-1]
    pieces = [(begin, wall.after(begin)) for begin in (0.0, *wall.jump_times)]
    rates = [(begin, lambda t, ramp=ramp: ramp.velocity(t) / plane.gap) for begin, ramp in pieces]
    alone = law.response(rates, table["t"])
    strained = abs(wall.displacement(end)) > NOTHING * wall.largest_speed * end
    if strained and wall.velocities[-1] == 0.0 and table["t"][-1] > 2.0 * end:
        return _step_strain(plane.gap, fluid, wall, table, alone)
    return _flow_curve(plane.gap, law, wall, table, alone)


def _step_strain(gap: float, fluid: Spectrum, wall: Schedule, table: Table, uniform: Stresses) -> Reading:
    """Return the reading; ``uniform``: shear stress and N1 without inertia at all times of the table."""
    end = wall.times[-1]
    strain, late = float(wall.displacement(end)) / gap, table["t"] > end
    t = table["t"][late] - _middle(wall)
    alone, alone_normal = (values[late] for values in uniform)
    found, known = (table[name][late] / strain for name in ("wall_shear", "wall_shear_exact"))
    alone, step = alone / strain, fluid.modulus(t)
    lines = [f"relaxation modulus G, t from the middle of the step on; strain {strain:.6g} in the time {end:.6g}"]
    lines += over_time(t, {"apparent": found, "reference": known, "no inertia": alone, "linear, step": step})
    numbers: dict[str, float] = {"strain": strain}
    names = {"": found, "_reference": known, "_without_inertia": alone, "_linear": step}
    numbers |= {f"modulus_at_the_end{name}": float(values[-1]) for name, values in names.items()}
    wrong = np.flatnonzero(np.abs(known - alone) > SMALL * np.abs(alone))
    if len(wrong) == 0 or wrong[-1] + 1 < len(t):
        gone = float(t[wrong[-1] + 1] if len(wrong) else t[0])
        lines.append(f"  inertia changes it by less than {SMALL:.0%} from t = {gone:.4g} on")
        numbers["inertia_gone_at"] = gone
    axis = Axes("time from the middle of the step", "relaxation modulus G", ("time", "stress"), logarithmic=True)
    curves = [
        (axis, "run", t, found, "."),
        (axis, "reference", t, known, "-"),
        (axis, "linear theory of a step, without inertia", t, step, "--"),
    ]
    normal = normal_stress(table)
    if normal is not None:
        ratio = normal[late] / table["wall_shear"][late]
        lines.append(f"  N1 over the shear stress at the end: {ratio[-1]:.6g} (Lodge and Meissner: the strain)")
        numbers["normal_over_shear_stress_at_the_end"] = float(ratio[-1])
        axis = Axes(axis.x, "N1 over the square of the strain", axis.units, logarithmic=True)
        curves += normal_curves(table, axis, t, late, strain**2)
        curves.append((axis, "without inertia", t, alone_normal / strain**2, "--"))
    return Reading("step strain", lines, numbers, curves)


def _middle(wall: Schedule) -> float:
    """Return the mean time of the strain: measured from it, a ramp resembles a step (Zapas and Phillips)."""
    t = np.linspace(0.0, wall.times[-1], 2001)
    way = wall.displacement(t)
    area = np.sum(0.5 * (way[1:] + way[:-1]) * np.diff(t))
    return float(wall.times[-1] - area / way[-1])


def _flow_curve(gap: float, law: UniformShear, wall: Schedule, table: Table, uniform: Stresses) -> Reading:
    """Return the reading; ``law`` in uniform shear, ``uniform``: its shear stress and N1 at all times of the table."""
    t, rate = table["t"], wall.velocity(table["t"]) / gap
    alone, alone_normal = uniform
    found, known = table["wall_shear"], table["wall_shear_exact"]
    fastest = float(np.abs(rate).max())
    judged = (np.abs(rate) >= FASTEST * fastest) & (t > 0.0)
    rows = np.flatnonzero(judged)[np.linspace(0, judged.sum() - 1, SHOWN).astype(int)]
    steady = np.full(len(t), np.nan)
    steady[rows] = [law.steady(rate[row])[0] for row in rows]
    with np.errstate(all="ignore"):
        columns = {"rate": rate}
        parts = {"apparent": found, "reference": known, "no inertia": alone, "steady": steady}
        columns |= {name: stress / rate for name, stress in parts.items()}
    lines = ["viscosity, stress at the moving wall over the nominal shear rate", *at_rows(t, columns, rows)]
    off = {
        "the run differs from its reference by": _largest(found, known, judged),
        "inertia and a non-uniform shear rate change it by": _largest(known, alone, judged),
        "the relaxation of the fluid during the ramp changes it by": _largest(alone, steady, rows),
    }
    lines += [
        f"  {words} {value:.2e} of the stress at most, from {FASTEST:.0%} of the fastest rate on"
        for words, value in off.items()
    ]
    names = ("off_reference", "off_by_inertia", "off_by_memory")
    numbers = dict(zip(names, off.values(), strict=True)) | {"fastest_rate": fastest}
    curve = np.linspace(float(rate.min()), float(rate.max()), POINTS)
    settled = np.array([law.steady(one) for one in curve])
    axis = Axes("shear rate", "shear stress at the moving wall", ("rate", "stress"))
    over = Axes("shear rate", "viscosity", ("rate", "viscosity"), logarithmic=True)
    shear, size = (np.where(np.abs(each) > TINY * fastest, each, np.nan) for each in (rate, curve))
    curves = [
        (over, "run", np.abs(rate), found / shear, "."),
        (over, "reference", np.abs(rate), known / shear, "-"),
        (over, "steady shear", np.abs(curve), settled[:, 0] / size, "--"),
        (axis, "run", rate, found, "."),
        (axis, "reference", rate, known, "-"),
        (axis, "steady shear", curve, settled[:, 0], "--"),
    ]
    if normal_stress(table) is not None:
        axis = Axes("shear rate", "N1", ("rate", "stress"))
        curves += normal_curves(table, axis, rate, slice(None))
        curves.append((axis, "without inertia", rate, alone_normal, ":"))
        curves.append((axis, "steady shear", curve, settled[:, 1], "--"))
    return Reading("flow curve", lines, numbers, curves)


def _largest(found: np.ndarray, best: np.ndarray, where: np.ndarray) -> float:
    """Return the largest difference relative to ``best`` at the times ``where``; NaN, as after a jump, is ignored."""
    found, best = found[where], best[where]
    return float(np.nanmax(np.abs(found - best) / np.maximum(np.abs(best), 1e-300)))


LINEAR = 1e-2
"""Third harmonic of the stress over the first below which the strain is small: it grows with the square of the strain,
as does the change of the moduli."""

HARMONICS = (1, 2, 3, 5)
MARKS = (("apparent", "x", "+"), ("corrected for inertia", "o", "s"))
"""Names of moduli, marks of G' and G'' in the picture."""
SETTLED = 1e-6
"""Largest rest of the start-up transient in an oscillation that is fitted without a polynomial."""

DEGREE = 5
"""Degree of the polynomial that is fitted to the rest of the start-up transient."""

HEIGHTS = 200
"""Number of heights at which the exact N1 is averaged over the gap."""

DECADES = np.geomspace(0.1, 10.0, 41)
"""Frequencies of the drawn linear theory, over the frequency of the run."""

FADED = 15.0
"""Number of longest relaxation times after which the start-up transient has decayed."""


def spectrum(rheology: Rheology, flow: FlowInBox) -> Spectrum:
    """Return the relaxation spectrum of a fluid at small deformations."""
    if not rheology.carries_stress:
        law = rheology.law(flow.kinematic_viscosity, flow.density)
        return Spectrum(flow.density * float(law.viscosity(0.0)))
    laws = rheology.laws(flow.dynamic_viscosity)
    modes = tuple((law.polymer_viscosity, law.relaxation_time) for law in laws)
    return Spectrum(flow.density * flow.solvent_viscosity, modes)


def read(config: Config, scene: Scene, table: Table, contacts: Any = None, last: Any = None) -> Reading:
    """Return the reading of a run; ``table`` has the columns of its history by name.

    ``contacts``: number of contacts of bodies, if known; ``last``: numbers of the last sample by name. ConfigError
    where the run is not a flow of a rheometer.
    """
    if any(body.slip_length for body in scene.bodies) or any(getattr(scene, "slip_lengths", ())):
        raise ConfigError("its fluid slips along a wall (slip_length): it has another shear rate than the walls say")
    if config.scene in VISCOMETERS:
        return read_viscometer(config.scene, scene, table, last)
    if isinstance(scene, Cell) and scene.has_free_bodies:
        return read_suspension(scene, table, contacts)
    if not scene.isothermal and not isinstance(scene, Channel):
        raise ConfigError("its temperature acts on the flow: such a flow is read in a parallel channel alone")
    fluid = spectrum(config.fluid.rheology, scene)
    if isinstance(scene, Annulus):
        plane, wall, table = as_plane(scene, table)
        return _by_velocity(config, plane, fluid, wall, table)
    if not isinstance(scene, Channel) or scene.extra_series is None or "strain" not in table:
        raise ConfigError("its history has no wall stress: it is of a Newtonian fluid, or has not ended")
    if "n1_mean" in table:
        y = (np.arange(HEIGHTS)[:, None] + 0.5) * scene.gap / HEIGHTS
        xx, _, yy = scene.exact_polymer_stress(y, table["t"])
        table = {**table, "n1_exact": (xx - yy).mean(axis=0)}
    if scene.driven_side is not None:
        return _creep(scene, fluid, table)
    moving = [side for side, wall in zip(SIDES, scene.pair, strict=True) if wall.largest_speed]
    if len(moving) != 1 or scene.acceleration:
        raise ConfigError("a rheometer has one moving wall, a wall at rest and no drive")
    wall, (side,) = getattr(scene, moving[0]), moving
    sign = 1.0 if side == "top" else -1.0  # stress and strain of a lower wall have the other sign
    shears = {name.replace(f"_{side}", ""): sign * values for name, values in table.items() if "shear" in name}
    if not scene.isothermal:
        return _heated(config, scene, wall, {**table, **shears})
    plane = Sheared(scene, scene.gap, scene.top, scene.apparent_viscosity)
    return _by_velocity(config, plane, fluid, wall, {**table, **shears, "strain": table["strain"], "t": table["t"]})


def _steady_heated(config: Config, flow: Channel, rates: np.ndarray, time: float) -> np.ndarray:
    """Return the stresses (n,) of steady flow with heating at nominal shear ``rates`` (n,); NaN where there are none.

    Walls have the temperatures or fluxes of the ``time``. Of two solutions at a rate it is the colder one.
    """
    heat, rheology = flow.temperature, config.fluid.rheology
    if heat is None or rheology.carries_stress:
        return np.full(len(rates), np.nan)
    law = rheology.law(flow.kinematic_viscosity, flow.density)

    def viscosity(temperature: Any, rate: Any) -> Any:
        factor = heat.factor(temperature)
        return flow.density * factor * law.viscosity((factor * rate) ** 2)

    def wall(number: int, speed: float) -> Wall:
        return wall_of_shear(heat.conditions[number], np.array([0.0, flow.gap * number]), time, speed)

    stresses = np.full(len(rates), np.nan)
    for index, rate in enumerate(rates):
        walls = wall(0, 0.0), wall(1, float(rate) * flow.gap)
        steady = sheared(heat, (0.0, flow.gap), walls, viscosity, flow.density)
        with suppress(UnsolvedError, ValueError):
            stresses[index] = float(steady.steady().shear_stress(flow.gap))
    return stresses


def _heated(config: Config, flow: Channel, wall: Any, table: Table) -> Reading:
    """Return the flow curve of a fluid that heats up: of the run, of steady flow with heating, and without.

    Without heating the law is at the reference temperature. The Nahme number is a tau U/k with the stress tau without
    heating, and a the change of the logarithm of the viscosity with the temperature.
    """
    from scipy.interpolate import PchipInterpolator  # few readings need it

    heat, law, t = flow.temperature, uniform_shear(config.fluid.rheology, flow), table["t"]
    assert heat is not None
    rate = np.asarray(wall.velocity(t) / flow.gap) + 0.0 * t
    fastest = float(np.abs(rate).max())
    judged = np.flatnonzero((np.abs(rate) >= FASTEST * fastest) & (t > 0.0))
    rows = judged[np.linspace(0, len(judged) - 1, SHOWN).astype(int)]
    different, place = np.unique(np.abs(rate[rows]).round(12), return_inverse=True)
    warm, cold = _steady_heated(config, flow, different, float(t[-1])), [law.steady(one)[0] for one in different]
    stresses = {
        "run": np.abs(table["wall_shear"][rows]),
        "steady, heated": warm[place],
        "no heating": np.array(cold)[place],
    }
    shown = {name: stress / np.abs(rate[rows]) for name, stress in stresses.items()}
    columns = {"rate": rate[rows], **shown}
    lines = ["viscosity, stress at the moving wall over the nominal shear rate"]
    lines += at_rows(t[rows], columns, np.arange(len(rows)))
    last = int(np.argmax(np.abs(rate[rows])))
    sensitivity = abs(heat.sensitivity) if heat.law else 0.0
    nahme = sensitivity * cold[-1] * fastest * flow.gap**2 / (heat.capacity * heat.diffusivity)
    lowered = 1.0 - float(shown["run"][last] / shown["no heating"][last])
    lines.append(f"  heat lowers the viscosity by {100 * lowered:.3g} % at the fastest rate, Nahme number {nahme:.4g}")
    numbers = {"fastest_rate": fastest, "nahme_number": float(nahme), "lowered_by_heat": lowered}
    axis = Axes("shear rate", "viscosity", ("rate", "viscosity"), logarithmic=True)
    with np.errstate(all="ignore"):
        run = np.abs(table["wall_shear"] / rate)
    curves = [
        (axis, "run", np.abs(rate[judged]), run[judged], "."),
        (axis, "without heating", different, cold / different, "--"),
    ]
    if np.isfinite(warm).all():
        numbers["off_reference"] = _largest(shown["run"], shown["steady, heated"], np.arange(len(rows)))
        lines.append(f"  the run differs from steady flow with heating by {numbers['off_reference']:.2e} at most")
        smooth = np.geomspace(different[0], different[-1], POINTS)
        between = PchipInterpolator(np.log(different), warm / different)
        curves.append((axis, "steady flow with heating", smooth, between(np.log(smooth)), "-"))
    return Reading("flow curve of a fluid that heats up", lines, numbers, curves)


def _by_velocity(config: Config, plane: Sheared, fluid: Spectrum, wall: Any, table: Table) -> Reading:
    """Return the reading for a ``wall`` with a given velocity; ``table`` belongs to an upper wall."""
    if isinstance(wall, Schedule):
        return read_schedule(config, plane, fluid, wall, table)
    if wall.oscillates:
        return _oscillation(plane, fluid, wall, table)
    return _start_up(plane.gap, uniform_shear(config.fluid.rheology, plane.flow), wall, table)


def _oscillation(plane: Sheared, fluid: Spectrum, wall: Any, table: Table) -> Reading:
    """Return storage and loss modulus, apparent, corrected for inertia, and of the reference and the linear theory."""
    frequency, gap = wall.angular_frequency, plane.gap
    rate = np.hypot(wall.cosine, wall.sine) / gap
    t, first = _window(table["t"], frequency, fluid.longest_time)
    settled = np.exp(-t[0] / fluid.longest_time) < SETTLED if fluid.longest_time else True
    degree = 0 if settled else DEGREE
    nominal = (wall.cosine - 1j * wall.sine) / gap
    stress = _amplitudes(t, table["wall_shear"][first:], frequency, degree)
    exact = _amplitudes(t, table["wall_shear_exact"][first:], frequency, degree)
    apparent, reference = stress[1] / nominal, exact[1] / nominal
    theory = fluid.complex_viscosity(1j * frequency)
    corrected = corrected_viscosity(apparent, lambda eta: plane.apparent_viscosity(eta, frequency), theory)
    modulus = {
        "apparent": 1j * frequency * apparent,
        "reference, apparent": 1j * frequency * reference,
        "corrected for inertia": 1j * frequency * corrected,
        "linear theory": 1j * frequency * theory,
    }
    lines = [f"angular frequency {frequency:.6g}, strain amplitude {rate / frequency:.4g}"]
    lines += [f"  {name:24} G' = {value.real:.6g}   G'' = {value.imag:.6g}" for name, value in modulus.items()]
    third, third_exact = (float(abs(each[3] / each[1])) for each in (stress, exact))
    if third_exact < LINEAR:
        compared = {
            "inertia changes the usual evaluation by": ("apparent", "linear theory"),
            "corrected, it differs from the linear theory by": ("corrected for inertia", "linear theory"),
        }
    else:
        compared = {
            "the large strain changes the linear theory by": ("reference, apparent", "linear theory"),
            "the run differs from its reference by": ("apparent", "reference, apparent"),
        }
    for words, (name, other) in compared.items():
        value, best = modulus[name], modulus[other]
        elastic = value.real / best.real - 1.0 if best.real else np.nan
        lines.append(f"  {words}: {elastic:+.2e} of G', {value.imag / best.imag - 1.0:+.2e} of G''")
    lines.append(f"  third harmonic of the stress over the first: {third:.4g} (reference {third_exact:.4g})")
    if degree and (t[-1] - t[0]) * frequency < 3.0 * np.pi:  # a polynomial resembles a single wave
        lines.append(f"  uncertain, from one period with the start-up: run four, or {FADED:g} relaxation times")
    numbers = {"angular_frequency": frequency, "third_harmonic": third}
    for name, value in modulus.items():
        key = name.replace(",", "").replace(" ", "_")
        numbers |= {f"storage_modulus_{key}": float(value.real), f"loss_modulus_{key}": float(value.imag)}
    strain = table["strain"][first:] if wall is plane.top else -table["strain"][first:]
    axis = Axes("strain", "shear stress at the moving wall", ("number", "stress"))
    omega = frequency * DECADES
    moduli = 1j * omega * fluid.complex_viscosity(1j * omega)
    over = Axes("angular frequency", "G\N{PRIME}, G\N{DOUBLE PRIME}", ("rate", "stress"), logarithmic=True)
    curves = [
        (over, "G\N{PRIME}, linear theory", omega, moduli.real, "--"),
        (over, "G\N{DOUBLE PRIME}, linear theory", omega, moduli.imag, ":"),
        *((over, f"G\N{PRIME}, {name}", [frequency], [modulus[name].real], mark) for name, mark, _ in MARKS),
        *((over, f"G\N{DOUBLE PRIME}, {name}", [frequency], [modulus[name].imag], mark) for name, _, mark in MARKS),
        (axis, "run", strain, table["wall_shear"][first:], "."),
        (axis, "reference", strain, table["wall_shear_exact"][first:], "-"),
    ]
    return Reading("oscillation", lines, numbers, curves)


def together(readings: Sequence[Reading]) -> Reading:
    """Return one reading of two or more oscillations of one fluid: moduli over the angular frequency."""
    ordered = sorted(readings, key=lambda each: each.numbers["angular_frequency"])
    shown = [
        (f"{part}_modulus_{kind}", f"{sign}, {words}")
        for kind, words in (("corrected_for_inertia", "run"), ("linear_theory", "theory"))
        for part, sign in (("storage", "G'"), ("loss", "G''"))
    ]
    lines = [" ".join(f"{words:>14}" for words in ("frequency", *(words for _, words in shown)))]
    for each in ordered:
        numbers = [each.numbers[key] for key in ("angular_frequency", *(key for key, _ in shown))]
        lines.append(" ".join(f"{value:14.6g}" for value in numbers))
    curves = []
    for same in zip(*([curve for curve in each.curves if curve[0].logarithmic] for each in ordered), strict=True):
        x, y = (np.concatenate([curve[place] for curve in same]) for place in (2, 3))
        order = np.argsort(x)
        curves.append((*same[0][:2], x[order], y[order], same[0][4]))
    return Reading("moduli over the angular frequency", lines, {}, curves)


def steady_shear(readings: Sequence[Reading], law: UniformShear) -> Reading:
    """Return one reading of two or more start-ups of one fluid at their ends: viscosity and N1 over the shear rate.

    ``law`` of the fluid in uniform shear gives the exact curves. N1 is missing without a polymer.
    """
    ordered = sorted(readings, key=lambda each: abs(each.numbers["shear_rate"]))
    rate = np.array([abs(each.numbers["shear_rate"]) for each in ordered])
    known = np.array([law.steady(one) for one in rate])
    dense = np.geomspace(0.5 * rate[0], 2.0 * rate[-1], len(DECADES))
    exact = np.array([law.steady(one) for one in dense])
    viscosity = np.array([each.numbers["viscosity_at_the_end"] for each in ordered])
    coefficient = np.array([each.numbers.get("normal_stress_coefficient_at_the_end", np.nan) for each in ordered])
    values = {"viscosity": (viscosity, known[:, 0] / rate, exact[:, 0] / dense)}
    if not np.isnan(coefficient).all():
        values["N1"] = (coefficient * rate**2, known[:, 1], exact[:, 1])
    columns, curves = {"rate": rate}, []
    for (name, (found, steady, line)), unit in zip(values.items(), ("viscosity", "stress"), strict=False):
        columns |= {name: found, f"{name}, steady": steady}
        axis = Axes("shear rate", name, ("rate", unit), logarithmic=True)
        curves += [(axis, "steady shear of the fluid", dense, line, "--"), (axis, "runs", rate, found, "o")]
    lines = [" ".join(f"{name:>17}" for name in columns)]
    lines += [" ".join(f"{value:17.6g}" for value in row) for row in zip(*columns.values(), strict=True)]
    for each in ordered:
        _, _, t, growth, _ = each.curves[0]
        if not abs(np.interp((1.0 - LAST) * t[-1], t, growth) / growth[-1] - 1.0) < CHANGE:
            lines.append(f"  unsteady at the rate {each.numbers['shear_rate']:.6g}: its run is too short")
    return Reading("steady shear", lines, {}, curves)


def _window(t: np.ndarray, frequency: float, longest: float) -> tuple[np.ndarray, int]:
    """Return the times of the evaluated whole periods at the end of the run, and the index of the first.

    They are the periods after ``FADED`` times the ``longest`` relaxation time, but at most half of all periods.
    """
    period = 2.0 * np.pi / frequency
    whole = (t[-1] - t[0]) / period
    if whole < 2.0 * (1.0 - 1e-9):
        raise ConfigError(f"the run has {whole:.3g} periods of the wall; an oscillation is read from two on")
    late = int((t[-1] - FADED * longest) / period)
    count = min(int(whole / 2 + 1e-9), late) if late >= 1 else int(whole / 2 + 1e-9)
    first = int(np.searchsorted(t, t[-1] - count * period * (1.0 + 1e-9)))
    return t[first:], first


def _amplitudes(t: np.ndarray, values: np.ndarray, frequency: float, degree: int) -> dict[int, complex]:
    """Return complex amplitudes of the harmonics by number, fitted together with a polynomial of this ``degree``."""
    angle, middle = frequency * t, (t - t.mean()) / max(np.ptp(t), 1e-300)
    columns = [middle**power for power in range(degree + 1)]
    for number in HARMONICS:
        columns += [np.cos(number * angle), -np.sin(number * angle)]
    found = np.linalg.lstsq(np.stack(columns, 1), values, rcond=None)[0][degree + 1 :]
    return {number: complex(*found[2 * k : 2 * k + 2]) for k, number in enumerate(HARMONICS)}


def _start_up(gap: float, law: UniformShear, wall: Any, table: Table) -> Reading:
    """Return viscosity growth after a start, or stress decay after a stop, over the shear rate.

    ``law`` in uniform shear, which has been steady at the rate before, gives stress and N1 without inertia.
    """
    rate, before = wall.cosine / gap, (wall.before or 0.0) / gap
    steady = before or rate
    t = table["t"][1:]
    memory = REMEMBERED * max((mode.relaxation_time for mode in law.laws), default=0.0) if before else 0.0
    rates = [(0.0, lambda t: before + 0.0 * t)] * bool(memory) + [(memory, lambda t: rate + 0.0 * t)]
    theory, normal_theory = law.response(rates, memory + t)
    theory = theory / steady
    found, exact = table["wall_shear"][1:] / steady, table["wall_shear_exact"][1:] / steady
    quantity = "viscosity growth eta+" if rate else "stress after cessation, over the rate before"
    lines = [f"{quantity}; shear rate {rate:.6g}, before {before:.6g}"]
    resolved = table["resolved"][1:] if "resolved" in table else None
    lines += over_time(t, {"apparent": found, "reference": exact, "no inertia": theory}, resolved)
    numbers = {"shear_rate": rate} if rate else {}
    numbers |= {"viscosity_at_the_end": float(found[-1]), "viscosity_at_the_end_reference": float(exact[-1])}
    axis = Axes("time", quantity, ("time", "viscosity"), logarithmic=bool(rate))
    curves = [
        (axis, "run", t, found, "."),
        (axis, "reference", t, exact, "-"),
        (axis, "without inertia", t, theory, "--"),
    ]
    normal = normal_stress(table)
    if normal is not None:
        line, name = "  N1 over the square of the rate at the end:", "normal_stress_coefficient_at_the_end"
        numbers[name] = float(normal[-1] / steady**2)
        lines.append(f"{line} {numbers[name]:.6g}")
        if "n1_exact" in table:
            numbers[f"{name}_reference"] = float(table["n1_exact"][-1] / steady**2)
            lines[-1] += f" (reference {numbers[f'{name}_reference']:.6g})"
        units = "time", "normal_stress_coefficient"
        axis = Axes("time", "N1 over the square of the rate", units, logarithmic=bool(rate))
        curves += normal_curves(table, axis, t, slice(1, None), steady**2)
        curves.append((axis, "without inertia", t, normal_theory / steady**2, "--"))
    return Reading("start-up" if rate else "cessation", lines, numbers, curves)


def _creep(channel: Channel, fluid: Spectrum, table: Table) -> Reading:
    """Return the creep compliance of a wall under constant stress, recovery and free oscillation."""
    assert channel.driven_side is not None
    side = SIDES[channel.driven_side]
    plate = getattr(channel, side)
    t, sign = table["t"], 1.0 if side == "top" else -1.0
    stress = float(plate.stress(t[1] * 0.5))
    if not stress or plate.oscillates:
        raise ConfigError("creep needs a stress that is constant from t = 0 on, for a while")
    strain = sign * table["strain"]
    exact = integral(t, table[f"wall_velocity_{side}_exact"]) / channel.gap
    end = min(plate.jump_times, default=t[-1])
    during = (t > 0) & (t <= end * (1 + 1e-12))
    found, known, theory = strain[during] / stress, exact[during] / stress, fluid.compliance(t[during])
    lines = [f"creep compliance J under the stress {stress:.6g}"]
    resolved = table["resolved"][during] if "resolved" in table else None
    lines += over_time(t[during], {"run": found, "reference": known, "linear theory": theory}, resolved)
    axis = Axes("time", "strain over stress", ("time", "compliance"))
    curves = [
        (axis, "run", t, strain / stress, "."),
        (axis, "reference", t, exact / stress, "-"),
        (axis, "linear theory without inertia", t[during], theory, "--"),
    ]
    numbers = {"compliance_at_the_end": float(found[-1]), "compliance_at_the_end_reference": float(known[-1])}
    if plate.jump_times and plate.stress(end) == 0.0:
        recovered = [float(one[during][-1] - one[-1]) for one in (strain, exact)]
        lines.append(f"  recovered strain {recovered[0]:.6g} (reference {recovered[1]:.6g})")
        numbers |= {"recovered_strain": recovered[0], "recovered_strain_reference": recovered[1]}
    if plate.mass_per_area:
        run, reference = (
            _slowest_pair(t[during], table[f"wall_velocity_{side}{end}"][during]) for end in ("", "_exact")
        )
        if run is not None and reference is not None:
            roots = {"run": run, "reference": reference}
            roots["linear theory"] = fluid.free_oscillation(
                reference, channel.density, channel.gap, plate.mass_per_area
            )
            lines.append("  free oscillation, e^(-d t) cos(w t):")
            for name, root in roots.items():
                lines.append(f"    {name:14} w = {root.imag:.6g}   d = {-root.real:.6g}")
                key = name.replace(" ", "_")
                numbers |= {f"ringing_frequency_{key}": float(root.imag), f"ringing_damping_{key}": float(-root.real)}
    return Reading("creep", lines, numbers, curves)


PENCIL = 7
"""Number of exponentials in the decomposition of a velocity: the steady speed and three pairs."""


def _slowest_pair(t: np.ndarray, velocity: np.ndarray) -> complex | None:
    """Return the root s with an imaginary part of the largest exponential e^(s t) in a velocity; None without one.

    By the matrix pencil (Y. Hua and T. K. Sarkar, IEEE Trans. Acoust. 38 (1990) 814-824), from a tenth of the time on.
    """
    late = t > t[0] + 0.1 * np.ptp(t)
    t, velocity = t[late], velocity[late]
    step, size = np.ptp(t) / (len(t) - 1), len(t) // 3
    windows = np.lib.stride_tricks.sliding_window_view(velocity, size + 1)
    _, _, rows = np.linalg.svd(windows, full_matrices=False)
    rows = rows[:PENCIL].T
    roots = np.log(np.linalg.eigvals(np.linalg.lstsq(rows[:-1], rows[1:], rcond=None)[0]).astype(complex)) / step
    sizes = np.linalg.lstsq(np.exp(np.outer(t - t[0], roots)), velocity.astype(complex), rcond=None)[0]
    pairs = [(abs(size), root) for size, root in zip(sizes, roots, strict=True) if root.imag > 1e-6 / step]
    return max(pairs, key=lambda pair: pair[0])[1] if pairs else None
