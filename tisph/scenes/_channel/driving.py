"""What moves the walls of a channel: motions that a config gives, or stresses, and what that means for the flow."""

from tisph.geometry.schedule import Schedule
from tisph.geometry.stress_controlled import StressControlledMotion, StressControlledWall
from tisph.scenes._motion import WallMotion


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
