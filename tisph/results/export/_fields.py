"""The fields of a sample as other programs want them: vectors and tensors in one piece, in three dimensions."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tisph.results._samples import Sample

Field = tuple[str, np.ndarray, str]
"""Name, array (particles,) or (particles, components), unit."""

STRESS = ("stress_xx", "stress_yy", "", "stress_xy", "", "")
"""A symmetric tensor in the order of VTK: xx, yy, zz, xy, yz, xz; the plane has no others."""


def places(sample: "Sample") -> np.ndarray:
    """Return the positions, an array (particles, 3), z being 0."""
    return _together(sample, ("x", "y", ""))


def fields(sample: "Sample") -> Iterator[Field]:
    """Yield what a sample has of its particles, and of the reference at each, whose names end in ``_exact``."""
    units = sample.units
    yield "particle", np.arange(len(sample["x"])), ""
    for suffix in ("", "_exact"):
        for name, parts in (("velocity", ("u", "v", "")), ("stress", STRESS)):
            if parts[0] + suffix in units:
                here = tuple(part and part + suffix for part in parts)
                yield name + suffix, _together(sample, here), units[here[0]]
        for name in ("pressure" + suffix, "density" + suffix):
            if name in units:
                yield name, sample[name].astype(float), units[name]


def columns(sample: "Sample") -> dict[str, np.ndarray]:
    """Return every array of the particles by its name, positions first."""
    names = [name for name in sample if "/" not in name]
    return {name: sample[name] for name in sorted(names, key=lambda name: (name not in ("x", "y"), name))}


def _together(sample: "Sample", parts: tuple[str, ...]) -> np.ndarray:
    """Return the arrays named ``parts`` as columns, zeros where there is no name or no such array."""
    nothing = np.zeros(len(sample["x"]))
    return np.stack([sample[part].astype(float) if part in sample.units else nothing for part in parts], axis=1)
