"""The stages that walls ask for: of given velocities, or one of them driven by a stress, without a mass or with one."""

from tisph.schemes.implicit._elastic_stages import ElasticStages
from tisph.schemes.implicit._elastic_walls import ElasticWalls
from tisph.schemes.implicit._heavy import HeavyWalls
from tisph.schemes.implicit._heavy_stages import HeavyStages
from tisph.schemes.implicit._plate import PlateWalls
from tisph.schemes.implicit._plate_stages import PlateStages


def stages(operators, channel, treatment, memory):
    """Return the ``ElasticStages`` of a ``channel``, with their walls."""
    side = channel.driven_side
    if side is None:
        kinds = ElasticWalls, ElasticStages
    elif slides_freely(channel, side):
        kinds = PlateWalls, PlateStages
    else:
        kinds = HeavyWalls, HeavyStages
    walls, kind = kinds
    return kind(operators, channel, walls(channel, treatment, memory), memory)


def slides_freely(channel, side):
    """Tell whether a wall is driven by a stress and has no mass."""
    wall = (channel.bottom, channel.top)[side]
    return wall.driven and wall.mass_per_area == 0.0
