"""The interface of a scheme: its module, which imports no Taichi, and the object that takes the steps.

A scheme is a module (or a package) of this folder with the members of ``SchemeMember``; its name is the ``type`` in a
config. ``build`` returns the object with the members of ``Scheme``, and imports Taichi. Simulation, observers,
checkpoints and reports use these members alone. A module that chooses another scheme, such as ``auto``, has the members
of ``ChoiceMember`` instead.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypedDict

import numpy as np

from tisph.config.base import Model, Problem
from tisph.config.schema import Config
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot


class Scheme(Protocol):
    """Particles of a scene that are advanced step by step. Lengths and times are in the units of the config."""

    time: float
    """Time at the end of the last step."""

    steps: int
    """Steps taken so far, since the start of the run and not since it was resumed."""

    shortest: float
    """Length of the shortest step so far [time]; infinite before the first."""

    longest: float
    """Length of the longest step so far [time]."""

    @property
    def finished(self) -> bool:
        """Whether the last of the target times is reached."""

    def start(self, position: np.ndarray, velocity: np.ndarray, stress: np.ndarray | None = None) -> None:
        """Place the fluid particles at the start time: ``position``, ``velocity`` (particles, 2).

        ``stress``: polymer stress xx, xy, yy [mass/(length time^2)], (particles, 3), where the scene starts with one.
        Every later snapshot has the particles in this order.
        """

    def advance(self) -> None:
        """Take one step, which ends on the next target time if that is near.

        Raises ``DivergedError`` where no step succeeds or where a field overflows.
        """

    def output_times(self, due: Sequence[float]) -> Sequence[float]:
        """Return the times of the snapshots for those that are ``due`` since the last step, in ascending order.

        The same times where the scheme can interpolate within the step (dense output); else the end of the step.
        """

    def snapshot(self, time: float | None = None) -> Snapshot:
        """Return the state at ``time``, one of ``output_times``; at the end of the last step without one.

        Arrays (particles,) in the order of ``start``; positions within the box of the scene, pressure of mean 0 where
        the scheme determines it up to a constant, NaN for quantities that the scheme does not have.
        """

    def momentum_balance(self) -> Mapping[str, float]:
        """Return numbers for ``momentum`` in ``summary.json``: change of momentum along x and its causes.

        [mass * velocity/length]; see ``_momentum.MomentumBalance.report``. Empty where nothing is known.
        """

    def numbers(self) -> Mapping[str, Any]:
        """Return the scheme's own numbers for ``summary.json``.

        At least ``mach``, ``sound_speed`` (None without one), ``particles_wall`` and ``neighbours_mean``.
        """

    def parts(self) -> Mapping[str, Any]:
        """Return the objects whose fields and arrays a checkpoint keeps, by name.

        All Taichi fields and NumPy arrays among their attributes are kept; a field may limit that by an attribute
        ``used``, an index of NumPy, or None for nothing that outlives a step.
        """

    def host_state(self) -> Mapping[str, Any]:
        """Return everything else that a resumed run needs, as plain data that JSON can hold."""

    def make_room(self, state: Mapping[str, Any]) -> None:
        """Make the fields as large as those of a ``host_state``; bodies may have left, and particles replaced them."""

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the data of ``host_state``; the fields are restored already."""

    def set_targets(self, targets: Sequence[float]) -> bool:
        """Go on to other target times; return whether a run that had them from the start would have the same steps."""


@dataclass(frozen=True)
class SampleEstimate:
    """Estimates of one sample: its time ``t``, the number of ``steps`` up to it, errors as in the summary.

    ``l2`` and ``rms``, see ``measures/metrics.py``, are None where there is no estimate before the run, ``l2`` also
    where the fluid rests, or nearly so. ``at_most``: the run may have a smaller error. ``steps_reliable``: the steps
    are an estimate; else no more than a guess, from the speed that the config gives. ``steps_factors``: least and
    largest steps of the run over ``steps``. ``judged_by``: numbers of the run that decide whether its sample is
    resolved, in words; empty where that is known before.
    """

    t: float
    steps: int
    l2: float | None = None
    rms: float | None = None
    at_most: bool = False
    steps_reliable: bool = True
    steps_factors: tuple[float, float] = (1.0, 1.0)
    judged_by: tuple[str, ...] = ()

    def steps_range(self, steps: int) -> tuple[int, int]:
        """Return the least and the largest number of steps of the run where ``steps`` are estimated."""
        low, high = self.steps_factors
        return max(min(1, steps), math.floor(low * steps)), math.ceil(high * steps)


class SchemeEstimates(TypedDict):
    """Numbers that ``tisph check`` prints of a run before it runs. Lengths and times are in the units of the config."""

    mach: float
    """Peak speed over the speed of sound; 0 for an incompressible fluid."""

    sound_speed: float | None
    """Speed of sound [length/time]; None without one."""

    time_step: float
    """Longest step, or a bound of it [time]."""

    binding_limit: str
    """Name of the limit of the steps: ``acoustic``, ``viscous``, ``cfl``, ``strain``, ``accuracy`` and others."""

    steps: int
    """Steps to the end of the run."""

    run_time: float
    """Estimated time in the loop on two threads [s]."""

    lost: bool
    """Whether the result would be worthless: ``tisph check`` refuses the config then."""

    samples: list[SampleEstimate]
    """Of each sample: steps and errors as far as known; numbers of the run that judge it."""


class Member(Protocol):
    """Members of every module of this folder, whether it takes steps or chooses a scheme that does."""

    PERIODIC: list[tuple[bool, bool]]
    """Boxes that it can serve, by whether they are periodic in x and y. A literal: it is read without an import."""

    Parameters: type[Model]
    """Its keys in the section ``scheme`` of a config, with ``type``, the literal of its name."""

    def problems(self, config: Config) -> Iterator[Problem]:
        """Yield dotted key and text of everything in a validated config that it cannot serve."""


class SchemeMember(Member, Protocol):
    """Module of a scheme. Its functions take a config whose ``scheme`` is this one (``schemes.resolve``)."""

    def build(self, config: Config, scene: Scene, targets: Sequence[float], serial: bool) -> Scheme:
        """Return the scheme for ``scene`` in its own frame, with steps that end on the times ``targets`` exactly.

        ``serial`` compiles loops without threads. Taichi is imported here.
        """

    def orders(self, config: Config) -> tuple[float, float]:
        """Return the least and the largest order in the spacing that counts as observed, for ``--estimate-error``."""

    def coarsen_steps(self, config: Config, factor: float) -> Config:
        """Return the config with steps ``factor`` times as long for a spacing that is ``factor`` times as wide.

        So errors in time fall with the spacing as those in space do. Limits that go with the spacing stay as they are.
        """

    def estimates(self, config: Config, scene: Scene) -> SchemeEstimates:
        """Return the estimates of a run for ``tisph check``."""


class ChoiceMember(Member, Protocol):
    """Module that chooses among schemes."""

    def resolve(self, config: Config) -> tuple[Config, str]:
        """Return the config with the scheme that is to run, and in words which one and why."""
