"""The comparison of wall treatments as data: which runs, what is read from them, which treatment comes out best.

Every treatment serves every flow, from a lattice and from disordered particles, at several resolutions. The
recommendation needs no taste: of the treatments whose runs all reached their end, and whose step costs at most
``COST_LIMIT`` times that of ``REFERENCE``, it is the one with the smallest geometric mean of the errors at the
resolution ``MEASURED_AT`` over all flows and arrangements. The geometric mean makes a halved error count the same in
every flow, whatever the size of the errors there; costs are averaged over the flows in the same way.
"""

import itertools
import math
from dataclasses import asdict, dataclass

import numpy as np

from tisph.measures.metrics import fitted_order
from tisph.studies import flows
from tisph.studies.flows import Flow, across, jitter, treatment

FLOWS = {
    "couette": flows.COUETTE,
    "poiseuille": flows.POISEUILLE,
    "backflow": flows.BACKFLOW,
    "oscillating": flows.OSCILLATING,
    "oldroyd_b_couette": flows.OLDROYD_B_COUETTE,
    "oldroyd_b_poiseuille": flows.OLDROYD_B_POISEUILLE,
}

TIMES = {"oldroyd_b_couette": 1.0, "oldroyd_b_poiseuille": 1.0}
"""t* at which errors are compared, where it is not the flow's own last sample."""

ARRANGEMENTS = {"lattice": 0.0, "jitter 0.2": 0.2}
"""Random displacement of the particles at the start, in spacings."""

REFERENCE = "comoving_image"
COST_LIMIT = 1.3

ONE_THREAD = {"runtime": {"threads": 1}}

TIMING = {"geometry": {"length": 2.0}}
"""A channel of the usual length, in which a step costs more than what it takes to start its loops."""

TIMING_SHARE = 0.25
"""Part of the flow's time after which a run that only serves to be timed ends."""


@dataclass(frozen=True)
class Extent:
    """How much is compared: particles across the gap, which of them counts, arrangements, timed runs of a row."""

    resolutions: tuple[int, ...]
    measured_at: int
    arrangements: tuple[str, ...]
    repeats: int


FULL = Extent((25, 50, 100), 50, tuple(ARRANGEMENTS), repeats=2)
QUICK = Extent((25, 50), 50, ("lattice",), repeats=1)


@dataclass(frozen=True)
class Case:
    """One row of the table: a flow and a treatment, by name, and an arrangement of the particles."""

    flow: str
    treatment: str
    arrangement: str

    @property
    def t_star(self):
        """Dimensionless time at which errors are compared."""
        return TIMES.get(self.flow, self._flow.samples[-1])

    @property
    def measure(self):
        """Error that is compared: l2, or rms where u crosses zero."""
        return self._flow.measure

    @property
    def title(self):
        """Name of the flow."""
        return self._flow.title

    def name(self, number):
        """Name of the run at ``number`` particles across."""
        return f"{self.flow}-{self.treatment}-{self.arrangement.replace(' ', '_')}-{number}"

    def config(self, number):
        """Config of the run at ``number`` particles across, on one thread."""
        return self._flow.at(*self._changes(number), samples=(self.t_star,))

    def timing(self, extent):
        """Names of the runs that only serve to be timed, and their config."""
        number, samples = extent.measured_at, (TIMING_SHARE * self.t_star,)
        names = [f"{self.name(number)}-timed-{count + 1}" for count in range(extent.repeats)]
        return dict.fromkeys(names, self._flow.at(*self._changes(number), TIMING, samples=samples))

    @property
    def _flow(self) -> Flow:
        return FLOWS[self.flow]

    def _changes(self, number):
        return across(number), jitter(ARRANGEMENTS[self.arrangement]), treatment(self.treatment), ONE_THREAD


@dataclass(frozen=True)
class Row:
    """What the runs of a case showed; NaN where a run gave no number.

    ``errors`` by particles across; ``order`` of their fall; ``wall_shear`` error, see ``wall_shear_error``;
    ``stress_error`` = ``shear_stress_l2``, None without polymer; ``step_seconds`` for one step of a timed run
    and ``cost``, the same over that of ``REFERENCE``; ``stopped``: messages of runs that did not reach their end.
    """

    case: Case
    errors: dict[int, float]
    order: float
    wall_shear: float
    stress_error: float | None
    step_seconds: float
    cost: float
    stopped: dict[str, str]


