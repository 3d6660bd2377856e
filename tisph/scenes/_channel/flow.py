"""The walls of a channel, by motions that a config gives or by stresses, and the reference flow that they drive.

That is solved for once, by ``exact/start_up.py``.
"""

from functools import lru_cache

from tisph.exact.start_up import Flow, StartUp, Wall, fluid_of
from tisph.geometry.schedule import Schedule
from tisph.geometry.stress_controlled import StressControlledMotion, StressControlledWall
from tisph.scenes._motion import WallMotion


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


def wall(config):
    """The motion of a wall of a config, or the plate that it is."""
    if config.velocities:
        return Schedule(config.times, config.velocities)
    return StressControlledWall.from_config(config) if config.stress_controlled else WallMotion.from_config(config)


def largest_speed(channel, wall):
    """That of a wall; of a stress-controlled one, the speed at which a Newtonian fluid would bear the stress."""
    if wall.stress_controlled:
        return wall.largest_stress * channel.gap / channel.dynamic_viscosity
    return wall.relative_to(channel.frame_velocity).largest_speed


def reference_motion(channel, wall):
    """The motion of a wall; of a stress-controlled one, as it moves in the reference."""
    if not wall.stress_controlled:
        return wall
    height = channel.gap * channel.driven_side
    return StressControlledMotion(wall, largest_speed(channel, wall), lambda t: channel.exact_velocity(height, t))
