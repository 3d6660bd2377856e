"""Reference flow in a channel: solved for once, by tisph.exact.start_up."""

from functools import lru_cache

from tisph.exact.start_up import Flow, StartUp, Wall, fluid_of


def reference_flow(channel):
    """The ``StartUp`` from rest, or, where it is ``developed``, on from what had developed before t = 0."""
    walls = [each.over(channel.density) if each.stress_controlled else each for each in (channel.bottom, channel.top)]
    flow = Flow(channel.gap, *walls, channel.acceleration)
    before = Flow(channel.gap, *_walls_before(channel), channel.acceleration) if channel.starts_developed else None
    return _solved(channel.rheology, channel.kinematic_viscosity, channel.density, flow, before)


def _walls_before(channel):
    """The walls (bottom, top) before t = 0 of a flow that had developed then; one that oscillates does so for long."""
    for wall in (channel.bottom, channel.top):
        yield wall if wall.oscillates else Wall(wall.cosine if wall.before is None else wall.before)


@lru_cache(maxsize=8)
def _solved(rheology, kinematic_viscosity, density, flow, before):
    return StartUp(fluid_of(rheology, kinematic_viscosity, density), flow, before)
