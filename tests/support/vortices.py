"""Taylor-Green vortices for tests: a config that is good, and snapshots of the exact flow, no simulation."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from tisph.scenes.taylor_green import Scene
from tisph.snapshot import Snapshot

GOOD = """\
scene: taylor_green
fluid: {density: 2.0, kinematic_viscosity: 0.01}
geometry: {length: 1.0}
initial: {velocity: 1.0, jitter: 0.2}
discretisation: {particles_across: 20}
time: {end: 2.0, samples: [0.5, 2.0]}
"""


def make_scene(across=20, cells=(1, 1), **changes) -> Scene:
    settings = {"length": 1.0, "speed": 1.0, "density": 2.0, "kinematic_viscosity": 0.01, **changes}
    columns, rows = (number * across for number in cells)
    units = SimpleNamespace(length="m", mass="kg", time="s")
    spacing = settings["length"] / across
    return Scene(**settings, cells=cells, spacing=spacing, columns=columns, rows=rows, units=units)


def make_snapshot(scene, t=0.5, jitter=0.2, **changes) -> Snapshot:
    """Displaced particles with the exact flow; ``changes`` are added to its fields."""
    x, y = scene.jittered(0, jitter)
    fields = {name: scene.exact(name, x, y, t) for name in scene.fields}
    fields = {name: values + changes.get(name, 0.0) for name, values in fields.items()}
    return Snapshot(t=t, step=7, x=x, y=y, density=np.full_like(x, scene.density), **fields)


def scaled(snapshot, factor) -> Snapshot:
    """``snapshot`` with ``factor`` times its velocities."""
    return replace(snapshot, u=factor * snapshot.u, v=factor * snapshot.v)


def crowded(scene, t=0.5, crowding=0.6) -> Snapshot:
    """Particles with the exact flow, (1 + crowding)/(1 - crowding) times closer in the corners than in the middle.

    They are a lattice under the map s - crowding sin(2 pi s)/(2 pi) of both coordinates, whose derivatives give the
    areas: sums of smooth periodic functions times these areas are integrals but for rounding.
    """
    turn = 2.0 * np.pi * np.array(scene.lattice()) / scene.length
    x, y = scene.length / (2.0 * np.pi) * (turn - crowding * np.sin(turn))
    area = scene.spacing**2 * np.prod(1.0 - crowding * np.cos(turn), axis=0)
    fields = {name: scene.exact(name, x, y, t) for name in scene.fields}
    return Snapshot(t=t, step=7, x=x, y=y, density=np.full_like(x, scene.density), area=area, **fields)
