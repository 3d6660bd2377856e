"""Steps of the implicit scheme where the flow turns: predict the end, assemble the operators there, solve, shift."""

import math

import numpy as np

from tisph.errors import DivergedError
from tisph.least_squares import SKIN
from tisph.least_squares.operators import LeastSquaresOperators
from tisph.neighbours.point_cloud import PointCloud, active
from tisph.periodic import PeriodicDomain
from tisph.runtime import integer, real, ti, view
from tisph.schemes._overflow import clustered
from tisph.schemes._splitting._bounds import Bounds
from tisph.schemes._splitting._history import History
from tisph.schemes._splitting._output import carried_in_order, state
from tisph.schemes._splitting._polymer import Polymer
from tisph.schemes._splitting._series import PRESSURES, VELOCITIES, Times
from tisph.schemes._splitting._shift import GONE, Shift
from tisph.schemes._splitting._split import Split
from tisph.schemes._splitting._step_limits import FIRST, MOST_ATTEMPTS, RUNAWAY, SMALLEST_SPEED, TOLERANCE, step_control
from tisph.schemes._splitting._walls import FARTHER, FARTHEST, SEEN
from tisph.solvers.auxiliary_grid import AuxiliaryGrid

SUPPORT = 2.9
"""Radius of the rows in particle spacings. Below it a lattice that the flow stretches makes them singular before it has
broken up; above it the pressure has larger errors."""

SMALLEST_PIVOT = 1e-3
"""Of the rows: those of order 2, which would take over, are worse than any of order 4 that can be solved for."""

DECAY = 0.3, 10.0
"""Where steps are short divergence decays at the rate 0.3 nu/spacing^2 + 10 U/spacing. A larger second number moves
errors from the velocities to the pressure, a smaller one the other way: in the vortex at Re = 100, 50 x 50, a Courant
number of 0.15 and t = 1 they are 2.7e-5 and 7.0e-5 with 4, 1.9e-5 and 8.5e-5 with 10. With 12 the noise of a divergence
that is to vanish at once makes coarse runs take shorter steps."""

COURANT = 0.3
"""Longest step over the time in which the fastest particle goes one spacing."""

PRESSURE_RESIDUAL, VELOCITY_RESIDUAL = 1e-6, 1e-10
"""Of the linear systems. That of the velocities adds up from step to step."""

ROUNDING = 30.0
"""The least residual that is asked for, in units of the rounding error."""

TIDYING = 100
"""Steps after which particles that have become neighbours are brought near one another in memory, too. Once a flow has
mixed 1e5 of them a step takes 1.7 times as long without."""

HOST_STATE = "time", "steps", "rejected", "shortest", "longest", "reduced", "dropped", "lengths", "iterations"
HOST_STATE += "initial_momentum", "steepest"
"""Attributes of a Scheme that change while it runs."""


