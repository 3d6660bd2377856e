"""Numbers, units and errors as text that a reader takes in at once: no 1e-05, no offsets, a true minus sign."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from tisph.measures.metrics import field_error, relative_error, rms_error
from tisph.measures.resolution import unresolved
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot

MINUS = "\N{MINUS SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power_text(exponent: int) -> str:
    """Return a power of ten, for example ``10⁻³``."""
    return "10" + str(exponent).translate(_SUPERSCRIPT)


def scientific(value: float, decimals: int = 1) -> str:
    """Return ``value`` as mantissa times power of ten, for example ``1.5×10⁻³``; zero is ``0``, and NaN ``nan``."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:.0f}"
    mantissa, exponent = f"{value:.{decimals}e}".split("e")
    return f"{mantissa}{TIMES}{power_text(int(exponent))}".replace("-", MINUS)


def number(value: float, digits: int = 4) -> str:
    """Return ``value`` to ``digits`` significant digits, plain from 0.001 to 9999, else scientific."""
    rounded = float(f"{value:.{digits - 1}e}")
    if rounded != 0.0 and math.isfinite(rounded) and not 1e-3 <= abs(rounded) < 1e4:
        mantissa, power = scientific(rounded, digits - 1).split(TIMES)
        return f"{mantissa.rstrip('0').rstrip('.')}{TIMES}{power}"
    return np.format_float_positional(rounded, trim="-").replace("-", MINUS)


def axis_exponent(largest: float, smallest_plain: float = 1e-2) -> int:
    """Return the power of ten, a multiple of 3, to be taken out of an axis that reaches to ``largest``.

    Values from ``smallest_plain`` to 10^4 stand as they are (exponent 0).
    """
    if smallest_plain <= largest < 1e4 or largest == 0.0:
        return 0
    return 3 * math.floor(math.log10(largest) / 3.0)


def axis_label(quantity: str, unit: str, exponent: int = 0) -> str:
    """Return an axis label such as ``u [10⁻³ m/s]``; ``unit`` may be empty."""
    parts = [power_text(exponent)] if exponent else []
    parts += [unit] if unit else []
    return f"{quantity} [{' '.join(parts)}]" if parts else quantity


def coordinate_name(scene: Scene, axis: str) -> str:
    """Return the name of the coordinate along the ``axis`` x or y: r of y where that is the distance from an axis."""
    return "r" if axis == "y" and scene.axisymmetric else axis


def cut_name(profile: Any, scene: Scene) -> str:
    """Return the name of a ``Profile``, with the place of its line where the quantity depends on it: u at x = 0.5 m."""
    line = profile.line
    if line.half_width == np.inf:
        return profile.name
    across = coordinate_name(scene, "x" if line.along == "y" else "y")
    return f"{profile.name} at {across} = {number(line.place, 3)} {scene.units.length}"


def tick_text(value: float, exponent: int) -> str:
    """Return a tick label in units of ``10^exponent``, free of rounding noise."""
    scaled = float(f"{value / 10.0**exponent:.9g}")
    return np.format_float_positional(scaled + 0.0, trim="-").replace("-", MINUS)


def fixed_point(largest: float, digits: int, smallest_plain: float = 1e-3) -> Callable[[float], str]:
    """Return a function value -> text with as many decimals as give ``largest`` that many significant ``digits``.

    All values have the same width: the power of ten, if any, is the one of ``largest`` as in ``axis_exponent``, and
    zero is written with all its decimals.
    """
    exponent = axis_exponent(largest, smallest_plain)
    decimals = max(0, digits - 1 - math.floor(math.log10(largest) - exponent))
    suffix = f"{TIMES}{power_text(exponent)}" if exponent else ""

    def text(value: float) -> str:
        rounded = round(value / 10.0**exponent, decimals) + 0.0  # no negative zero
        return f"{rounded:.{decimals}f}{suffix}".replace("-", MINUS)

    return text


def unit_label(kind: str, units: Any) -> str:
    """Return the label of the unit of a ``kind`` of quantity, from the config's unit labels; velocity: ``m/s``.

    A ``kind`` that is none is a label itself. Forces and torques are per length across the plane. The unit of a stress
    is ``Pa`` where the units are m, kg and s, else mass/(length time²).
    """
    length, mass, time = units.length, units.mass, units.time
    pascal = (length, mass, time) == ("m", "kg", "s")
    return {
        "number": "",
        "length": length,
        "angle": "rad",
        "velocity": f"{length}/{time}",
        "acceleration": f"{length}/{time}²",
        "stress": "Pa" if pascal else f"{mass}/({length} {time}²)",
        "compliance": "1/Pa" if pascal else f"{length} {time}²/{mass}",
        "viscosity": "Pa s" if pascal else f"{mass}/({length} {time})",
        "normal_stress_coefficient": "Pa s²" if pascal else f"{mass}/{length}",
        "time": time,
        "rate": f"1/{time}",
        "flow_rate": f"{length}³/{time}",
        "planar_flow_rate": f"{length}²/{time}",
        "force": "N/m" if pascal else f"{mass}/{time}²",
        "energy": f"{length}²/{time}²",
        "whole_force": "N" if pascal else f"{mass} {length}/{time}²",
        "moment": "N m" if pascal else f"{mass} {length}²/{time}²",
        "torque": "N" if pascal else f"{mass} {length}/{time}²",
    }.get(kind, kind)


def time_label(time_scale: float, unit: str, formula: str) -> Callable[[float], str]:
    """Return a function t -> ``t = 1.80 s   t* = νt/H² = 0.0180`` with a fixed number of decimals.

    t has a resolution of about ``time_scale``/1000, and t* = t / ``time_scale``, which is written as ``formula``, of
    1/10000.
    """
    clock = fixed_point(time_scale, 4)

    def label(t: float) -> str:
        return f"t = {clock(t)} {unit}     t* = {formula} = {t / time_scale:.4f}"

    return label


def error_label(scene: Scene, field: tuple[str, str] | None = None) -> Callable[[Snapshot], str]:
    """Return a function snapshot -> relative error of the velocity in words, for example ``L2 error 1.5×10⁻³``.

    Where u crosses zero or decays (``vanishing_scale``), the relative error is large although the particles are right;
    the text then has the rms error over the reference velocity U, ``rms error 1.5×10⁻³ U``. A flow that is not
    resolved has no meaningful error: ``unresolved: layer of 0.3 spacings``. ``field`` (name in the
    snapshot, name in words) selects the error of one field. Without a reference the text is empty.
    """
    of_velocity = field is None
    by_speed = of_velocity and bool(scene.fields) and scene.vanishing_scale  # takes longer than drawing a frame
    name = f"L2 error of {field[1]}" if field else "L2 error"

    def label(snapshot: Snapshot) -> str:
        lacking = unresolved(scene, snapshot.t, snapshot)
        if lacking:
            return f"unresolved: {lacking[0]}"
        if of_velocity and not scene.fields:
            return ""
        if by_speed:
            return f"rms error {scientific(rms_error(scene, snapshot) or 0.0)} U"
        error = field_error(scene, snapshot, field[0]) if field else relative_error(scene, snapshot)
        return f"{name}: none yet" if error is None else f"{name} {scientific(error)}"

    return label
