"""The effective viscosity of a suspension that walls shear: a mean over a run whose bodies never come to rest.

Stress over time is correlated: the statistical error of its mean is found from batch means. The values, evenly spaced
in time, are cut into ten batches in a row, whose means are taken to be independent of each other; the error of the mean
of all is their standard deviation over the square root of ten. Ten are enough (B. Schmeiser, Oper. Res. 30 (1982)
556-568), and long ones are less correlated: where a batch is shorter than bodies take to pass each other, a strain of
about one, the error is too small.
"""

import numpy as np

from tisph.errors import ConfigError
from tisph.measures._reading import Axes, Reading

BATCHES = 10
LEAST_STRAIN = 1.0
"""Of a batch, for an error that can be trusted."""

WAYS = {"walls": "by the stress on the walls", "bodies": "by the stresses of the bodies"}


def batch_means(values):
    """Return the mean of ``values`` (n,) and its standard error; the first n modulo ``BATCHES`` of them do not count.

    ConfigError where there are fewer than ``BATCHES``.
    """
    if len(values) < BATCHES:
        raise ConfigError(f"its history has {len(values)} lines to average over; there must be {BATCHES} at least")
    means = values[len(values) % BATCHES :].reshape(BATCHES, -1).mean(axis=1)
    return float(means.mean()), float(means.std(ddof=1) / np.sqrt(BATCHES))


def read_suspension(channel, table, contacts=None):
    """Return the ``Reading`` of a run of bodies that the flow carries between walls: means over its second half.

    ``table`` has the columns of its history by name, ``contacts`` is how often bodies touched, if it is known.
    """
    walls = dict(channel.walls)
    rate = float(walls["top"].cosine - walls["bottom"].cosine) / channel.extent[1]
    if any(wall.oscillates for wall in walls.values()) or not rate or "shear_stress_walls" not in table:
        raise ConfigError(
            "the viscosity of a suspension is read between walls of different, constant velocities, without a drive"
        )
    strain = abs(rate) * table["t"]
    late = strain > 0.5 * strain[-1]
    viscosity = channel.dynamic_viscosity * rate
    relative = {way: table[f"shear_stress_{way}"] / viscosity for way in WAYS if f"shear_stress_{way}" in table}
    found = {way: batch_means(values[late]) for way, values in relative.items()}
    solid = sum(body.shape.area for body in channel.bodies[: channel.count])
    fraction = solid / float(np.prod(channel.extent))
    dilute = 1.0 + 2.0 * fraction
    numbers = {"area_fraction": fraction, "strain": float(strain[-1]), "shear_rate": rate}
    for way, (mean, error) in found.items():
        numbers |= {f"relative_viscosity_{way}": mean, f"relative_viscosity_{way}_error": error}
    if "shear_stress_contacts" in table:
        numbers["relative_viscosity_contacts"] = float(np.mean(table["shear_stress_contacts"][late])) / viscosity
    if contacts is not None:
        numbers["contacts"] = contacts
    axis = Axes("strain", "viscosity over that of the fluid", ("number", "number"))
    styles = {"walls": ".", "bodies": "-"}
    curves = [(axis, WAYS[way], strain, values, styles[way]) for way, values in relative.items()]
    curves.append((axis, "Einstein, 1 + 2\N{GREEK SMALL LETTER PHI}", strain[[0, -1]], [dilute, dilute], "--"))
    return Reading("suspension in shear", _lines(numbers, found, dilute), numbers, curves)


def _lines(numbers, found, dilute):
    """Text of the ``numbers``; of a ``dilute`` suspension J. F. Brady, Int. J. Multiphase Flow 10 (1984) 113-114."""
    strain = numbers["strain"]
    lines = [
        f"area fraction phi = {numbers['area_fraction']:.4g}, shear rate {numbers['shear_rate']:.6g}",
        f"viscosity over that of the fluid, mean from strain {0.5 * strain:.4g} to {strain:.4g}:",
    ]
    lines += [f"  {WAYS[way]:32} {mean:.5g} +- {error:.2g}" for way, (mean, error) in found.items()]
    if "relative_viscosity_contacts" in numbers:
        lines.append(f"  {'of which contacts are':32} {numbers['relative_viscosity_contacts']:.3g}")
    lines.append(f"  {'Einstein, dilute: 1 + 2 phi':32} {dilute:.5g}")
    if "contacts" in numbers:
        lines.append(f"contacts in the whole run: {numbers['contacts']}")
    batch = 0.5 * strain / BATCHES
    if batch < LEAST_STRAIN:
        lines.append(f"unsure: errors are those of {BATCHES} batches of strain {batch:.2g}; run for {BATCHES * 2:g}")
    return lines
