"""What a step has to know of the walls: where they are at its end, how fast, and what was so before."""

import math

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import view
from tisph.schemes._splitting._closure import Closure
from tisph.schemes._splitting._corners import Corners
from tisph.schemes._splitting._series import VELOCITIES
from tisph.schemes._splitting._walls import FARTHEST
from tisph.snapshot import Bodies

KEPT = 2
"""Times at which the curl of the vorticity at walls is kept, to be extrapolated: from three it is unstable."""

STRAIGHT = 1e-12
"""Part of its speed below which a wall does not move into the liquid."""

KEPT_LISTS = ("twists", "loads", "normals")

LOADS = 3
"""Times at which forces, torques and normal stresses are kept, to be known within a step."""


class Bounds:
    """Sets the points on the walls of a ``BoundedFlow`` and what particles know of walls.

    ``twists`` (points,), of the curl of the vorticity, and ``loads`` (2, bodies, 3), force and torque of all and of the
    pressure, are newest first; so are ``normals`` (bodies,), N1 of a polymer.
    """

    def __init__(self, flow, history, shift, support, skin):
        self.flow, self.walls, self.support, self.skin = flow, flow.walls, support, skin * flow.spacing
        self.history, self.points, self.shift = history, history.points, shift
        self.closure = Closure(history.operators, flow.walls, flow.spacing)
        self.slots = slice(flow.n_fluid, flow.particles)
        self.corners = Corners(flow.corners, flow.origin, history) if flow.corners else None
        self.twists, self.loads, self.normals = [], [], []
        self.normal = self.velocity = None

    def place(self, time):
        """Put the points where they are at ``time``, and let the particles see the walls."""
        places = view(self.points.position)
        place, self.normal, self.velocity = self.walls.at(time)
        places[self.slots] = place % [self.flow.length, self.flow.height]
        planes, distances, curvatures = self.walls.seen(places[: self.flow.particles], time)
        if self.history.operators.curved:
            view(self.history.operators.polar_map)[: self.flow.particles] = self.walls.bend(
                planes, distances, curvatures
            )
        view(self.shift.planes)[: self.flow.n_fluid] = planes[: self.flow.n_fluid]
        spacing = self.flow.spacing
        stretch = self.walls.stretch(distances, self.support)
        stretch[self.slots] += FARTHEST / self.support
        view(self.history.operators.support_factor)[: self.flow.particles] = stretch
        view(self.points.radius)[: self.flow.particles] = self.support * stretch * spacing + self.skin

    def close(self):
        """Turn the rows at the points to what the pressure needs."""
        self.closure.place(self.normal)

    def push(self, split, times, length):
        """Let the solvers of a step of this ``length`` look for what the flow in the corners does not have."""
        if self.corners:
            rest = np.einsum("a,nac->nc", times.ahead(KEPT), self.rests[:, :KEPT].astype(float))
            force = self.corners.force(self.places, rest, length)
            view(split.known)[: self.flow.particles] -= length * force

    @property
    def places(self):
        """Where particles and points are (points, 2)."""
        return view(self.points.position)[: self.flow.particles].astype(float)

    @property
    def rests(self):
        """Velocities (points, ages, 2) that all carry, in place: less those of the flow in the corners."""
        return active(self.history.carried)[: self.flow.particles, : 2 * VELOCITIES].reshape(-1, VELOCITIES, 2)

    def predict(self, times, length):
        """Put the particles where they are after a step of this ``length``, where the flow in the corners counts."""
        if self.corners:
            weights = lambda part: times.at((1.0 - part) * length, VELOCITIES)  # noqa: E731
            place = self.corners.paths.find(weights, length)
            view(self.points.position)[: self.flow.n_fluid] = place % [self.flow.length, self.flow.height]

    def jump(self, time):
        """Let the points have the velocities of the walls after ``time``, at which these jump."""
        self.velocity = self.walls.at(math.nextafter(time, math.inf))[2]  # at the very time they have the old ones
        self.rests[self.slots, 0] = self.velocity

    def find_fastest(self):
        """Take up the largest velocity relative to the mean, of which those carried are a part."""
        if self.corners:
            liquid = self.flow.n_fluid
            velocity = self.rests[:liquid, 0] + self.corners.velocity(self.places[:liquid])
            view(self.history.fastest)[()] = np.linalg.norm(velocity - velocity.mean(axis=0), axis=1).max()

    def begin(self, split, tolerance):
        """Let the points have the velocities of the walls at the start, and the pressure meet their acceleration.

        Return whether liquid could be pushed away where walls move into it.
        """
        rest = self.rests
        rest[self.slots, 0] = self.velocity
        view(split.velocity.x)[self.slots] = self.velocity
        inwards = np.abs(np.sum(self.normal * self.velocity, axis=1)).max()
        pushed = inwards <= STRAIGHT * np.abs(self.velocity).max() or split.kick(tolerance)
        push = -self.walls.acceleration(self.flow.start_time)
        if self.corners:
            rest[:, 0] -= self.corners.velocity(self.places)
            push -= self.corners.force(self.places[self.slots], rest[self.slots, 0], 0.0)
        view(split.velocity.x)[: self.flow.particles] = rest[:, 0]
        view(split.known)[self.slots] = push
        self.conclude(split.velocity.x)
        return pushed

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {name: [array.tolist() for array in getattr(self, name)] for name in KEPT_LISTS}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in KEPT_LISTS:
            setattr(self, name, [np.array(values) for values in state[name]])

    def measure(self, time, polymer=None):
        """Take up the force and torque on each body, from what the points carry at the end of a step at ``time``."""
        carried, normal = active(self.history.carried)[self.slots].astype(float), self.normal
        along, across = (
            view(field)[self.slots, :2].astype(float) for field in (self.history.along, self.history.across)
        )
        shear = across[:, 0] + along[:, 1]
        stress = self.flow.solvent_viscosity * np.stack([2.0 * along[:, 0], shear, 2.0 * across[:, 1]])
        if polymer:
            extra = polymer.wall_stress()
            stress += extra
            normals = self.flow.density * self.walls.means(_along_less_across(extra, normal))
            self.normals = [normals, *self.normals][:LOADS]
        viscous = np.stack([(stress[:2] * normal.T).sum(axis=0), (stress[1:] * normal.T).sum(axis=0)], axis=1)
        tractions = np.stack([viscous, -carried[:, 2 * VELOCITIES, None] * normal])
        if self.corners:
            tractions += self.corners.traction(self.places[self.slots], normal, self.flow.kinematic_viscosity)
        viscous, pressure = tractions
        loads = self.walls.sums(self.flow.density * np.stack([viscous + pressure, pressure]), time)
        self.loads = [loads, *self.loads][:LOADS]

    def bodies(self, time, times, age):
        """Return the ``Bodies`` at ``time``, ``age`` before the end of the last step, from which ``times`` count."""
        weights = times.at(age, min(LOADS, len(self.loads)))
        loads, normals = (
            sum(weight * each for weight, each in zip(weights, kept, strict=False)) if kept else None
            for kept in (self.loads, self.normals)
        )
        return Bodies.at(time, self.walls.bodies, loads, normals)

    def drive(self, split, times):
        """Give the velocities of the walls at the end of a step to its solvers, and the curl expected there."""
        rest = self.velocity
        if self.corners:
            rest = rest - self.corners.velocity(self.places[self.slots])
        view(split.velocity.x)[self.slots] = rest
        weights = times.ahead(min(KEPT, max(1, len(self.twists))))
        self.closure.twists[...] = sum(weight * twist for weight, twist in zip(weights, self.twists, strict=False))

    def conclude(self, velocity):
        """Keep the curl of the vorticity of the ``velocity`` at the end of a step, a field."""
        self.closure.spin(velocity)
        self.twists = [self.closure.twists.copy(), *self.twists][:KEPT]


def _along_less_across(stress, normal):
    """Return N1 (count,) of a ``stress`` (3, count) at walls with a ``normal`` (count, 2)."""
    (xx, xy, yy), (x, y) = stress, normal.T
    return (yy - xx) * (x**2 - y**2) - 4.0 * xy * x * y
