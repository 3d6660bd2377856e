"""Flow in a channel of a liquid without closed forms: solved for once, by tisph.exact.start_up."""

from functools import lru_cache

from tisph.exact.start_up import Flow, Polymer, StartUp, Viscous, Wall
from tisph.scenes._channel.flow import velocities_before


class SolvedFlow:
    """Flow of a ``scene.Channel`` with a ``rheology``; from rest, or, where it is settled, between steady walls."""

    def __init__(self, channel):
        self.channel = channel
        walls = [wall.over(channel.density) if wall.driven else wall for wall in (channel.bottom, channel.top)]
        flow = Flow(channel.gap, *walls, channel.acceleration)
        before = None
        if channel.settled:
            before = Flow(channel.gap, *map(Wall, velocities_before(channel)), channel.acceleration)
        liquid = channel.rheology, channel.kinematic_viscosity, channel.density
        self._solved = _solved(*liquid, flow, before)

    def velocity(self, y, t):
        """Velocity along x."""
        return self._solved.velocity(y, t)

    def shear_stress(self, y, t):
        """Shear stress of solvent and polymer; infinite at the moment in which a wall jumps, on that wall."""
        return self.channel.density * self._solved.shear_stress(y, t)

    def polymer_stress(self, y, t):
        """Polymer stresses (S_xx, S_xy), 0 without polymer."""
        xx, xy, _ = self.channel.density * self._solved.polymer_stress(y, t)
        return xx, xy

    def polymer_shear_stress(self, y, t):
        """Polymer stress S_xy alone."""
        return self.polymer_stress(y, t)[1]

    def transverse_stress(self, y, t):
        """Polymer stress S_yy."""
        return self.channel.density * self._solved.polymer_stress(y, t)[2]

    def deviations(self, y, t):
        """C of each mode at heights ``y`` and a time ``t``: list of arrays (components, heights)."""
        return self._solved.deviations(y, t)


@lru_cache(maxsize=8)
def _solved(rheology, kinematic_viscosity, density, flow, before):
    if rheology.carries_stress:
        solvent = rheology.solvent_fraction * kinematic_viscosity
        return StartUp(Polymer(solvent, rheology.laws(kinematic_viscosity)), flow, before)
    return StartUp(Viscous(rheology.law(kinematic_viscosity, density), kinematic_viscosity), flow, before)
