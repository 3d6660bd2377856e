"""One explicit step as one kernel: evaluate in the middle, finish the pending step, predict the next middle."""

from tisph.runtime import scalar, ti


@ti.data_oriented
class Stepper:
    """The kernel that advances the particles, and the largest squares that it meets on the way.

    ``drift_squared``: displacement from where the lists expect a particle; ``speed_squared``,
    ``acceleration_squared``; ``stress_trace`` (where particles carry stress): polymer stress xx + yy.
    """

    def __init__(self, operators, walls, serial):
        self.operators, self.walls, self.serial = operators, walls, serial
        self.particles, self.lists, self.domain = operators.particles, operators.lists, operators.domain
        self.fluid = operators.fluid
        self.drift_squared = scalar(0.0)
        self.speed_squared = scalar(0.0)
        self.acceleration_squared = scalar(0.0)
        if self.fluid.carries_stress:
            self.stress_trace = scalar(0.0)

    @ti.kernel
    def step(self, now: ti.i32, dt: float, next_dt: float, elapsed: float, between: float):
        """Finish the pending step of ``dt`` and predict the middle of the one after it.

        ``elapsed``: time from the build of the lists to the new middle; ``between``: from middle to middle.
        """
        self.drift_squared[None] = 0.0
        self.speed_squared[None] = 0.0
        self.acceleration_squared[None] = 0.0
        half = 0.5 * next_dt
        if ti.static(self.fluid.carries_stress):
            self.stress_trace[None] = 0.0
        if ti.static(self.walls.tracks_walls):
            ti.loop_config(serialize=self.serial)
            for k in range(self.walls.track.count[None]):
                for top in ti.static(range(2)):
                    self.walls.track.follow(now, k, top, dt, half)
        ti.loop_config(serialize=self.serial)
        for i in range(self.particles.fluid_number[None]):
            self.advance(now, i, dt, half, elapsed)
        if ti.static(self.walls.has_dummies):
            ti.loop_config(serialize=self.serial)
            for number in range(self.particles.fluid_number[None], self.particles.mobile_number[None]):
                k = self.particles.slot(number)
                self.walls.advance(now, k, between)
                self.walls.extrapolate(1 - now, k)
        if ti.static(self.walls.tracks_walls):
            for top in ti.static(range(2)):
                self.walls.track.move(top, between)

    @ti.func
    def advance(self, now, i, dt, half, elapsed):
        """Finish the pending step of particle ``i``, publish its next middle, and measure."""
        rates = self.operators.rates(now, i)
        acceleration = rates.acceleration
        if ti.static(self.domain.has_body_force):
            acceleration.x += self.domain.acceleration[None]
        middle_velocity = self.particles.mid_velocity[now, i]
        position = self.particles.position[now, i] + dt * (middle_velocity + rates.transport)
        velocity = self.particles.velocity[now, i] + dt * acceleration
        compression = self.particles.compression[now, i] + dt * rates.compression
        self.particles.position[1 - now, i] = position
        self.particles.velocity[1 - now, i] = velocity
        self.particles.compression[1 - now, i] = compression
        self.particles.identity[1 - now, i] = self.particles.identity[now, i]

        position += half * (velocity + rates.transport)
        compression += half * rates.compression
        self.particles.mid_compression[1 - now, i] = compression
        next_velocity, pressure = velocity + half * acceleration, self.fluid.pressure(compression)
        if ti.static(self.fluid.carries_stress):
            stress = self.particles.stress[now, i] + dt * rates.stress
            self.particles.stress[1 - now, i] = stress
            self.walls.publish(1 - now, i, position, next_velocity, pressure, stress + half * rates.stress)
            ti.atomic_max(self.stress_trace[None], stress[0] + stress[2])
        else:
            self.walls.publish(1 - now, i, position, next_velocity, pressure, 0.0)
        drift = position - self.lists.built_position[i]
        if ti.static(self.lists.follows_shear):
            drift.x -= self.lists.reference_velocity[i] * elapsed
        ti.atomic_max(self.drift_squared[None], drift.dot(drift))
        ti.atomic_max(self.speed_squared[None], velocity.dot(velocity))
        ti.atomic_max(self.acceleration_squared[None], acceleration.dot(acceleration))
