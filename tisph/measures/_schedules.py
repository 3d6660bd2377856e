"""What a rheologist reads where the velocity of a wall follows a schedule: step strain, or a flow curve.

Beside what is read stands the answer of the law to the same nominal shear rate without inertia (``uniform_shear``). By
what the reference of the run differs from that is what inertia and an uneven shear rate make; by what that differs from
the linear theory of a step, or from steady shear, is the strain, or a ramp too fast for the relaxation of the fluid.
"""

import numpy as np

from tisph.exact.uniform_shear import UniformShear
from tisph.measures._reading import SHOWN, Axes, Reading, at_rows, normal_curves, normal_stress, over_time

SMALL = 0.01
"""What inertia may take off a modulus where it counts as gone."""

FASTEST = 0.1
"""Of the largest shear rate: from there on a flow curve is judged."""

NOTHING = 1e-9
"""Of the way at the largest speed: what counts for no strain."""

TINY = 0.01
"""Of the largest shear rate: below, the stress is that of what was before."""

POINTS = 101
"""Of the steady flow curve."""


def read_schedule(config, channel, fluid, wall, table):
    """Return the ``Reading``: of a step strain where the ``wall`` rests for longer than it moved, else a flow curve.

    ``fluid``: its ``Spectrum``; ``table``: columns of the history as of a moving upper wall. One that comes back to
    where it was leaves no strain.
    """
    law, end = _uniform(config, channel), wall.times[-1]
    pieces = [(begin, wall.after(begin)) for begin in (0.0, *wall.jump_times)]
    rates = [(begin, lambda t, ramp=ramp: ramp.velocity(t) / channel.gap) for begin, ramp in pieces]
    alone = law.response(rates, table["t"])
    strained = abs(wall.displacement(end)) > NOTHING * wall.largest_speed * end
    if strained and wall.velocities[-1] == 0.0 and table["t"][-1] > 2.0 * end:
        return _step_strain(channel.gap, fluid, wall, table, alone)
    return _flow_curve(channel.gap, law, wall, table, alone)


def _uniform(config, channel):
    rheology = config.fluid.rheology
    if rheology.carries_stress:
        solvent = channel.density * channel.solvent_viscosity
        return UniformShear(lambda rate: solvent * rate, rheology.laws(channel.dynamic_viscosity))
    return UniformShear(channel.viscous_stress)


def _step_strain(gap, fluid, wall, table, alone):
    """``alone``: shear stress and N1 without inertia at all times of the table."""
    end = wall.times[-1]
    strain, late = wall.displacement(end) / gap, table["t"] > end
    t = table["t"][late] - _middle(wall)
    alone, alone_normal = (values[late] for values in alone)
    found, known = (table[name][late] / strain for name in ("wall_shear", "wall_shear_exact"))
    alone, step = alone / strain, fluid.modulus(t)
    lines = [f"relaxation modulus G, t from the middle of the step on; strain {strain:.6g} in the time {end:.6g}"]
    lines += over_time(t, {"apparent": found, "reference": known, "no inertia": alone, "linear, step": step})
    numbers = {"strain": strain}
    names = {"": found, "_reference": known, "_without_inertia": alone, "_linear": step}
    numbers |= {f"modulus_at_the_end{name}": float(values[-1]) for name, values in names.items()}
    wrong = np.flatnonzero(np.abs(known - alone) > SMALL * np.abs(alone))
    if len(wrong) == 0 or wrong[-1] + 1 < len(t):
        gone = float(t[wrong[-1] + 1] if len(wrong) else t[0])
        lines.append(f"  inertia makes less than {SMALL:.0%} from t = {gone:.4g} on")
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


def _middle(wall):
    """The mean time of the strain (Zapas and Phillips): from then on a ramp looks like a step."""
    t = np.linspace(0.0, wall.times[-1], 2001)
    way = wall.displacement(t)
    area = np.sum(0.5 * (way[1:] + way[:-1]) * np.diff(t))
    return float(wall.times[-1] - area / way[-1])


def _flow_curve(gap, law, wall, table, alone):
    """``law``: in uniform shear; else as ``_step_strain``."""
    t, rate = table["t"], wall.velocity(table["t"]) / gap
    alone, alone_normal = alone
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
        "the run is off its reference by": _largest(found, known, judged),
        "inertia and an uneven shear rate make": _largest(known, alone, judged),
        "the ramp, too fast for the relaxation of the fluid, makes": _largest(alone, steady, rows),
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


def _largest(found, best, where):
    """The largest relative difference at some of the times; NaN where a stress is none, as after a jump."""
    found, best = found[where], best[where]
    return float(np.nanmax(np.abs(found - best) / np.maximum(np.abs(best), 1e-300)))
