"""Particle fields, double-buffered: a step reads one buffer and writes the other, and so does a sort."""

import numpy as np

from tisph.runtime import real, ti


@ti.data_oriented
class Particles:
    """Fluid particles 0 .. fluid-1, then wall particles.

    Each field has shape (2, ...): buffer ``now`` holds the present, buffer ``1 - now`` is written next.
    ``position``, ``velocity``, ``compression`` (density / reference density - 1, which keeps its digits in
    single precision) are the state at the end of a step, of fluid particles only. The ``mid_`` fields are
    the state in the middle of the coming step, which the neighbours read: fluid and walls.
    ``identity`` (fluid) is the number that a particle was created with; sorting permutes it along.

    With ``carries_stress`` there are also ``stress`` and ``mid_stress``: xx, xy, yy over the reference density.

    Wall slots up to ``mobile`` hold particles of their own that are sorted too (dummy particles); the rest,
    up to ``slots``, is room for images of fluid particles.
    """

    def __init__(self, fluid, dummies, images, carries_stress):
        self.fluid = fluid
        self.mobile = fluid + dummies
        self.slots = self.mobile + images
        vector = ti.types.vector(2, real())
        self.position = ti.field(vector, shape=(2, fluid))
        self.velocity = ti.field(vector, shape=(2, fluid))
        self.compression = ti.field(real(), shape=(2, fluid))
        self.mid_position = ti.field(vector, shape=(2, self.slots))
        self.mid_velocity = ti.field(vector, shape=(2, self.slots))
        self.mid_pressure = ti.field(real(), shape=(2, self.slots))
        self.mid_compression = ti.field(real(), shape=(2, fluid))
        self.identity = ti.field(ti.i32, shape=(2, fluid))
        self.carries_stress = carries_stress
        if carries_stress:
            tensor = ti.types.vector(3, real())
            self.stress = ti.field(tensor, shape=(2, fluid))
            self.mid_stress = ti.field(tensor, shape=(2, self.slots))

    def load(self, position, velocity, stress):
        """Fill buffer 0: uncompressed fluid at ``position`` with ``velocity``, arrays of shape (fluid, 2).

        ``stress`` (fluid, 3) is over the reference density, None where particles carry none.
        """
        self._fill(self.position, self.mid_position, position)
        self._fill(self.velocity, self.mid_velocity, velocity)
        if self.carries_stress:
            self._fill(self.stress, self.mid_stress, stress)
        self.compression.fill(0.0)
        self.mid_compression.fill(0.0)
        self.mid_pressure.fill(0.0)
        self.identity.from_numpy(np.tile(np.arange(self.fluid, dtype=np.int32), (2, 1)))

    def _fill(self, state, middle, values):
        state.from_numpy(np.stack([values, values]))
        everywhere = np.zeros((2, self.slots, values.shape[1]))
        everywhere[0, : self.fluid] = values
        middle.from_numpy(everywhere)

    def state(self, now):
        """Return position, velocity (fluid, 2), compression (fluid,), stress (fluid, 3) in the order of creation.

        The stress is None where particles carry none.
        """
        order = np.argsort(self.identity.to_numpy()[now])
        return (
            self.position.to_numpy()[now][order],
            self.velocity.to_numpy()[now][order],
            self.compression.to_numpy()[now][order],
            self.stress.to_numpy()[now][order] if self.carries_stress else None,
        )

    @ti.kernel
    def reorder(self, now: ti.i32, order: ti.template(), serial: ti.template()):
        """Copy buffer ``now`` into the other one so that slot k receives particle ``order[k]``."""
        ti.loop_config(serialize=serial)
        for k in range(self.mobile):
            source = order[k]
            self.mid_position[1 - now, k] = self.mid_position[now, source]
            self.mid_velocity[1 - now, k] = self.mid_velocity[now, source]
            self.mid_pressure[1 - now, k] = self.mid_pressure[now, source]
            if ti.static(self.carries_stress):
                self.mid_stress[1 - now, k] = self.mid_stress[now, source]
            if k < self.fluid:
                self.position[1 - now, k] = self.position[now, source]
                self.velocity[1 - now, k] = self.velocity[now, source]
                self.compression[1 - now, k] = self.compression[now, source]
                self.mid_compression[1 - now, k] = self.mid_compression[now, source]
                self.identity[1 - now, k] = self.identity[now, source]
                if ti.static(self.carries_stress):
                    self.stress[1 - now, k] = self.stress[now, source]