def cases(flow, treatments, extent):
    """Rows of a flow: every arrangement of each of ``treatments``."""
    return [Case(flow, name, arrangement) for name in treatments for arrangement in extent.arrangements]


def runs(cases, extent):
    """Configs of the runs of ``cases`` that give errors, by name."""
    return {case.name(number): case.config(number) for case in cases for number in extent.resolutions}


def timing(cases, extent):
    """Configs of those that give the cost of a step: one of each case in turn, so that a slow minute meets all."""
    rounds = zip(*(case.timing(extent).items() for case in cases), strict=True)
    return dict(itertools.chain.from_iterable(rounds))


def rows(cases, outcomes, extent):
    """``Row`` s of the ``cases`` of a flow from the (``Result``, message) of all their runs by name."""
    timed = {case: {name: outcomes[name] for name in case.timing(extent)} for case in cases}
    reference = {case.arrangement: step_seconds(timed[case]) for case in cases if case.treatment == REFERENCE}
    for case in cases:
        results = {number: outcomes[case.name(number)] for number in extent.resolutions}
        yield row(case, results, timed[case], extent.measured_at, reference[case.arrangement])


def step_seconds(timed):
    """Seconds for a step of the quickest of the timed runs: what disturbs a run only makes it slower.

    ``timed`` maps names of runs to (``Result``, message); NaN where none reached its end.
    """
    summaries = [result.summary for result, _ in timed.values() if result.summary["status"] == "done"]
    return min((summary["cost"]["wall_loop_s"] / summary["cost"]["steps"] for summary in summaries), default=math.nan)


def row(case, results, timed, measured_at, reference_seconds):
    """The ``Row`` of a case.

    ``results`` maps particles across to (``Result``, message), ``timed`` names of timed runs to the same;
    ``reference_seconds`` is what a step of ``REFERENCE`` takes.
    """
    errors = {number: result.measure(case.t_star, case.measure) for number, (result, _) in results.items()}
    measured = results[measured_at][0]
    viscoelastic = "rheology" in FLOWS[case.flow].config["fluid"]
    seconds = step_seconds(timed)
    named = {**{case.name(number): outcome for number, outcome in results.items()}, **timed}
    return Row(
        case=case,
        errors=errors,
        order=fitted_order(errors.keys(), list(errors.values())),
        wall_shear=measured.measure(case.t_star, "wall_shear"),
        stress_error=measured.measure(case.t_star, "shear_stress_l2") if viscoelastic else None,
        step_seconds=seconds,
        cost=seconds / reference_seconds,
        stopped={name: message for name, (_, message) in named.items() if message},
    )


@dataclass(frozen=True)
class Standing:
    """A treatment over all rows: geometric means of its errors and costs, and how many of its runs stopped."""

    treatment: str
    error: float
    cost: float
    stopped: int

    @property
    def eligible(self):
        """Whether every run reached its end, at a cost within the limit."""
        return self.stopped == 0 and math.isfinite(self.error) and self.cost <= COST_LIMIT


def standings(rows, measured_at):
    """``Standing`` of each treatment in ``rows``, in the order in which they appear."""
    by_treatment = {}
    for entry in rows:
        by_treatment.setdefault(entry.case.treatment, []).append(entry)
    return [
        Standing(
            treatment=name,
            error=_geometric_mean([entry.errors[measured_at] for entry in own]),
            cost=_geometric_mean([entry.cost for entry in own]),
            stopped=sum(len(entry.stopped) for entry in own),
        )
        for name, own in by_treatment.items()
    ]


def recommended(found):
    """Name of the eligible treatment with the smallest mean error among the ``Standing`` s; None without one."""
    eligible = [standing for standing in found if standing.eligible]
    return min(eligible, key=lambda standing: standing.error).treatment if eligible else None


def _geometric_mean(values):
    return float(np.exp(np.mean(np.log(values)))) if values else math.nan


def as_data(rows, measured_at):
    """Every number of the comparison, to be written as JSON; null where there is none."""
    found = standings(rows, measured_at)
    return {
        "measured_at": measured_at,
        "cost_limit": COST_LIMIT,
        "recommended": recommended(found),
        "treatments": [_without_nan(asdict(standing)) for standing in found],
        "rows": [
            _without_nan({**asdict(entry), "t_star": entry.case.t_star, "measure": entry.case.measure})
            for entry in rows
        ],
    }


def _without_nan(data):
    if isinstance(data, dict):
        return {str(key): _without_nan(value) for key, value in data.items()}
    return None if isinstance(data, float) and not math.isfinite(data) else data
