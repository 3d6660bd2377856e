"""What the laws of liquids without memory share: a viscosity that depends on the shear rate of the moment."""

from typing import ClassVar

from tisph import registry
from tisph.config.base import Model


class Parameters(Model):
    """Base of their parameters."""

    carries_stress: ClassVar[bool] = False

    def law(self, viscosity, density):
        """``Law`` of a liquid with these parameters; ``viscosity`` is that of ``fluid``, over the ``density``."""
        return registry.load("rheology", self.type).Law(self, viscosity, density)
