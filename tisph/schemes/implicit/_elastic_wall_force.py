"""``_wall_force.py`` for a liquid with memory: the solvent's stress, and that which the particles carry."""

import numpy as np

from tisph.schemes.implicit._wall_force import WallForce


class ElasticWallForce(WallForce):
    """Fits the mean velocities and stresses of a step of a ``ViscoelasticStep``."""

    def stress(self, shear_rate):
        """Return the mean shear stress over the density, of solvent and polymer, of the particles near walls."""
        return self.channel.solvent_viscosity * shear_rate + self.viscous.stages.mean_stress[self.ghosts.near]

    def pulls(self, differences, stages):
        """Return what images beyond the (bottom, top) wall do; see ``WallForce.pulls``."""
        ghosts, stress = self.ghosts, self.viscous.stages.mean_stress
        series = sum(weight * np.array(self.viscous.walls.stress_series(moment)) for weight, moment in stages)
        more = sum(self.viscous.solver.more(side, *series[side]) for side in range(2))
        images = self.viscous.solver.lay(stress, 1.0) + more
        # rows of a first derivative are odd: what pairs of particles leave of each other is the row sum over the images
        both = images[ghosts.listed] + stress[ghosts.near[ghosts.row]]
        solvent = self.channel.solvent_viscosity * ghosts.sums(self.operators.laplacian, differences)[1]
        return solvent + ghosts.sums(self.operators.d_dy, both)[1]
