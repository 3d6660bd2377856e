"""What is looked at between two cylinders: profiles over the radius, torques, the movie, and in words what it is."""

import math

import numpy as np

from tisph.scenes import _two_dimensional
from tisph.scenes._views import ExtraSeries, Profile, Radius, TimeSeries

MINUS = "\N{MINUS SIGN}"


def scales(scene, gap, speed, known=True):
    """Pairs (label, text) of a flow between radii; in words, the ``gap`` H and the cause of the ``speed`` U."""
    if scene.given_velocity:
        speed, known = "given by the config", True
    about, digits = ("", 6) if known else ("about ", 2)
    length, time = scene.units.length, scene.units.time
    return [
        ("Reynolds number", f"{about}{scene.reynolds:.{digits}g}  (U H / nu)"),
        (scene.velocity_name("speed U"), f"{about}{scene.reference_velocity:.{digits}g} {length}/{time}, {speed}"),
        ("length H", f"{scene.reference_length:.6g} {length}, {gap}"),
        ("kinematic viscosity nu", f"{scene.kinematic_viscosity:.6g} {length}^2/{time}"),
        ("radii", f"{scene.inner_radius:.6g} and {scene.outer_radius:.6g} {length}"),
        ("viscous time", f"{scene.viscous_time:.6g} {time}  (H^2 / nu)"),
    ]


def parameters(annulus):
    """Pairs (label, text) of what the flow is, independent of particles."""
    lines = scales(annulus, "the gap", "of the fastest wall")
    if annulus.polymer:
        elasticity = annulus.polymer.relaxation_time / annulus.viscous_time
        lines.append(("Weissenberg number", f"{annulus.weissenberg:.4g}  (relaxation time * U / H)"))
        lines.append(("elasticity number", f"{elasticity:.4g}  (relaxation time * nu / H^2)"))
    return lines


def profiles(annulus):
    """Velocity around the axis, and pressure; with polymer also its shear stress and first normal difference N1."""
    common = [_velocity(annulus), _two_dimensional.pressure_profile(annulus, _radius(annulus))]
    return [*common, _shear_stress(annulus), _normal_stress(annulus)] if annulus.polymer else common


def time_series(annulus):
    """Torques on the cylinders."""
    inner = 2 * math.pi * annulus.inner_radius**2
    scale = inner * annulus.dynamic_viscosity * annulus.reference_velocity / annulus.reference_length
    return TimeSeries(
        content="torque of the fluid on the cylinders over time t",
        name="torque per length",
        unit="torque",
        scale=scale,
        columns=["torque_inner", "torque_outer"],
        labels=[("inner cylinder", None), ("outer cylinder", None)],
        exact_columns=["torque_inner_exact", "torque_outer_exact"],
        measure=lambda snapshot: snapshot.bodies.torque,
        exact=lambda times: np.stack(annulus.exact_torques(np.asarray(times)), axis=1),
        angular_frequency=max(annulus.inner.angular_frequency, annulus.outer.angular_frequency),
    )


def extra_series(annulus):
    """N1 of the polymer at the inner and the outer cylinder, with its reference."""
    columns = ["n1_inner", "n1_outer"]

    def measure(snapshot):
        found = snapshot.bodies.normal_stress
        return np.full(2, np.nan) if found is None else found

    return ExtraSeries(
        columns=columns,
        measure=measure,
        final_columns=[f"{name}_exact" for name in columns],
        final=lambda times, values: annulus.exact_normal_stress(times).T,
    )


def movie_profiles(annulus):
    """Velocity around the axis, vorticity and pressure over the radius, and the stresses of a polymer."""
    pressure = _two_dimensional.pressure_profile(annulus, _radius(annulus))
    vorticity = _two_dimensional.vorticity_profile(annulus, _radius(annulus))
    flow = {"speed": _velocity(annulus), "vorticity": vorticity, "pressure": pressure}
    if not annulus.polymer:
        return flow
    return {**flow, "shear_stress": _shear_stress(annulus), "normal_stress_difference": _normal_stress(annulus)}


def movie_ends(annulus, name, profile, end):
    """Smallest and largest value of a ``profile`` to time ``end``.

    Where a wall starts, the vorticity is infinite at first: its values are those in a layer a quarter of the gap deep,
    or half-way through the run.
    """
    first = annulus.start_time
    if name == "vorticity":
        first = max(first, min(annulus.viscous_time / 16, 0.5 * (first + end)))
    return profile.extremes(first, end)


def _radius(annulus):
    return Radius(ends=(annulus.inner_radius, annulus.outer_radius), place=annulus.centre)


def _velocity(annulus):
    scale = (annulus.reference_velocity, annulus.velocity_name("speed of the fastest wall"))
    return Profile("u_θ", "velocity", _radius(annulus), of=annulus.around, exact=annulus.exact_around, scale=scale)


def _shear_stress(annulus):
    return Profile(
        name="polymer shear stress Srθ",
        unit="stress",
        line=_radius(annulus),
        of=lambda snapshot: annulus.polymer_stress(snapshot)[0],
        exact=lambda x, y, t: annulus.exact_polymer_stress(x, y, t)[1],
    )


def _normal_stress(annulus):
    def exact(x, y, t):
        around, _, along = annulus.exact_polymer_stress(x, y, t)
        return around - along

    return Profile(
        name=f"first normal stress difference N1 = Sθθ {MINUS} Srr",
        unit="stress",
        line=_radius(annulus),
        of=lambda snapshot: annulus.polymer_stress(snapshot)[1],
        exact=exact,
    )
