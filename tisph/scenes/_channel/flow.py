"""Reference flow in a channel: solved for once, by tisph.exact.start_up."""

from functools import lru_cache

from tisph.exact.start_up import Flow, InelasticFluid, StartUp, ViscoelasticFluid, Wall


class ReferenceFlow:
    """Flow of a ``scene.Channel``: from rest, or, where it is ``developed``, on from what had developed before t = 0.

    Heights ``y`` and times ``t`` broadcast.
    """

    def __init__(self, channel):
        self.channel = channel
        walls = [
            each.over(channel.density) if each.stress_controlled else each for each in (channel.bottom, channel.top)
        ]
        flow = Flow(channel.gap, *walls, channel.acceleration)
        before = Flow(channel.gap, *_walls_before(channel), channel.acceleration) if channel.starts_developed else None
        self._solved = _solved(channel.rheology, channel.kinematic_viscosity, channel.density, flow, before)

    def velocity(self, y, t):
        """Velocity along x."""
        return self._solved.velocity(y, t)

    def shear_stress(self, y, t):
        """Shear stress of solvent and polymer; infinite at the moment in which a wall jumps, on that wall."""
        return self.channel.density * self._solved.shear_stress(y, t)

    def polymer_stress(self, y, t):
        """ViscoelasticFluid stresses (S_xx, S_xy), 0 without polymer."""
        xx, xy, _ = self.channel.density * self._solved.polymer_stress(y, t)
        return xx, xy

    def polymer_shear_stress(self, y, t):
        """ViscoelasticFluid stress S_xy alone."""
        return self.polymer_stress(y, t)[1]

    def transverse_stress(self, y, t):
        """ViscoelasticFluid stress S_yy."""
        return self.channel.density * self._solved.polymer_stress(y, t)[2]

    def conformation_excess(self, y, t):
        """C of each mode at heights ``y`` and a time ``t``: list of arrays (components, heights)."""
        return self._solved.conformation_excess(y, t)


def _walls_before(channel):
    """The walls (bottom, top) before t = 0 of a flow that had developed then; one that oscillates does so for long."""
    for wall in (channel.bottom, channel.top):
        yield wall if wall.oscillates else Wall(wall.cosine if wall.before is None else wall.before)


@lru_cache(maxsize=8)
def _solved(rheology, kinematic_viscosity, density, flow, before):
    if rheology is None:
        return StartUp(ViscoelasticFluid(kinematic_viscosity, ()), flow, before)
    if rheology.carries_stress:
        solvent = rheology.solvent_fraction * kinematic_viscosity
        return StartUp(ViscoelasticFluid(solvent, rheology.laws(kinematic_viscosity)), flow, before)
    return StartUp(InelasticFluid(rheology.law(kinematic_viscosity, density), kinematic_viscosity), flow, before)
