"""Exact flow in a channel, put together from the solutions of tisph.exact; u obeys a linear law, so they add up.

A flow that is ``settled`` had developed before t = 0 under the walls' velocities before; all others start from
rest at t = 0. ``channel`` is a ``scene.Channel``; heights ``y`` and times ``t`` broadcast.
"""

import numpy as np

from tisph.exact import couette, oldroyd_b, oscillating_wall, poiseuille, scheduled_wall


class NewtonianFlow:
    """Sum of one part for each thing that drives the liquid: walls of constant velocity, others that move, drive."""

    def __init__(self, channel):
        self.channel = channel
        walls = (channel.bottom, channel.top)
        self._before = velocities_before(channel) if channel.settled else (0.0, 0.0)
        self._jumps = [
            0.0 if wall.oscillates else wall.cosine - before for wall, before in zip(walls, self._before, strict=True)
        ]
        self._liquid = {"gap": channel.gap, "kinematic_viscosity": channel.kinematic_viscosity}

    def velocity(self, y, t):
        """Velocity along x."""
        return sum(self._parts("velocity", np.asarray(y, dtype=float), np.asarray(t, dtype=float)))

    def shear_stress(self, y, t):
        """Shear stress, dynamic viscosity * du/dy; infinite at the moment in which a wall jumps, on that wall."""
        rates = self._parts("shear_rate", np.asarray(y, dtype=float), np.asarray(t, dtype=float))
        return self.channel.dynamic_viscosity * sum(rates)

    def polymer_stress(self, y, t):
        """Zero stresses (S_xx, S_xy): there is no polymer."""
        nothing = self.transverse_stress(y, t)
        return nothing, nothing

    def transverse_stress(self, y, t):
        """Zero stress S_yy."""
        return np.zeros(np.broadcast_shapes(np.shape(y), np.shape(t)))

    def _parts(self, quantity, y, t):
        """Contributions to ``quantity``, velocity or shear_rate, by the functions of that name."""
        channel, (bottom, top) = self.channel, self._jumps
        if channel.settled:
            yield self._linear(quantity, y) + np.zeros_like(t)
        if bottom or top or not channel.settled:
            yield getattr(couette, quantity)(y, t, **self._liquid, bottom=bottom, top=top)
        if channel.bottom.oscillates:
            mirrored = self._by_one_wall(quantity, channel.bottom, channel.gap - y, t)
            yield mirrored if quantity == "velocity" else -mirrored
        if channel.top.oscillates:
            yield self._by_one_wall(quantity, channel.top, y, t)
        if channel.acceleration:
            yield self._driven(quantity, y, t)

    def _linear(self, quantity, y):
        """Developed flow between walls of constant velocity."""
        bottom, top = self._before
        rate = (top - bottom) / self.channel.gap
        return bottom + rate * y if quantity == "velocity" else rate + np.zeros_like(y)

    def _by_one_wall(self, quantity, wall, distance, t):
        """Flow by one wall whose velocity changes; ``distance`` is measured from the other wall."""
        if not wall.angular_frequency:
            return getattr(scheduled_wall, quantity)(distance, t, **self._liquid, kinks=wall.kinks)
        form = getattr(oscillating_wall, f"periodic_{quantity}" if self.channel.settled else quantity)
        return form(distance, t, **self._liquid, wall=wall)

    def _driven(self, quantity, y, t):
        numbers = {**self._liquid, "acceleration": self.channel.acceleration}
        if self.channel.settled:
            return getattr(poiseuille, f"developed_{quantity}")(y, **numbers) + np.zeros_like(t)
        return getattr(poiseuille, quantity)(y, t, **numbers)


class OldroydFlow:
    """Flow of a liquid with polymer between walls of constant velocity, with or without drive."""

    def __init__(self, channel):
        self.channel = channel
        self._liquid = oldroyd_b.Liquid(
            density=channel.density,
            solvent_viscosity=channel.density * channel.solvent_viscosity,
            polymer_viscosity=channel.density * channel.polymer_viscosity,
            relaxation_time=channel.polymer.relaxation_time,
        )
        drive = channel.acceleration
        flow = oldroyd_b.Flow(channel.gap, channel.bottom.cosine, channel.top.cosine, drive)
        before = oldroyd_b.Flow(channel.gap, *velocities_before(channel), drive) if channel.settled else None
        self._numbers = {"liquid": self._liquid, "flow": flow, "before": before}

    def velocity(self, y, t):
        """Velocity along x."""
        return oldroyd_b.velocity(y, t, **self._numbers)

    def shear_stress(self, y, t):
        """Shear stress of solvent and polymer; infinite at the moment in which a wall jumps, on that wall."""
        return oldroyd_b.total_shear_stress(y, t, **self._numbers)

    def polymer_stress(self, y, t):
        """Polymer stresses (S_xx, S_xy)."""
        return oldroyd_b.normal_stress(y, t, **self._numbers), self.polymer_shear_stress(y, t)

    def polymer_shear_stress(self, y, t):
        """Polymer stress S_xy alone, which costs much less than S_xx."""
        return oldroyd_b.shear_stress(y, t, **self._numbers)

    def transverse_stress(self, y, t):
        """Zero stress S_yy."""
        return np.zeros(np.broadcast_shapes(np.shape(y), np.shape(t)))

    def deviations(self, y, t):
        """C of the one mode at heights ``y`` and a time ``t``: list of one array (3, heights)."""
        modulus = self._liquid.polymer_viscosity / self._liquid.relaxation_time
        stress = np.stack([*self.polymer_stress(y, t), self.transverse_stress(y, t)])
        return [stress / modulus if modulus else stress]  # without a polymer nothing is felt of it


def velocities_before(channel):
    """Velocities of the walls (bottom, top) before t = 0 in a settled flow; 0 for one that oscillates."""
    walls = (channel.bottom, channel.top)
    constant = [wall.cosine if wall.before is None else wall.before for wall in walls]
    return tuple(0.0 if wall.oscillates else velocity for wall, velocity in zip(walls, constant, strict=True))
