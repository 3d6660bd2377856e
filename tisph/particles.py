"""Particle fields, double-buffered: a step reads one buffer and writes the other, and so does a sort."""

import numpy as np

from tisph.runtime import integer, real, ti, view
from tisph.size_class import size_class


@ti.data_oriented
class Particles:
    """Fluid particles in slots 0 .. fluid-1, wall particles from slot ``first_wall`` on.

    Each field has shape (2, ...): buffer ``now`` holds the present, buffer ``1 - now`` is written next.
    ``position``, ``velocity``, ``compression`` (density / reference density - 1, which keeps its digits in
    single precision) are the state at the end of a step, of fluid particles only. The ``mid_`` fields are
    the state in the middle of the coming step, which the neighbours read: fluid and walls.
    ``identity`` (fluid) is the number that a particle was created with; sorting permutes it along.

    With ``carries_stress`` there are also ``stress`` and ``mid_stress``: xx, xy, yy over the reference density.

    Wall slots hold either ``dummies``, particles of their own that are sorted too, or images of fluid particles, for
    which there is room up to ``slots``. Fields are larger than that, and where their parts begin is compiled in; how
    many particles there are is not: kernels read it from ``fluid_number`` and ``mobile_number`` (fluid and dummies).
    """

    def __init__(self, fluid, dummies, images, carries_stress):
        self.fluid, self.dummies = fluid, dummies
        self.has_dummies, self.has_walls = dummies > 0, dummies + images > 0
        self.fluid_number, self.mobile_number = integer(fluid), integer(fluid + dummies)
        self.first_wall = size_class(fluid)
        self.mobile_slots = self.first_wall + (size_class(dummies) if dummies else 0)
        self.slots = self.mobile_slots + (size_class(images) if images else 0)
        vector = ti.types.vector(2, real())
        self.position = self._state(vector)
        self.velocity = self._state(vector)
        self.compression = self._state(real())
        self.mid_compression = self._state(real())
        self.identity = self._state(ti.i32)
        beyond = self.first_wall + dummies + images
        self.mid_position = self._middle(vector, beyond)
        self.mid_velocity = self._middle(vector, beyond)
        self.mid_pressure = self._middle(real(), beyond)
        self.carries_stress = carries_stress
        if carries_stress:
            tensor = ti.types.vector(3, real())
            self.stress = self._state(tensor)
            self.mid_stress = self._middle(tensor, beyond)

    def _state(self, kind):
        field = ti.field(kind, shape=(2, self.first_wall))
        field.used = np.s_[:, : self.fluid]
        return field

    def _middle(self, kind, used):
        field = ti.field(kind, shape=(2, self.slots))
        field.used = np.s_[:, :used]
        return field

    def load(self, position, velocity, stress):
        """Fill new fields: uncompressed fluid at ``position`` with ``velocity``, arrays of shape (fluid, 2).

        ``stress`` (fluid, 3) is over the reference density, None where particles carry none.
        """
        view(self.position)[:, : self.fluid] = position
        view(self.mid_position)[0, : self.fluid] = position
        view(self.velocity)[:, : self.fluid] = velocity
        if self.carries_stress:
            view(self.stress)[:, : self.fluid] = stress
        view(self.identity)[:, : self.fluid] = np.arange(self.fluid)
        self.set_middle(0)

    def set_middle(self, now):
        """Let the middle of a step have the velocities and stresses of the state in buffer ``now``."""
        view(self.mid_velocity)[now, : self.fluid] = view(self.velocity)[now, : self.fluid]
        if self.carries_stress:
            view(self.mid_stress)[now, : self.fluid] = view(self.stress)[now, : self.fluid]

    def state(self, now):
        """Return position, velocity (fluid, 2), compression (fluid,), stress (fluid, 3) in the order of creation.

        The stress is None where particles carry none.
        """
        order = np.argsort(view(self.identity)[now, : self.fluid])
        return (
            view(self.position)[now][order],
            view(self.velocity)[now][order],
            view(self.compression)[now][order],
            view(self.stress)[now][order] if self.carries_stress else None,
        )

    def momentum(self, now):
        """Return the sum of the velocities along x, of the fluid."""
        return float(view(self.velocity)[now, : self.fluid, 0].astype(float).sum())

    @ti.func
    def slot(self, number):
        """Return the slot of mobile particle ``number``: the fluid comes first, then the dummies."""
        k = number
        if ti.static(self.has_dummies):
            fluid = self.fluid_number[None]
            k = ti.select(number < fluid, number, number - fluid + self.first_wall)
        return k

    @ti.kernel
    def reorder(self, now: ti.i32, order: ti.template(), serial: ti.template()):
        """Copy buffer ``now`` into the other one so that the n-th particle is that in slot ``order[n]``."""
        ti.loop_config(serialize=serial)
        for number in range(self.mobile_number[None]):
            k = self.slot(number)
            source = order[number]
            self.mid_position[1 - now, k] = self.mid_position[now, source]
            self.mid_velocity[1 - now, k] = self.mid_velocity[now, source]
            self.mid_pressure[1 - now, k] = self.mid_pressure[now, source]
            if ti.static(self.carries_stress):
                self.mid_stress[1 - now, k] = self.mid_stress[now, source]
            if k < self.first_wall:
                self.position[1 - now, k] = self.position[now, source]
                self.velocity[1 - now, k] = self.velocity[now, source]
                self.compression[1 - now, k] = self.compression[now, source]
                self.mid_compression[1 - now, k] = self.mid_compression[now, source]
                self.identity[1 - now, k] = self.identity[now, source]
                if ti.static(self.carries_stress):
                    self.stress[1 - now, k] = self.stress[now, source]
