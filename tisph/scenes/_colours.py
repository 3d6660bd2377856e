"""What a movie can be coloured by: each quantity in words, with its unit, and how it follows from a snapshot."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tisph.measures.fits import stream_function, velocity_gradients, vorticity
from tisph.measures.metrics import with_reference
from tisph.scenes._views import MovieView, Profile


@dataclass(frozen=True)
class Colour:
    """``of`` takes the quantity from a scene and a snapshot, array (particles,); ``unit`` is a kind of unit.

    ``signed``: whether it takes both signs. ``fields`` are those of the snapshot that it needs beside places,
    velocities and shear stress.
    """

    words: str
    unit: str
    of: Callable
    signed: bool = True
    fields: tuple[str, ...] = ()


def _shear_stress(scene, snapshot):
    """Return that of the polymer, or without one mu (du/dy + dv/dx)."""
    if scene.polymer:
        return snapshot.stress_xy
    gradients = velocity_gradients(scene, snapshot, degree=2)
    return scene.dynamic_viscosity * (gradients[1] + gradients[2])


def _conformation_trace(scene, snapshot):
    """Return tr A of a polymer whose stress S is the modulus G times A - 1: 2 + (S_xx + S_yy)/G in the plane.

    In axisymmetric flow tr A = 3 + (S_xx + S_yy + S_tt)/G, with the stress around the axis.
    """
    viscosity = (1.0 - scene.polymer.solvent_fraction) * scene.dynamic_viscosity
    plane = 2.0 + (snapshot.stress_xx + snapshot.stress_yy) * scene.polymer.relaxation_time / viscosity
    return plane + 1.0 + snapshot.stress_tt * scene.polymer.relaxation_time / viscosity if scene.axisymmetric else plane


def _error(scene, snapshot):
    """Return |u - u_exact|; a component of which no reference is known should be 0."""
    names = [name for name in ("u", "v", "w") if getattr(snapshot, name) is not None]
    exact = with_reference(scene, snapshot, [name for name in names if name in scene.fields]).reference
    return np.linalg.norm([getattr(snapshot, name) - exact.get(name, 0.0) for name in names], axis=0)


def _speed(snapshot):
    speed = np.hypot(snapshot.u, snapshot.v)
    return speed if snapshot.w is None else np.hypot(speed, snapshot.w)


_NORMAL = ("stress_xx", "stress_yy")

COLOURS = {
    "speed": Colour("speed", "velocity", lambda _, snapshot: _speed(snapshot), signed=False),
    "u": Colour("u", "velocity", lambda _, snapshot: snapshot.u),
    "v": Colour("v", "velocity", lambda _, snapshot: snapshot.v),
    "swirl": Colour("swirl", "velocity", lambda _, snapshot: snapshot.w),
    "stream_function": Colour("stream function", "flow_rate", stream_function),
    "vorticity": Colour("vorticity", "rate", lambda scene, snapshot: vorticity(scene, snapshot, degree=2)),
    "pressure": Colour("pressure", "stress", lambda _, snapshot: snapshot.pressure, fields=("pressure",)),
    "shear_stress": Colour("shear stress", "stress", _shear_stress),
    "normal_stress_difference": Colour(
        "N1", "stress", lambda _, snapshot: snapshot.stress_xx - snapshot.stress_yy, fields=_NORMAL
    ),
    "conformation_trace": Colour(
        "trace of the conformation tensor", "number", _conformation_trace, signed=False, fields=_NORMAL
    ),
    "error": Colour("error of the velocity", "velocity", _error, signed=False),
}
"""By the names that ``output.video.color_by`` takes; dye is no quantity of the flow (``report/field.py``)."""


ERRORS = {"pressure": ("pressure", "p"), "shear_stress": ("stress_xy", "Sxy")}
"""Fields, with a name in words, whose error is written beside a movie of them; of others it is that of the velocity."""


def movie_view(scene, name, end):
    """Return what a movie to time ``end`` coloured by ``name`` shows, with the scene's own profile where it has one.

    The range is known before the run where that profile has an exact solution at all times.
    """
    colour, own = COLOURS[name], scene.movie_profiles()
    profile = own.get(name)
    of = profile.of if profile and colour.words != "speed" else lambda snapshot: colour.of(scene, snapshot)
    words = profile.name if profile and colour.unit == "stress" and name != "pressure" else colour.words
    return MovieView(
        name=words,
        signed=colour.signed,
        of=of,
        profile=profile or Profile(colour.words, colour.unit, own["speed"].line, of),
        ends=scene.movie_ends(name, profile, end) if profile and profile.exact and "u" in scene.fields else None,
        error=ERRORS[name] if ERRORS.get(name, ("",))[0] in scene.fields else None,
    )
