"""What is looked at in axisymmetric flow: profiles over the radius, and in words what it is."""

import numpy as np

from tisph.scenes._annulus.views import scales
from tisph.scenes._axisymmetric import measures
from tisph.scenes._views import Line, Profile, TimeSeries

NAMES = {"u": "u", "v": "u_r", "w": "u_θ"}
"""Velocities along the axis, along radii and around the axis, as pictures call them."""


def parameters(scene, length=None, cause=None):
    """Pairs (label, text) of the flow, independent of particles; in words, the ``length`` H and the ``cause`` of U.

    Without a cause U is that of the fastest wall, or an estimate.
    """
    length = length or ("the difference of the radii" if scene.inner_radius else "the radius")
    if scene.reference_velocity == scene.fastest_wall:
        cause = "of the fastest wall or body"
    return scales(scene, length, cause or "an estimate: by load or drive, in a Newtonian fluid", cause is not None)


def across(scene, place=None):
    """The line over the radius at ``place`` along the axis, with the particles half a spacing around it, or all."""
    ends = scene.inner_radius, scene.outer_radius
    return Line("y", ends, 0.0) if place is None else Line("y", ends, place, 0.5 * scene.spacing)


def velocity(scene, field, line, **reference):
    """The Profile of a velocity, the ``field`` u, v or w, on a ``line``."""
    return Profile(NAMES[field], "velocity", line, of=lambda snapshot: getattr(snapshot, field), **reference)


def loads_series(scene, columns, **others):
    """The TimeSeries of loads on walls, the ``columns`` of ``measures.loads``; ``others`` are of its fields."""
    area = 2.0 * np.pi * scene.outer_radius * scene.length
    force = area * scene.dynamic_viscosity * scene.reference_velocity / scene.reference_length
    kinds = [("force", "whole_force") if name.startswith("force") else ("torque", "moment") for name in columns]

    def measure(snapshot):
        loads = measures.loads(scene, snapshot)
        return np.array([loads[name] for name in columns])

    labels = [(name.replace("_", " on ", 1), None) for name in columns]
    return TimeSeries(
        content="forces along the axis and torques around it of the fluid on the walls",
        name=kinds[0][0],
        unit=kinds[0][1],
        scale=force,
        columns=list(columns),
        measure=measure,
        sizes=[force if kind == "force" else force * scene.outer_radius for kind, _ in kinds],
        panels=kinds,
        **{"labels": labels} | others,
    )


def only_first(series):
    """Of a TimeSeries of loads those of the first kind."""
    return series.only(series.name, series.name, series.unit)
