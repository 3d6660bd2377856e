"""How thin the layers are in which the exact flow of a channel changes from one velocity to another.

What starts or changes at t = 0, a wall or the drive of a fluid at rest, diffuses into the fluid to the depth
sqrt(nu t). A wall that oscillates moves a layer that counts with half its penetration depth, sqrt(nu/(2 w)): with so
many spacings its error is that of one that diffuses (``benchmarks/resolution.py``). In a fluid with polymer what starts
is at first the front of a shear wave, see ``Polymer.diffusive_fraction``.
"""

import math


def thinnest_layer(channel, t):
    """Depth [length] of the thinnest layer at time ``t`` on the run's clock, and where it is, in words.

    Infinite, and nothing, in a developed flow that goes on as it was.
    """
    started = {name: _has_started(channel, wall) for name, wall in _walls(channel)}
    layers = []
    if any(started.values()):
        names = [name for name, has in started.items() if has]
        place = f"the layer at the {names[0]} wall" if len(names) == 1 else "the layer at each wall"
        jumps = [time for _, wall in _walls(channel) for time in wall.jump_times if time < t]
        since = t - max(jumps, default=0.0)
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


def _has_started(channel, wall):
    """Whether velocity or acceleration of the fluid at a wall has jumped at t = 0."""
    if channel.starts_developed:
        return wall.before is not None and wall.before != wall.cosine
    return wall.oscillates or wall.stress_controlled or wall.cosine != 0.0 or channel.acceleration != 0.0
