"""The law of ``oldroyd_b.py`` for the explicit scheme, whose particles carry the stress S, not the conformation."""

from tisph.measures.channel import ChannelFlow
from tisph.runtime import scalar, ti


@ti.data_oriented
class Stress:
    """The law of the polymer stress that particles carry: (xx, xy, yy) over the reference density."""

    def __init__(self, channel: ChannelFlow) -> None:
        assert channel.polymer
        self.relaxation_rate = scalar(1.0 / channel.polymer.relaxation_time)
        self.modulus = scalar(channel.polymer_viscosity / channel.polymer.relaxation_time)

    @ti.func
    def rate(self, stress, gradient):
        """Return dS/dt = L S + S L^T - S/lambda + G (L + L^T) for L = ``gradient``, with G = eta_p/lambda."""
        return self.stretched(stress, gradient) - self.relaxation_rate[None] * stress + self.strained(gradient)

    @ti.func
    def stretched(self, stress, gradient):
        """Return L S + S L^T: the deformation of existing stress."""
        xx, xy, yy = stress[0], stress[1], stress[2]
        return ti.Vector(
            [
                2.0 * (gradient[0, 0] * xx + gradient[0, 1] * xy),
                gradient[0, 1] * yy + gradient[1, 0] * xx + (gradient[0, 0] + gradient[1, 1]) * xy,
                2.0 * (gradient[1, 0] * xy + gradient[1, 1] * yy),
            ]
        )

    @ti.func
    def strained(self, gradient):
        """Return G (L + L^T): the stress that the deformation creates."""
        shear = gradient[0, 1] + gradient[1, 0]
        return self.modulus[None] * ti.Vector([2.0 * gradient[0, 0], shear, 2.0 * gradient[1, 1]])
