"""Adami dummy particles: fixed wall layers whose velocity and pressure are kernel averages of the fluid.

u_w = 2 U_W - sum_f u_f W_wf / sum_f W_wf and p_w = sum_f (p_f + a_W . r_fw) W_wf / sum_f W_wf (Adami, Hu & Adams
2012, J. Comput. Phys. 231, eqs. 22, 23 and 27), p per unit density, a_W the acceleration of the wall, r_fw from the
dummy to the fluid particle. In a channel a_W is along the walls, where no pressure difference balances it, and is left
out. U_W and a_W are those of the nearest point of the wall: those of the dummy particle itself, as if the body were
seen there, would move the wall that the fluid feels where the body turns. The extrapolated velocity serves all
operators, also the divergence, where they take the velocity of the wall. Polymer stress is averaged like the pressure.
"""

from typing import Literal

from tisph.walls._parameters import WallParameters


class Parameters(WallParameters):
    """No parameters: the number of layers follows from the kernel support."""

    type: Literal["adami"] = "adami"
