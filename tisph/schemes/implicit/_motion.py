"""Positions of the particles, and how a step moves them."""

from tisph.runtime import real, ti


@ti.data_oriented
class Motion:
    """Positions (fluid), the kernels that move them, and positions and velocities (2, fluid) before the last step."""

    def __init__(self, field, shift):
        viscous = field.viscous
        self.field, self.domain = field, viscous.points.domain
        self.viscous, self.points, self.rows = viscous, viscous.points, viscous.rows
        self.shift = shift
        self.position, self.start_position = (self.points.field(ti.types.vector(2, real())) for _ in range(2))
        self.start_velocity = self.points.field(real(), 2)

    @ti.kernel
    def predict(self, half: float):
        """Put the points where the particles are in the middle of a step twice as long as ``half``."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.points.particles[None]):
            velocity = ti.Vector([self.viscous.velocity[0, i], self.viscous.velocity[1, i]])
            place = self.position[i] + half * velocity
            self.points.place[i] = [self.domain.wrapped(place.x), place.y]

    @ti.kernel
    def take_along(self, half: float):
        """Let positions and velocities follow the shift of the points: by the Taylor series of the velocities.

        A shift D in the middle of the step is one by D_x - ``half`` u_y D_y along the channel at its start.
        """
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.points.particles[None]):
            shift = self.shift.moved[i]
            if shift.x != 0.0 or shift.y != 0.0:
                place = self.points.place[i]
                shift.x -= half * self.field.slope[0, i].y * shift.y
                squares = ti.Vector([0.5 * shift.x * shift.x, shift.x * shift.y, 0.5 * shift.y * shift.y])
                for component in ti.static(range(2)):
                    change = self.field.slope[component, i].dot(shift) + self.field.curvature[component, i].dot(squares)
                    self.viscous.velocity[component, i] += change
                    place[component] -= half * self.viscous.velocity[component, i]
                self.position[i] = place

    @ti.kernel
    def move(self, length: float):
        """Move the particles over the step and take up the velocities at its end."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.points.particles[None]):
            mean = ti.Vector([0.0, 0.0])
            for component in ti.static(range(2)):
                end = self.viscous.end[component, i]
                mean[component] = 0.5 * (self.viscous.velocity[component, i] + end)
                self.start_velocity[component, i] = self.viscous.velocity[component, i]
                self.viscous.velocity[component, i] = end
            self.start_position[i] = self.position[i]
            place = self.position[i] + length * mean
            self.position[i] = [self.domain.wrapped(place.x), place.y]
