"""The walls of a channel, by motions that a config gives or by stresses, and the reference flow that they drive.

That is solved for once, by ``exact/start_up.py``.
"""

import math
from functools import lru_cache

from tisph.exact.start_up import Flow, StartUp, Wall, fluid_of
from tisph.exact.uniform_shear import UniformShear
from tisph.geometry.motion import Schedule, StressControlledMotion, StressControlledWall, WallMotion


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


def driven_mean_velocity(channel):
    """Mean velocity that the drive adds to the developed flow; None where the walls have a part in it.

    That is so at walls that a stress moves, and in a fluid that is not linear between walls of different velocities.
    """
    bottom, top, drive = channel.bottom, channel.top, channel.acceleration
    if bottom.stress_controlled or top.stress_controlled:
        return None
    if channel.rheology is None or channel.rheology.type == "oldroyd_b":
        return drive * channel.gap**2 / (12.0 * channel.kinematic_viscosity)
    if bottom.oscillates or top.oscillates or bottom.cosine != top.cosine:
        return None
    fluid = fluid_of(channel.rheology, channel.kinematic_viscosity, channel.density)
    return math.copysign(UniformShear(fluid.flux, fluid.laws).mean_velocity(abs(drive), channel.gap), drive)


def reference_motion(channel, wall):
    """The motion of a wall; of a stress-controlled one, as it moves in the reference."""
    if not wall.stress_controlled:
        return wall
    height = channel.gap * channel.driven_side
    return StressControlledMotion(wall, largest_speed(channel, wall), lambda t: channel.exact_velocity(height, t))
