"""How thin the layers are in which the exact flow of a channel changes from one velocity to another.

What starts or changes at t = 0, a wall or the drive of a fluid at rest, diffuses into the fluid to the depth
sqrt(nu t). A wall that oscillates moves a layer that counts with half its penetration depth, sqrt(nu/(2 w)): with so
many spacings its error is that of one that diffuses (``benchmarks/resolution.py``). In a fluid with polymer what starts
is at first the front of a shear wave, see ``Polymer.diffusive_fraction``.
"""

import math

from tisph.scenes._layers import age


def thinnest_layer(channel, t):
    """Depth [length] of the thinnest layer at time ``t`` on the run's clock, and where it is, in words.

    Infinite, and nothing, in a developed flow that goes on as it was.
    """
    ages = {name: _age(channel, wall, t) for name, wall in _walls(channel)}
    layers, since = [], min(ages.values())
    if since < math.inf:
        names = [name for name, time in ages.items() if time < math.inf]
        place = f"the layer at the {names[0]} wall" if len(names) == 1 else "the layer at each wall"
        share = channel.polymer.diffusive_fraction(since) if channel.polymer else 1.0
        depth = math.sqrt(share * channel.kinematic_viscosity * since)
        in_the_fluid = share < 1.0 and channel.elastic_speed * since > depth
        layers.append((depth, "the front of the shear wave" if in_the_fluid else place))
    for name, wall in _walls(channel):
        if wall.oscillates:
            half = 0.5 * wall.penetration_depth(channel.kinematic_viscosity)
            layers.append((half, f"the layer at the oscillating {name} wall"))
    return min(layers, default=(math.inf, ""))


def _walls(channel):
    return (("bottom", channel.bottom), ("top", channel.top))


def _age(channel, wall, t):
    """Time at ``t`` since what drives the fluid at a wall has jumped; infinite where it never has."""
    if channel.starts_developed:
        return t if wall.before is not None and wall.before != wall.cosine else math.inf
    still = not (wall.oscillates or wall.stress_controlled or wall.cosine)
    found = math.inf if still else age(wall, t)
    return min(found, t) if channel.acceleration else found
