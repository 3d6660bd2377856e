"""Collocation points on walls, about a spacing apart, and the nearest walls of each particle.

The points are neighbours of known velocity, there are no ghosts. Near walls the support of operators is wider, because
only a part of a disc around a particle holds any fluid: without that they are unstable.

Walls of axisymmetric flow are curves in the half-plane y >= 0, the sections of surfaces of revolution around y = 0.
Velocities are the unknowns u, v/r and w/r of ``AxisymmetricCoordinates``. The part of a wall in the other half-plane
has no points: all have y > 0.
"""

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.geometry.body import BodyState, SlidingWall
from tisph.geometry.ends import LEAST_DISTANCE, Inlet, OpenEnd, Outlet
from tisph.geometry.line import Line
from tisph.geometry.shape import Boundary
from tisph.geometry.wanted_spacing import WantedSpacing, arc_lengths, graded_boundary

WALL_DISTANCE = 2.9
"""Distance from a wall below which the support is wider, in particle spacings."""

WALL_SUPPORT = 1.2
"""By how much the support is wider at a wall, in particle spacings; where two walls are near this adds up.

Particles lie in layers along a straight wall: with 0.8 too few are within the support for the fourth
derivative across them.
"""

POINT_SUPPORT = 0.4
"""By how much the support of points on walls is wider in addition: fluid is on one side of them only."""

CURVED = 6.0
"""Distance from a wall, in particle spacings, up to which operators use its curvature."""

ALONG = 2.0
"""Distance along a wall, in particle spacings, over which its curvature is averaged where it bulges into the fluid. It
jumps where a straight part meets a rounded corner, and operators of particles that pass would jump with it: steps were
a quarter as long then, and every fifth was rejected."""

LEAST_RADIUS, LEAST_INSIDE = 2.5, 7.0
"""Distance from the centre of curvature, in particle spacings, from which on they do: with the body, or the fluid,
around it. The support is 4.5 spacings and more, and the other side of the centre is no continuation of this one."""

MAX_WALLS = 2
"""Number of the nearest walls that count for a particle."""

UNLIKE = 0.15
"""Logarithm of the spacing of a point over the one that is wanted there, from which on a wall has its points anew."""

NEAR_AXIS = 2.0
"""Distance from the axis, in particle spacings, up to which operators do not use the curvature of walls. With 3 to 5
the least eigenvalue of D G L^-1, divergence, gradient and inverse Laplacian of the pressure, is -0.08 to -0.15 beside a
sphere of 8 spacings, in place of -0.06: the pressure that is to remove divergence then increases it, and at Re = 50 a
run diverged. With 0 the largest one is above 2."""


CARRYING = 6
"""Points between which a wall that slides carries values: as many on each side of a place, where there are."""


