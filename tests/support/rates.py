"""Imposed fields and the rates that follow from them, for tests of operators and walls."""

import numpy as np

from tisph.runtime import real, ti

LINEAR_EOS = "scheme.equation_of_state={type: tait, gamma: 1, sound_speed: 5.0}"
"""Override for an equation of state that is linear, with sound speed 5."""


def slots_in_use(scheme):
    """Return the slots of the fluid and of the wall particles."""
    first = scheme.particles.first_wall
    return np.r_[: scheme.particles.fluid, first : first + scheme.numbers()["particles_wall"]]


@ti.data_oriented
class RatesOf:
    """Evaluates the rates of every fluid particle of a scheme once, as arrays in the order of memory."""

    def __init__(self, scheme):
        self.scheme = scheme
        fluid = scheme.particles.fluid
        self.acceleration = ti.Vector.field(2, real(), shape=fluid)
        self.transport = ti.Vector.field(2, real(), shape=fluid)
        self.compression = ti.field(real(), shape=fluid)
        self.stress = ti.Vector.field(3, real(), shape=fluid)

    @ti.kernel
    def evaluate(self, now: ti.i32):
        for i in range(self.scheme.particles.fluid):
            rates = self.scheme.operators.rates(now, i)
            self.acceleration[i] = rates.acceleration
            self.transport[i] = rates.transport
            self.compression[i] = rates.compression
            if ti.static(self.scheme.particles.carries_stress):
                self.stress[i] = rates.stress

    def arrays(self):
        self.evaluate(self.scheme.now)
        return self.acceleration.to_numpy(), self.compression.to_numpy(), self.transport.to_numpy()


def impose(scheme, velocity, compression, stress=None):
    """Overwrite the mid-step fields of fluid and walls alike by functions of (x, y); gamma is 1 here.

    ``stress`` gives xx, xy, yy over the reference density. Returns x and y of the fluid.
    """
    particles, now = scheme.particles, scheme.now
    places = particles.mid_position.to_numpy()
    x, y = places[now, :-1].T
    fields = particles.mid_velocity.to_numpy()
    fields[now, :-1] = np.stack(np.broadcast_arrays(*velocity(x, y)), 1)
    particles.mid_velocity.from_numpy(fields)
    s = compression(x, y) + 0 * x
    pressures = particles.mid_pressure.to_numpy()
    pressures[now, :-1] = scheme.sound_speed**2 * s
    particles.mid_pressure.from_numpy(pressures)
    own = particles.mid_compression.to_numpy()
    own[now, : particles.fluid] = s[: particles.fluid]
    particles.mid_compression.from_numpy(own)
    if stress is not None:
        values = particles.mid_stress.to_numpy()
        values[now, :-1] = np.stack(np.broadcast_arrays(*stress(x, y)), 1)
        particles.mid_stress.from_numpy(values)
    return x[: particles.fluid], y[: particles.fluid]
