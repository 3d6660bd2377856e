"""What inelastic laws share: a viscosity that depends on the shear rate."""

from typing import ClassVar

from tisph import registry
from tisph.config.base import Model


class Parameters(Model):
    """Base of their parameters."""

    carries_stress: ClassVar[bool] = False

    def law(self, viscosity, density):
        """``Law`` of a fluid with these parameters; ``viscosity`` is that of ``fluid``, over the ``density``."""
        return registry.load("rheology", self.type).Law(self, viscosity, density)