def nearest_weights(knots: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return indices (``CARRYING``, n) of ascending ``knots`` around the ``places`` (n,), and weights by Lagrange."""
    count = min(CARRYING, len(knots))
    first = np.clip(np.searchsorted(knots, places) - count // 2, 0, len(knots) - count)
    chosen = first + np.arange(count)[:, None]
    at, weights = knots[chosen], np.ones((count, len(places)))
    for i, j in itertools.permutations(range(count), 2):
        weights[i] *= (places - at[j]) / (at[i] - at[j])
    return chosen, weights


class WallPoints:
    """Points on the walls of ``bodies``; positions are in the box of a problem, its lowest corner ``origin``.

    There are ``count``, each for a part of the wall of ``length`` (count,); ``parts`` are slices of them by body.
    ``solid`` (count,): whether a point is on a wall, and not on an open end. ``ends``: the open ends among
    the bodies. ``kinds``: the bodies but outlets, and the outlets. ``slip_length`` (count,): of the walls, 0 without.
    ``periods`` (2,) of the box, huge where it is not periodic. ``spacings`` (count,): distances along the wall between
    the points, those ``wanted`` at the ``start``, or the ``spacing`` where it does not vary.

    Steady walls are placed once; points are placed anew on walls where another spacing is wanted, ``renew``.
    ``arranged``: whether any were. ``unsteady``: numbers of the other bodies, ``free`` of those that the flow moves.
    ``planes``: normal and offset of each straight wall that moves along itself at most, by its number.
    """

    def __init__(
        self,
        bodies: Sequence[Any],
        spacing: float,
        origin: Any,
        periods: Sequence[float] = (np.inf, np.inf),
        wanted: WantedSpacing | None = None,
        start: float = 0.0,
    ) -> None:
        self.bodies, self.spacing, self.origin = bodies, spacing, np.array(origin)
        self.wanted, self.start = wanted or WantedSpacing(spacing), start
        self.periods = np.minimum(periods, 1e30)
        self.ends = [body for body in bodies if isinstance(body, OpenEnd)]
        self.kinds = [[body for body in bodies if isinstance(body, Outlet) == kind] for kind in (False, True)]
        self.curved = any(0.0 < body.shape.smallest_radius < np.inf for body in bodies)
        self.unsteady = [number for number, body in enumerate(bodies) if not body.steady]
        self.free = [number for number, body in enumerate(bodies) if body.free]
        self.arranged = False
        outlines = [self._outline(body) for body in bodies]
        started = [body.placed(outline, start).point for body, outline in zip(bodies, outlines, strict=True)]
        self._arrange(outlines, self.wanted.at(np.concatenate(started), start), [body.at(0.0) for body in bodies])

    def _arrange(self, outlines: list[Boundary], spacings: np.ndarray, states: list[BodyState]) -> None:
        """Set the points by the ``outlines`` of the bodies, in these ``states``, and their ``spacings`` (count,)."""
        bodies, self.outlines, self.spacings = self.bodies, outlines, spacings
        self.length = np.concatenate([outline.length for outline in outlines])
        ends = np.cumsum([0, *(len(outline.length) for outline in outlines)])
        self.parts = [slice(first, last) for first, last in itertools.pairwise(ends)]
        self.count = len(self.length)
        solid = [
            np.full(len(each.length), not isinstance(body, OpenEnd))
            for body, each in zip(bodies, outlines, strict=True)
        ]
        self.solid = np.concatenate(solid)
        self.slip_length = np.concatenate(
            [np.full(len(each.length), body.slip_length) for body, each in zip(bodies, outlines, strict=True)]
        )
        self.bulging = [np.maximum(outline.curvature, 0.0) for outline in outlines]
        self._kept_time = math.nan
        self._kept_states: list[BodyState] = states
        pairs = zip(self._kept_states, outlines, strict=True)
        self._kept: list[Boundary] = [state.placed(outline) for state, outline in pairs]
        self._points, self._normals = (
            np.concatenate([getattr(boundary, name) for boundary in self._kept]) for name in ("point", "normal")
        )
        pairs = zip(self._kept_states, self._kept, strict=True)
        self._velocities = np.concatenate([state.velocity(boundary.point) for state, boundary in pairs])
        self.planes = {}
        for number, (body, boundary) in enumerate(zip(bodies, self._kept, strict=True)):
            if isinstance(body.shape, Line) and not (body.free or isinstance(body, OpenEnd)):
                normal, fastest = boundary.normal[0], (body.motion.x.largest_speed, body.motion.y.largest_speed)
                if not np.abs(normal) @ fastest:
                    self.planes[number] = normal, normal @ (boundary.point[0] - self.origin)

    def renew(self, time: float) -> Any:
        """Place the points of walls anew at ``time`` where their spacing is no longer the one that is wanted.

        Return the sparse matrix (count, count before) that interpolates values at the points before, by cubic splines
        along the walls; None if all points stay.
        """
        from scipy.sparse import block_diag, identity

        now, before = self.at(time)[0] + self.origin, self.parts
        unlike = np.abs(np.log(self.wanted.at(now, time) / self.spacings)) > UNLIKE
        moved = [number for number, part in enumerate(before) if unlike[part].any()]
        if not moved:
            return None
        self.start = time
        outlines, spacings = list(self.outlines), [self.spacings[part] for part in before]
        blocks = [identity(part.stop - part.start) for part in before]
        for number in moved:
            body = self.bodies[number]
            outlines[number] = self._outline(body)
            spacings[number] = self.wanted.at(body.placed(outlines[number], time).point, time)
            blocks[number] = self._spline(number, outlines[number])
        self._arrange(outlines, np.concatenate(spacings), [body.at(time) for body in self.bodies])
        self.arranged = True
        return block_diag(blocks, format="csr")

    def _spline(self, number: int, outline: Boundary) -> np.ndarray:
        """Return the matrix (points, points before) of cubic splines along the wall ``number`` to an ``outline``."""
        from scipy.interpolate import CubicSpline

        shape = self.bodies[number].shape
        old, new = (arc_lengths(shape, each.point) for each in (self.outlines[number], outline))
        order = np.argsort(old)
        values, knots = np.eye(len(old))[order], old[order]
        if not self._closed(number):
            return CubicSpline(knots, values, bc_type="not-a-knot")(new)
        knots, values = np.append(knots, knots[0] + shape.length), np.append(values, values[:1], axis=0)
        return CubicSpline(knots, values, bc_type="periodic")(new)

    def _closed(self, number: int) -> bool:
        """Return whether a wall is closed, or goes on in the next period of the box: its ends are a spacing apart."""
        point, spacings = self._kept[number].point, self.spacings[self.parts[number]]
        apart = point[0] - point[-1]
        apart -= self.periods * np.round(apart / self.periods)
        return bool(np.hypot(*apart) < 0.75 * (spacings[0] + spacings[-1]))

    def state(self) -> list[Any] | None:
        """Return the points that were placed anew, for a resumed run; None if there are none."""
        if not self.arranged:
            return None
        names = "point", "normal", "curvature", "length"
        outlines = [[getattr(outline, name).tolist() for name in names] for outline in self.outlines]
        return [outlines, self.spacings.tolist()]

    def restore(self, state: list[Any] | None) -> None:
        """Restore the points of ``state``."""
        if state:
            outlines = [Boundary(*map(np.array, outline)) for outline in state[0]]
            self._arrange(outlines, np.array(state[1]), [body.at(0.0) for body in self.bodies])
            self.arranged = True

    @property
    def across_axis(self) -> bool:
        """Whether flow along one of the walls goes to an axis, or from it: there is none."""
        return False

    def of_bodies(self, bodies: Sequence[Any]) -> Any:
        """Return the points on the walls of other ``bodies`` in the same box."""
        return type(self)(bodies, self.spacing, self.origin, self.periods.tolist(), self.wanted, self.start)

    def _outline(self, body: Any) -> Boundary:
        """Return the points of a wall in the frame of its body, a ``Boundary``."""
        if self.wanted.varies:
            return graded_boundary(body, self.wanted, self.start)
        return body.shape.boundary_points(self.spacing)

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and normals into the fluid of the points at ``time``, (count, 2) each."""
        self._placed(time)
        return self._points - self.origin, self._normals.copy()

    def velocities(self, time: float) -> np.ndarray:
        """Return the velocities (count, 2) of the points at ``time``."""
        velocities, states = self._velocities.copy(), self.states(time)
        for number in self.unsteady:
            velocities[self.parts[number]] = states[number].velocity(self._kept[number].point)
        return velocities

    def acceleration(self, time: float) -> np.ndarray:
        """Return the accelerations (count, 2) of the points at ``time``."""
        pairs = zip(self.states(time), self._placed(time), strict=True)
        return np.concatenate([state.acceleration(boundary.point) for state, boundary in pairs])

    def carried(self, values: np.ndarray, elapsed: np.ndarray, time: float) -> np.ndarray:
        """Return ``values`` (levels, numbers, count), each ``elapsed`` (levels,) ago, where the fluid came from.

        Walls that slide along themselves carry them past the points, which stay: between ``CARRYING`` points by
        polynomials, which damp waves of two spacings. Splines do not: from the corner to which a lid slides, where the
        stretch of a polymer rises within a spacing, such waves ran upstream along the whole lid.
        """
        result = values.copy()
        for body, boundary, part in zip(self.bodies, self._placed(time), self.parts, strict=True):
            if isinstance(body, SlidingWall):
                order = np.argsort(boundary.point[:, 0])
                for age, gone in enumerate(elapsed):
                    there = body.departure_point(boundary.point, gone, time)[:, 0]
                    chosen, weights = nearest_weights(boundary.point[order, 0], there)
                    result[age][:, part] = np.sum(values[age][:, part][:, order][:, chosen] * weights, axis=1)
        return result

    def along_slipping(self, values: np.ndarray, time: float) -> np.ndarray:
        """Return derivatives (numbers, count) of ``values`` along the walls along which fluid slips, 0 at other walls.

        They are along the normal turned by a right angle counterclockwise, by cubic splines through the points.
        """
        result = np.zeros_like(values)
        for number, part in enumerate(self.parts):
            if self.bodies[number].slip_length:
                place, curve = self.curve(number, values[:, part], time)
                result[:, part] = curve(place, 1)
        return result

    def curve(self, number: int, values: np.ndarray, time: float) -> tuple[np.ndarray, Any]:
        """Return the places (count,) along the wall ``number``, and the cubic spline of ``values`` (numbers, count).

        Places grow along the normal turned by a right angle counterclockwise. A wall is closed, or goes on in the next
        period of the box, if its ends are a spacing apart.
        """
        from scipy.interpolate import CubicSpline  # only slip needs it

        boundary = self._placed(time)[number]
        point, (x, y) = boundary.point, boundary.normal[0]
        forwards = point[1] - point[0]
        order = slice(None) if x * forwards[1] - y * forwards[0] > 0.0 else slice(None, None, -1)
        place = np.cumsum(boundary.length[order])[order] - 0.5 * boundary.length
        if self.wanted.varies:  # lengths are then weights of sums; these arcs have errors of fourth order
            chord, bend = np.hypot(*np.diff(point[order], axis=0).T), boundary.curvature[order]
            arc = chord + (0.5 * (bend[1:] + bend[:-1])) ** 2 * chord**3 / 24.0
            place = np.append(0.0, np.cumsum(arc))[order]
        closed = self._closed(number)
        knots, values = place[order], values[:, order]
        if closed:
            knots = np.append(knots, knots[0] + boundary.length.sum())
            values = np.append(values, values[:, :1], axis=1)
        return place, CubicSpline(knots, values, axis=1, bc_type="periodic" if closed else "not-a-knot")

    def sliding_acceleration(self, speed: np.ndarray, time: float) -> np.ndarray:
        """Return the normal acceleration (count,) of fluid that slides along the walls, beyond that of their points.

        It is w n . dU/ds - kappa w^2 with the ``speed`` w (count,) relative to the walls, along the normal turned by a
        right angle counterclockwise. U is the velocity of a wall along its arc length s, kappa its curvature.
        """
        found = []
        for body, boundary, part in zip(self.bodies, self._placed(time), self.parts, strict=True):
            tangent = boundary.normal[:, ::-1] * [-1.0, 1.0]
            change = np.sum(boundary.normal * body.tangential_gradient(boundary.point, tangent, time), axis=1)
            found.append(speed[part] * (change - boundary.curvature * speed[part]))
        return np.concatenate(found)

    def inwards(self, normal: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Return the parts (count,) into the fluid of velocities (count, 2) at the points with this ``normal``."""
        return np.sum(normal * velocity, axis=1)

    def gradients(self, gradients: np.ndarray, time: float, slip: np.ndarray | None = None) -> np.ndarray:
        """Return velocity gradients (2, 2, count), du_a/dx_b, that agree with the motion of the walls.

        Along a wall the fluid's velocity varies as the wall's, and its divergence is 0: of the measured ``gradients``
        only the shear is used. ``slip`` (2, count): velocity of the fluid relative to walls along which it slips.
        """
        boundaries, normal = self._placed(time), self._normals.T
        tangent = np.stack([normal[1], -normal[0]])
        pairs = zip(self.bodies, boundaries, strict=True)
        tangents = (np.stack([part.normal[:, 1], -part.normal[:, 0]], axis=1) for part in boundaries)
        parts = [
            body.tangential_gradient(part.point, along, time)
            for (body, part), along in zip(pairs, tangents, strict=True)
        ]
        strain = np.concatenate(parts).T
        if slip is not None:
            strain = strain - self.along_slipping(slip, time)
        shear = np.einsum("abn,an,bn->n", gradients, tangent, normal)
        across = shear * tangent - np.sum(strain * tangent, axis=0) * normal
        result = across[:, None] * normal + strain[:, None] * tangent
        for body, part in zip(self.bodies, self.parts, strict=True):
            if isinstance(body, Inlet):  # developed upstream
                result[:, :, part] = (strain[:, None] * tangent)[:, :, part]
            elif isinstance(body, Outlet):
                result[:, :, part] = gradients[:, :, part]
        return result

    def sums(self, tractions: np.ndarray, time: float) -> np.ndarray:
        """Return force, torque and stresslet (n, bodies, 4) on bodies, of n ``tractions`` (n, count, 2) at the points.

        The stresslet is the sum of (x t_y + y t_x)/2, from its centre: the shear stress that a body adds in a cell,
        times the area of the cell (G. K. Batchelor, J. Fluid Mech. 41 (1970) 545-570).
        """
        force, result = self.length[:, None] * tractions, np.zeros((len(tractions), len(self.bodies), 4))
        for number, (state, boundary) in enumerate(zip(self.states(time), self._placed(time), strict=True)):
            arm, part = boundary.point - state.centre, force[:, self.parts[number]]
            result[:, number, :2] = part.sum(axis=1)
            along, across = arm[:, 0] * part[..., 1], arm[:, 1] * part[..., 0]
            result[:, number, 2] = (along - across).sum(axis=1)
            result[:, number, 3] = 0.5 * (along + across).sum(axis=1)
        return result

    def rigid_motion(self, chosen: Sequence[int], time: float) -> Any:
        """Return the velocities (count * 2, 3 n) of the points by the velocities of n ``chosen`` bodies, sparse."""
        from scipy.sparse import csr_matrix

        boundaries, states, entries = self._placed(time), self.states(time), []
        for place, number in enumerate(chosen):
            part, arm = self.parts[number], boundaries[number].point - states[number].centre
            rows, one = 2 * np.arange(part.start, part.stop), np.ones(len(arm))
            velocities = (0, 0, one), (1, 1, one), (0, 2, -arm[:, 1]), (1, 2, arm[:, 0])
            entries += [
                (values, rows + row, np.full(len(rows), 3 * place + column)) for row, column, values in velocities
            ]
        values, rows, columns = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return csr_matrix((values, (rows, columns)), (2 * self.count, 3 * len(chosen)))

    def areas(self, time: float) -> np.ndarray:
        """Return the factors (count, 2) of tractions in the forces on bodies by ``rigid_motion``."""
        return np.stack([self.length, self.length], axis=1)

    def moments(self, time: float) -> np.ndarray:
        """Return the integrals (bodies,) of the squared distance from each body's centre along its surface."""
        return np.array(
            [
                self.length[part] @ np.sum((boundary.point - state.centre) ** 2, axis=1)
                for state, boundary, part in zip(self.states(time), self._placed(time), self.parts, strict=True)
            ]
        )

    def means(self, values: np.ndarray) -> np.ndarray:
        """Return the means (bodies,) along each wall of ``values`` (count,) at the points."""
        return np.array([np.average(values[part], weights=self.length[part]) for part in self.parts])

    def _placed(self, time: float) -> list[Boundary]:
        """Return the points by body at ``time``; the points of the last time are kept for further calls in a step."""
        if self._kept_time != time:
            self._kept_time = time
            for number in self.unsteady:
                state = self._kept_states[number] = self.bodies[number].at(time)
                boundary = self._kept[number] = state.placed(self.outlines[number])
                self._points[self.parts[number]] = boundary.point
                self._normals[self.parts[number]] = boundary.normal
        return self._kept

    def states(self, time: float) -> list[BodyState]:
        """Return the bodies at ``time``; free ones anew, since the end of a step corrects how they got there."""
        self._placed(time)
        for number in self.free:
            self._kept_states[number] = self.bodies[number].at(time)
        return self._kept_states

    def distance(self, place: np.ndarray, time: float, of: Sequence[Any]) -> np.ndarray:
        """Return the distances (n,) of positions (n, 2) from the nearest ``of`` the bodies, negative beyond a wall."""
        return np.min([body.nearest(place + self.origin, time).distance for body in of], axis=0)

    def nearest_walls(self, place: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the tangent planes of the nearest walls of each of the positions (n, 2), at the closest points.

        An array (n, MAX_WALLS, 3): normal, then offset, normal . x - offset being the distance, 1e30 where there is no
        such wall. The distances (n, MAX_WALLS), infinite there. And the curvatures (n, MAX_WALLS) of the walls.
        """
        count = max(MAX_WALLS, len(self.bodies))
        planes, distances = np.zeros((len(place), count, 3)), np.full((len(place), count), np.inf)
        planes[:, len(self.bodies) :, 2] = -1e30
        curvatures = np.zeros((len(place), count))
        places = place + self.origin
        for number, (body, state) in enumerate(zip(self.bodies, self.states(time), strict=True)):
            if number in self.planes:
                normal, offset = self.planes[number]
                planes[:, number] = *normal, offset
                distances[:, number] = place @ normal - offset
                continue
            foot = state.nearest(places)
            planes[:, number, :2], distances[:, number] = foot.normal, foot.distance
            planes[:, number, 2] = np.einsum("ni,ni->n", foot.point - self.origin, foot.normal)
            if isinstance(body, OpenEnd):  # particles keep this distance from it
                planes[:, number, 2] += LEAST_DISTANCE * self.spacing
            curvatures[:, number] = self._mean_curvature(number, foot, time)
        nearest = np.argsort(distances, axis=1, kind="stable")[:, :MAX_WALLS]
        planes = np.take_along_axis(planes, nearest[..., None], 1)
        return planes, np.take_along_axis(distances, nearest, 1), np.take_along_axis(curvatures, nearest, 1)

    def _mean_curvature(self, number: int, foot: Any, time: float) -> np.ndarray:
        """Return the curvatures (n,) of a wall at closest points on it, averaged where it bulges into the fluid."""
        boundary, result, bulging = self._placed(time)[number], foot.curvature.copy(), self.bulging[number]
        if np.ptp(bulging):
            near = (foot.distance < CURVED * self.spacing) & (result >= 0.0)
            apart = foot.point[near][:, None] - boundary.point
            apart -= self.bodies[number].nearest_copy(apart)
            along = ALONG * self.spacings[self.parts[number]]
            weight = np.maximum(1.0 - (apart**2).sum(axis=2) / along**2, 0.0) ** 2
            result[near] = weight @ bulging / np.maximum(weight.sum(axis=1), 1e-300)  # 0 beyond the ends of a wall
        return result

    def polar_map(
        self,
        place: np.ndarray,
        planes: np.ndarray,
        distances: np.ndarray,
        curvatures: np.ndarray,
        spacing: np.ndarray,
    ) -> np.ndarray:
        """Return the ``polar_map`` of operators (n, 2) at positions (n, 2) with this ``spacing`` (n,).

        It is the conjugate inverse of the vector from the centre of curvature.
        """
        normal, distance, curvature = planes[:, 0, :2], distances[:, 0], curvatures[:, 0]
        radius = 1.0 / np.where(curvature, curvature, 1e-30) + distance
        least = spacing * np.where(curvature > 0.0, LEAST_RADIUS, LEAST_INSIDE)
        curved = (curvature != 0.0) & (distance < CURVED * spacing) & (radius * np.sign(curvature) > least)
        return np.where(curved, 1.0 / radius, 0.0)[:, None] * normal * [1.0, -1.0]

    def mirrors(self, place: np.ndarray, planes: np.ndarray, distances: np.ndarray) -> np.ndarray:
        """Return the planes (n, MAX_WALLS, 3) in which the arrangement of particles goes on as its mirror image."""
        return planes

    def strain(self, velocity: np.ndarray, d_dx: np.ndarray, d_dy: np.ndarray) -> np.ndarray:
        """Return 2 D (3, count), xx, xy and yy, of a ``velocity`` (2, count) with these derivatives."""
        return np.stack([2.0 * d_dx[0], d_dy[0] + d_dx[1], 2.0 * d_dy[1]])

    def support_factor(self, distances: np.ndarray, support: float) -> np.ndarray:
        """Return the factor (n,) by which a ``support``, in spacings, is wider at ``distances`` (n, walls).

        Distances are over the relative spacing of a point.
        """
        near = np.clip(1.0 - distances / (WALL_DISTANCE * self.spacing), 0.0, 1.0).sum(axis=1)
        return 1.0 + WALL_SUPPORT / support * near


class WallsOfRevolution(WallPoints):
    """Points on walls, ``WallPoints``, that may turn around the axis as well, by the ``spin`` of their bodies."""

    @property
    def across_axis(self) -> bool:
        """Whether flow along one of the walls goes to the axis, or from it."""
        steepest = [np.abs(outline.normal[:, 0]).max() for outline in self.outlines]
        walls = [not isinstance(body, OpenEnd) for body in self.bodies]
        return max(itertools.compress(steepest, walls)) > 0.5

    def _outline(self, body: Any) -> Boundary:
        """Return points on the upper half of a wall that is symmetric about the axis, none of them on it."""
        if self.wanted.varies:
            return graded_boundary(body, self.wanted, self.start, above_axis=True)
        length = body.shape.length
        outline = body.shape.boundary_points(length / (2 * round(0.5 * length / self.spacing)))
        above = body.placed(outline).point[:, 1] > 0.0
        return Boundary(*(getattr(outline, name)[above] for name in ("point", "normal", "curvature", "length")))

    def velocities(self, time: float) -> np.ndarray:
        """Return u, v/r and w/r (count, 3) of the points at ``time``."""
        along, across = super().velocities(time).T
        return np.stack([along, across / self.radii(time), self._spins("velocity", time)], axis=1)

    def acceleration(self, time: float) -> np.ndarray:
        """Return the accelerations (count, 3) of the points, over r across and around the axis."""
        (along, across), radius = super().acceleration(time).T, self.radii(time)
        centripetal = self._spins("velocity", time) ** 2
        return np.stack([along, across / radius - centripetal, self._spins("acceleration", time)], axis=1)

    def radii(self, time: float) -> np.ndarray:
        """Return the distances (count,) of the points from the axis."""
        self._placed(time)
        return self._points[:, 1]

    def _spins(self, name: str, time: float) -> np.ndarray:
        found = []
        for body, boundary in zip(self.bodies, self._placed(time), strict=True):
            if isinstance(body, Inlet):
                found.append(body.turning(boundary.point[:, 1]) * (name == "velocity"))
            else:
                found.append(np.full(len(boundary.point), getattr(body.spin, name)(time)))
        return np.concatenate(found)

    def inwards(self, normal: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Return the parts (count,) into the fluid of the unknowns (count, 3) of a velocity."""
        return normal[:, 0] * velocity[:, 0] + normal[:, 1] * self.radii(self._kept_time) * velocity[:, 1]

    def strain(self, velocity: np.ndarray, d_dx: np.ndarray, d_dy: np.ndarray) -> np.ndarray:
        """Return 2 D (5, count): xx, xy, yy, and of x and y with the direction around the axis."""
        radius = self.radii(self._kept_time)
        shear = radius * (d_dy[0] + d_dx[1])
        across = 2.0 * (velocity[1] + radius**2 * d_dy[1])
        return np.stack([2.0 * d_dx[0], shear, across, radius * d_dx[2], radius**2 * d_dy[2]])

    def gradient_around(self, gradient: np.ndarray) -> np.ndarray:
        """Return derivatives (2, count) of w/r by x and y that agree with walls on which w/r is constant."""
        normal = self._normals.T
        return normal * (normal * gradient).sum(axis=0)

    def sums(self, tractions: np.ndarray, time: float) -> np.ndarray:
        """Return force along the axis, 0, torque around it, and 0, on whole bodies (n, bodies, 4).

        ``tractions`` (n, count, 2 or 3): a pressure has no traction around the axis.
        """
        radius = self.radii(time)
        force = (2.0 * np.pi * radius * self.length)[:, None] * tractions
        result = np.zeros((len(tractions), len(self.bodies), 4))
        for number, part in enumerate(self.parts):
            result[:, number, 0] = force[:, part, 0].sum(axis=1)
            result[:, number, 2] = (radius[part, None] * force[:, part, 2:]).sum(axis=(1, 2))
        return result

    def rigid_motion(self, chosen: Sequence[int], time: float) -> Any:
        """Return u, v/r and w/r (count * 3, 3 n) of the points by the velocities of n bodies, which move along x."""
        from scipy.sparse import lil_matrix

        result = lil_matrix((3 * self.count, 3 * len(chosen)))
        for place, number in enumerate(chosen):
            part = self.parts[number]
            result[3 * np.arange(part.start, part.stop), 3 * place] = 1.0
        return result.tocsr()

    def areas(self, time: float) -> np.ndarray:
        """Return the factors (count, 3) of tractions in the forces on bodies by ``rigid_motion``."""
        area = 2.0 * np.pi * self.radii(time) * self.length
        return np.stack([area, area, area], axis=1)

    def means(self, values: np.ndarray) -> np.ndarray:
        """Return the means (bodies,) over each wall of ``values`` (count,) at the points."""
        area = self.length * self.radii(self._kept_time)
        return np.array([np.average(values[part], weights=area[part]) for part in self.parts])

    def polar_map(
        self,
        place: np.ndarray,
        planes: np.ndarray,
        distances: np.ndarray,
        curvatures: np.ndarray,
        spacing: np.ndarray,
    ) -> np.ndarray:
        """Return the ``polar_map`` of ``WallPoints``; 0 near the axis, where operators are of even functions."""
        away = place[:, 1] + self.origin[1] > NEAR_AXIS * spacing
        return away[:, None] * super().polar_map(place, planes, distances, curvatures, spacing)

    def mirrors(self, place: np.ndarray, planes: np.ndarray, distances: np.ndarray) -> np.ndarray:
        """Return the planes of ``WallPoints``, with the axis in place of the last wall where it is nearer."""
        nearer, planes = place[:, 1] + self.origin[1] < distances[:, -1], planes.copy()
        planes[nearer, -1] = 0.0, 1.0, -self.origin[1]
        return planes