class Scheme:
    """Particles in a periodic box, advanced step by step; ``time`` and ``steps`` tell how far.

    ``flow`` is a ``PeriodicFlow``; ``targets`` are times that steps end on exactly. ``serial`` compiles loops without
    threads. ``tolerance`` is that of a step's error over the velocity, None for steps of the Courant number alone.
    """

    def __init__(self, flow, targets, serial, tolerance=TOLERANCE, courant=COURANT):
        self.flow, self.initial_momentum = flow, 0.0
        bounded, reach = flow.walls is not None, (SUPPORT + SKIN) * flow.spacing
        if bounded:
            reach = reach, reach + (SEEN * FARTHER + FARTHEST) * flow.spacing
        self.points = PointCloud(flow, PeriodicDomain(flow.length, flow.height), reach, 0, serial)
        # in polar coordinates points lie in layers: near walls rows then have 70 times the rounding errors
        curved = bounded and flow.walls.curved and real() == ti.f64
        self.operators = LeastSquaresOperators(self.points, SUPPORT * flow.spacing, 4, SMALLEST_PIVOT, bounded, curved)
        self.grid = AuxiliaryGrid(self.points, flow, flow.height)
        self.shift = Shift(self.points, flow.spacing, SEEN if bounded else 0)
        self.history = History(self.operators, self.shift)
        self.bounds = None
        if bounded:
            self.points.n_fluid = integer(flow.n_fluid)
            self.bounds = Bounds(flow, self.history, self.shift, SUPPORT, SKIN)
        closure = self.bounds.closure if bounded else None
        self.polymer = Polymer(self.history, flow) if flow.rheology else None
        self.split = Split(self.history, self.grid, flow, closure, self.polymer)
        self.control = step_control(flow, targets, tolerance, courant)
        least = ROUNDING * float(np.finfo(np.float64 if real() == ti.f64 else np.float32).eps)
        self.residuals = max(PRESSURE_RESIDUAL, least), max(VELOCITY_RESIDUAL, least)
        self.reset()

    def reset(self):
        """Go back to before the first step."""
        self.time = self.flow.start_time
        self.steps = self.rejected = self.reduced = self.dropped = 0
        self.shortest, self.longest = math.inf, 0.0
        self.lengths, self.iterations = [], [0.0, 0.0]
        self.seen = self.steepest = None

    def start(self, position, velocity, stress=None):
        """Place the particles, (particles, 2) arrays, and find the pressure of their velocities.

        Polymers start without ``stress``.
        """
        self.initial_momentum = float(velocity[:, 0].sum())
        liquid = self.flow.n_fluid
        active(self.history.position)[:liquid] = position - np.array(self.flow.origin)
        active(self.history.carried)[...] = 0.0
        active(self.history.carried)[:liquid, :2] = velocity
        active(self.history.number)[:liquid] = np.arange(len(position))
        view(self.history.path)[...] = 0.0
        self.history.predict()
        self.assemble(self.time)
        if self.bounds:
            self.require_solution(self.bounds.begin(self.split, self.residuals[0]))
        self.history.measure()
        self.require_solution(self.split.begin(self.flow.solvent_viscosity, self.residuals[0]))
        if self.polymer:
            self.polymer.begin()
        if self.bounds:
            self.bounds.measure(self.time, self.polymer)
            self.bounds.find_fastest()
        self.begin_steps()

    @property
    def speed(self):
        """Largest velocity relative to the mean: what steps and errors refer to."""
        return max(float(view(self.history.fastest)), SMALLEST_SPEED * self.flow.reference_velocity)

    def begin_steps(self):
        """Choose the first step, or the first one after a change."""
        self.control.dt_next = FIRST * self.control.limit(self.speed)

    @property
    def finished(self):
        """Whether the last target is reached."""
        return self.control.finished

    def advance(self):
        """Take one step, in as many attempts as its error asks for; raise DivergedError where it runs away."""
        if self.time in self.flow.changes:
            self.begin_again()
        unresolved = self.history.divergence_scale * self.flow.spacing / self.speed
        for _ in range(MOST_ATTEMPTS):
            length = self.control.choose_dt(self.time)
            error, order = self.attempt(length)
            if self.control.accepts(error / self.speed, order, length, unresolved):
                break
            self.rejected += 1
        self.conclude(length)

    def begin_again(self):
        """Forget what was before: no polynomial in time goes on where walls jump, and steps begin as those of a run."""
        self.lengths = []
        self.bounds.jump(self.time)
        self.begin_steps()

    def attempt(self, length):
        """Compute the velocities at the end of a step; return their estimated error, and of which order it is."""
        times = Times([length, *self.lengths], length)
        view(self.history.path)[...] = times.path()
        self.history.predict()
        if self.bounds:
            self.bounds.predict(times, length)
        self.assemble(self.time + length)
        leading, back = times.backwards()
        view(self.split.back)[...] = back
        view(self.split.ahead)[...] = times.ahead(VELOCITIES)
        view(self.split.ahead_pressure)[...] = times.ahead(PRESSURES)
        nu, spacing = self.flow.solvent_viscosity, self.flow.spacing
        if self.polymer:
            self.polymer.prepare(times, length, self.time + length)
            nu += self.polymer.viscosity
        rate = DECAY[0] * nu / spacing**2 + DECAY[1] * self.speed / spacing
        kept = max(0.0, leading - rate * length)
        self.split.look_back()
        if self.bounds:
            self.bounds.drive(self.split, times)
            self.bounds.push(self.split, times, length)
        self.require_solution(self.split.solve(leading, length, nu, kept, self.residuals))
        error = self.split.error()
        if not math.isfinite(error):
            self.require_solution(False)
        return times.error(error, leading, self.speed)

    def assemble(self, time):
        """Put the points where they are at the end of a step, at ``time``, and compute the operators there."""
        if self.bounds:
            self.bounds.place(time)
        self.points.find_neighbours()
        needed = self.points.overflow()
        if needed:
            raise clustered(f"neighbours of a particle ({needed})", self.steps + 1, self.time)
        self.operators.assemble()
        self.grid.sort()
        if self.bounds:
            self.bounds.close()

    def require_solution(self, found):
        """Raise DivergedError where the linear systems have none."""
        if not found:
            text = f"the linear systems cannot be solved at step {self.steps + 1}, t = {self.time:.6g}"
            raise DivergedError(f"u, v, pressure: {text}")

    def conclude(self, length):
        """Take up the new velocities, measure them, and shift the particles."""
        self.split.take_up()
        if self.bounds:
            self.bounds.conclude(self.split.velocity.x)
        self.history.measure()
        if self.polymer:
            self.steepest = self.polymer.take_up(self.split.velocity.x, self.steps + 1)
        if self.bounds:
            self.bounds.measure(self.time + length, self.polymer)
        gone = length * self.speed / self.flow.spacing
        self.shift.spread(self.steps == 0 and not self.bounds, min(1.0, gone / GONE))
        self.history.settle()
        if self.polymer:
            self.polymer.settle()
        if self.bounds:
            self.bounds.find_fastest()
        if self.speed > RUNAWAY * self.flow.reference_velocity:
            text = f"{RUNAWAY:g} times the reference velocity at step {self.steps + 1}, t = {self.time:.6g}"
            raise DivergedError(f"u, v: above {text}: the flow needs a smaller spacing")
        if (self.steps + 1) % TIDYING == 0:
            self.history.tidy([self.polymer.tensors] if self.polymer else [])
        self.time = self.control.end(self.time, length)
        self.lengths = [length, *self.lengths][: VELOCITIES - 1]
        self.control.step_taken(self.time, self.speed)
        self.steps += 1
        self.shortest, self.longest = min(self.shortest, length), max(self.longest, length)
        self.reduced += int(view(self.operators.order_reduced))
        self.dropped += int(view(self.operators.singular))
        self.iterations = [sum(pair) for pair in zip(self.iterations, self.split.iterations, strict=True)]

    def output_times(self, due):
        """Return the times at which there is a snapshot, of those that are ``due``: all, since steps are dense."""
        return due

    def snapshot(self, time=None):
        """Return the state at ``time``, within the last step, or now, as a Snapshot.

        It lies on the polynomial through what the particles carry, in the order of creation; ``seen`` is that of the
        last step, since many outputs may fall into one.
        """
        time = self.time if time is None else time
        if self.seen is None or self.seen[0] != self.time:
            self.seen = (self.time, *carried_in_order(self))
        return state(self, time)

    def momentum_balance(self):
        """Return the ``change`` of momentum along x up to ``time`` [mass * velocity per length], which has no cause."""
        if self.bounds:  # walls push and pull: their forces are in the samples
            return {}
        gained = float(active(self.history.carried)[:, 0].sum(dtype=float)) - self.initial_momentum
        return {"change": self.flow.density * self.flow.spacing**2 * gained}

    def numbers(self):
        """Return what ``summary.json`` says about this scheme."""
        return {
            "mach": 0.0,
            "sound_speed": None,
            "particles_wall": 0,
            "neighbours_mean": self.points.mean_length(),
            "steps_rejected": self.rejected,
            "order_reduced": self.reduced,
            "neighbourhoods_dropped": self.dropped,
            "divergence": self.history.residual,
            "iterations_pressure": self.iterations[0] / max(self.steps, 1),
            "iterations_velocity": self.iterations[1] / max(self.steps, 1),
        }

    def parts(self):
        """Return everything whose fields a resumed run needs, by name."""
        return {"history": self.history, **({"polymer": self.polymer} if self.polymer else {})}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        walls = self.bounds.host_state() if self.bounds else None
        return {**{name: getattr(self, name) for name in HOST_STATE}, "walls": walls, **self.control.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in HOST_STATE:
            setattr(self, name, state[name])
        self.control.restore_host_state(state)
        if self.bounds:
            self.bounds.restore_host_state(state["walls"])

    def set_targets(self, targets):
        """Go on to other targets; return whether the steps so far are those of a run that had them from the start."""
        return self.control.set_targets(targets, self.time)
