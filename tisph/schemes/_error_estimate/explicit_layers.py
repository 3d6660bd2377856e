"""The explicit scheme on the layers of its start lattice, in continuous time.

Steps of the explicit scheme are so short that their own error does not count. With polymer the layers carry the shear
stress, and the walls its slope (``walls/_track.py``): all of it is linear in plane flow.
"""

import numpy as np

from tisph import registry
from tisph.schemes._error_estimate.images import image_shares
from tisph.schemes._error_estimate.linear_flow import LinearFlow
from tisph.schemes._error_estimate.stencils import banded, kernel_sums, sliding_viscosity

SLOPE = 1e-4
"""Of the gap: distance over which the slope of the initial stress at the walls is taken, as in ``walls/_track.py``."""


class ExplicitLayers:
    """Velocities of the ``rows`` layers of a channel at any time.

    ``images`` beyond each wall, at ``depths`` [length]; an extended field is one of layers with the images of both
    walls, (images + rows + images, ...), from below to above.
    """

    def __init__(self, config, channel):
        self.channel, self.rows = channel, channel.rows
        self.kernel = registry.load("kernels", config.discretisation.kernel)
        self.ratio = config.discretisation.smoothing_ratio
        self.standard = config.scheme.operators == "standard"
        laplacian, across = kernel_sums(self.kernel, self.ratio, self.standard)
        self.images = len(laplacian) // 2
        self.laplacian = banded(laplacian, self.rows) / channel.spacing**2
        self.across = banded(across, self.rows) / channel.spacing
        treatment = config.walls.treatment
        self.obeys_momentum = treatment.obeys_momentum
        self.shares, self.wall = image_shares(treatment, self.kernel, self.ratio, self.images, self.rows)
        self.depths = (np.arange(self.images) + 0.5) * channel.spacing
        self.heights = (np.arange(self.rows) + 0.5) * channel.spacing
        self.flow = (self._with_polymer if channel.polymer else self._newtonian)()

    def velocity(self, time):
        """Return the velocities (rows,) at ``time``."""
        return self.flow.at(time, self._viscosity_ratio(time))[: self.rows]

    def _viscosity_ratio(self, time):
        """Viscosity over the true one, of layers that have sheared by the mean shear of the flow."""
        if self.standard or self.channel.polymer:
            return 1.0
        profile = self.channel.exact_velocity(self.heights, time)
        rate = np.mean(np.abs(np.diff(profile))) / self.channel.spacing
        return sliding_viscosity(self.kernel, self.ratio, rate * (time - self.channel.start_time))

    def _extend(self, inside, bottom, top):
        """Return an extended field of ``inside`` (rows, ...) and images by layer (layers, ...)."""
        return np.concatenate([bottom[::-1], inside, top])

    def _beyond(self, bottom, top):
        """Return an extended field of images alone, of given values by layer."""
        return self._extend(np.zeros(self.rows), bottom, top)

    def _start(self):
        """Return the velocities at the start, with the impulse of walls that obey the momentum equation."""
        velocity = self.channel.initial_velocity(self.heights).astype(float)
        if self.obeys_momentum:
            bottom, top = (self.depths**2 * jump for jump in self.channel.wall_jumps)
            velocity += self.laplacian @ self._beyond(bottom, top)
        return velocity

    def _newtonian(self):
        channel, inside = self.channel, np.eye(self.rows)
        closed = self._extend(inside, -self.shares, -self.shares[:, ::-1])
        viscous = channel.kinematic_viscosity * self.laplacian
        steady, waves = np.zeros(self.rows), []
        for side, wall in enumerate((channel.bottom, channel.top)):
            other = np.zeros(self.images)
            driven = self._image_velocity(-channel.acceleration, 0.0 if wall.oscillates else wall.cosine)
            steady += viscous @ self._beyond(*((driven, other), (other, driven))[side])
            if wall.oscillates:
                amplitude = wall.cosine - 1j * wall.sine
                wave = self._image_velocity(1j * wall.angular_frequency * amplitude, amplitude)
                waves.append((wall.angular_frequency, viscous @ self._beyond(*((wave, other), (other, wave))[side])))
        drive = np.full(self.rows, channel.acceleration)
        mirror = np.arange(self.rows)[::-1], np.ones(self.rows)
        return LinearFlow(viscous @ closed, steady, waves, drive, self._start(), channel.start_time, mirror)

    def _image_velocity(self, relative_acceleration, velocity):
        """Return what a wall gives to its images, by layer."""
        values = self.wall * velocity
        if self.obeys_momentum:
            values = values + self.depths**2 * relative_acceleration / self.channel.solvent_viscosity
        return values

    def _with_polymer(self):
        """State: velocities and shear stresses of the rows, slopes of the stress at the bottom and the top wall."""
        channel, rows = self.channel, self.rows
        rate = 1.0 / channel.polymer.relaxation_time
        modulus = channel.polymer_viscosity * rate
        velocity, stress = self._extended_fields()
        viscous = channel.solvent_viscosity * self.laplacian
        size = 2 * rows + 2
        matrix = np.zeros((size, size))
        matrix[:rows] = viscous @ velocity + self.across @ stress
        matrix[rows:-2] = modulus * self.across @ velocity
        matrix[rows:-2, rows:-2] -= rate * np.eye(rows)
        solvent_rate = modulus / channel.solvent_viscosity
        matrix[-2:, -2:] = -(rate + solvent_rate) * np.eye(2)
        walls = self._beyond(
            *(self._image_velocity(-channel.acceleration, wall.cosine) for wall in (channel.bottom, channel.top))
        )
        steady = np.concatenate([viscous @ walls, modulus * self.across @ walls, [0.0, 0.0]])
        drive = np.concatenate([np.full(rows, channel.acceleration), np.zeros(rows + 2)])
        drive[-2:] = -solvent_rate * channel.acceleration if self.obeys_momentum else 0.0
        _, shear = channel.initial_polymer_stress(self.heights)
        shear, slopes = shear / channel.density, self._wall_slopes()
        if self.obeys_momentum:  # the impulse strains the polymer, see wcsph/_impulse.py
            displacements = self._beyond(*(self.depths**2 * jump for jump in channel.wall_jumps))
            shear = shear + solvent_rate * self.across @ displacements
            slopes = slopes + solvent_rate * np.array(channel.wall_jumps)
        start = np.concatenate([self._start(), shear, slopes])
        upside_down = np.arange(rows)[::-1]
        partner = np.concatenate([upside_down, rows + upside_down, [size - 1, size - 2]])
        mirror = partner, np.concatenate([np.ones(rows), -np.ones(rows), [1.0, 1.0]])
        return LinearFlow(matrix, steady, [], drive, start, channel.start_time, mirror)

    def _extended_fields(self):
        """Return extended velocities and stresses (extended rows, state) by the state."""
        rows, images = self.rows, self.images
        velocity, stress = np.zeros((2, rows + 2 * images, 2 * rows + 2))
        velocity[:, :rows] = self._extend(np.eye(rows), -self.shares, -self.shares[:, ::-1])
        totals = self.shares.sum(axis=1)
        carried = self.shares / np.where(totals > 0.0, totals, 1.0)[:, None]
        stress[:, rows:-2] = self._extend(np.eye(rows), carried, carried[:, ::-1])
        if self.obeys_momentum:
            other = np.zeros(images)
            for side, sign in ((0, -1.0), (1, 1.0)):
                pair = (self.depths, other) if side == 0 else (other, self.depths)
                squares = self._beyond(*pair) ** 2
                velocity[:, side - 2] = -squares / self.channel.solvent_viscosity
                stress[:, side - 2] = 2.0 * sign * self._beyond(*pair)
        return velocity, stress

    def _wall_slopes(self):
        """Return the slopes of the initial shear stress over the height at both walls."""
        channel, step = self.channel, SLOPE * self.channel.gap
        inside = step * np.arange(3)
        _, shear = channel.initial_polymer_stress(np.concatenate([inside, channel.gap - inside]))
        return np.array([1.0, -1.0]) / (2 * step) * (shear.reshape(2, 3) @ [-3.0, 4.0, -1.0]) / channel.density
