"""The fields of particles as other programs want them: vectors and tensors in one piece, in three dimensions."""

from collections.abc import Iterator, Mapping
from typing import Protocol

import numpy as np

from tisph.measures.fits import vorticity
from tisph.snapshot import OPTIONAL

Field = tuple[str, np.ndarray, str]
"""Name, array (particles,) or (particles, components), unit."""

STRESS = ("stress_xx", "stress_yy", "", "stress_xy", "", "")
"""A symmetric tensor in the order of VTK: xx, yy, zz, xy, yz, xz; the plane has no others."""


class Particles(Protocol):
    """Arrays (particles,) by the names of ``samples.h5``, at time ``t``; ``units`` has every name that there is."""

    @property
    def t(self) -> float:
        """Time."""

    @property
    def units(self) -> Mapping[str, str]:
        """Unit by name."""

    def __getitem__(self, name: str) -> np.ndarray: ...


class Arrays(dict):
    """Arrays of a snapshot named as in ``samples.h5``, and of two-dimensional flow ``vorticity``, with ``units``.

    ``about`` is the ``Description`` of the run.
    """

    def __init__(self, about, snapshot):
        found = {name: getattr(snapshot, name) for name in ("x", "y", "u", "v", "density", "pressure", *OPTIONAL)}
        found |= {f"{name}_exact": values for name, values in (snapshot.reference or {}).items()}
        super().__init__({name: values for name, values in found.items() if values is not None and len(values)})
        self.t = snapshot.t
        if not about.scene.parallel:
            self["vorticity"] = vorticity(about.scene, snapshot)
        self.units = {name: about.units.get(name.removesuffix("_exact"), "") for name in self}


def places(particles: Particles) -> np.ndarray:
    """Return the positions, an array (particles, 3), z being 0."""
    return _together(particles, ("x", "y", ""))


def fields(particles: Particles) -> Iterator[Field]:
    """Yield what there is of the particles, and of the reference at each, whose names end in ``_exact``."""
    units = particles.units
    yield "particle", np.arange(len(particles["x"])), ""
    for suffix in ("", "_exact"):
        for name, parts in (("velocity", ("u", "v", "w")), ("stress", STRESS)):
            if parts[0] + suffix in units:
                here = tuple(part and part + suffix for part in parts)
                yield name + suffix, _together(particles, here), units[here[0]]
        for name in ("pressure" + suffix, "density" + suffix, "vorticity" + suffix):
            if name in units:
                yield name, particles[name].astype(float), units[name]


def _together(particles: Particles, parts: tuple[str, ...]) -> np.ndarray:
    """Return the arrays named ``parts`` as columns, zeros where there is no name or no such array."""
    nothing = np.zeros(len(particles["x"]))
    return np.stack([particles[part].astype(float) if part in particles.units else nothing for part in parts], axis=1)
