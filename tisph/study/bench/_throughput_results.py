"""What the rounds of ``tisph bench throughput`` gave: costs, ratios, bytes, and what they must be."""

from dataclasses import dataclass
from statistics import median

from tisph.study.bench._throughput_cases import ACROSS, Case

REBUILDING = ("binning", "list", "walls")
SMALL, MIDDLE, LARGE = ACROSS
LAMMPS, PYSPH, TUNED = "LAMMPS SPH", "PySPH TVF", "PySPH TVF, tuned"


@dataclass(frozen=True)
class Check:
    """A number of this call (one for each round) that must be at least ``least`` or at most ``most``."""

    what: str
    values: tuple[float, ...]
    least: float = 0.0
    most: float = float("inf")

    @property
    def value(self):
        """Median of the rounds."""
        return median(self.values)

    @property
    def bound(self):
        """The bound as text."""
        parts = [f">= {self.least:g}"] * (self.least > 0) + [f"<= {self.most:g}"] * (self.most < float("inf"))
        return ", ".join(parts)

    @property
    def passed(self):
        """Whether the median is within the bound."""
        return self.least <= self.value <= self.most


class Results:
    """Lists with an entry for each round: of our ``cases`` by ``Case``, of the ``references`` (the C++ loop) by
    (precision, threads, across), and of the ``peers`` by (label, threads, across).
    """

    def __init__(self):
        self.cases, self.references, self.peers = {}, {}, {}

    def interval(self, case):
        """Steps between two rebuilds of the lists, by the median of the rounds.

        Where fewer were seen than at the smallest size, those of the smallest size: steps shorten with the spacing, and
        so lists last longer the finer the particles are.
        """
        seen = [self.cases[one] for one in (case, self._smallest(case)) if one in self.cases]
        return max(median(one["interval"] for one in rounds) for rounds in seen)

    def _smallest(self, case):
        fitting = [one for one in self.cases if one.scheme == case.scheme and one.precision == case.precision]
        return min(fitting, key=lambda one: (one.across, one.threads != case.threads))

    def cost(self, case):
        """Nanoseconds per particle and step in every round, all included; empty where it was not measured."""
        if case.scheme == "implicit" or case not in self.cases:
            return [one["step"] for one in self.cases.get(case, ())]
        interval = self.interval(case)
        return [one["step"] + sum(one[part] for part in REBUILDING) / interval for one in self.cases[case]]

    def parts(self, case):
        """Nanoseconds per particle and step of the parts of an explicit step: medians of the rounds."""
        interval = self.interval(case)
        rounds = self.cases[case]
        found = {part: median(one[part] for one in rounds) / interval for part in REBUILDING}
        found["pass"] = median(one["pass"] for one in rounds)
        found["integration"] = median(one["kernel"] - one["pass"] for one in rounds)
        found["rest"] = median(one["step"] - one["kernel"] for one in rounds)
        return found

    def reference_cost(self, case):
        """The cost of the C++ loop at the size, precision and threads of ``case``, with as many rebuilds."""
        rounds = self.references.get((case.precision, case.threads, case.across), ())
        return [one["step"] + one["rebuild"] / self.interval(case) for one in rounds]

    def peer_cost(self, label, threads, across):
        """Nanoseconds per particle and step of a peer."""
        rounds = self.peers.get((label, threads, across), ())
        return [1e9 * one["loop_seconds"] / one["steps"] / one["particles"] for one in rounds]

    def memory(self, case):
        """Bytes a particle: measured, as the growth of a process from the smallest size, and as ``tisph check`` says.

        The smallest peaks of all rounds and threads: a run that finds its compiled kernels needs less.
        """
        peak, smallest = self._peak(case, case.across), self._peak(case, SMALL)
        particles = case.particles - 2 * SMALL**2
        return 1e6 * (peak - smallest) / particles, 1e6 * self.cases[case][0]["estimated_mb"] / case.particles

    def _peak(self, case, across):
        same = [one for one in self.cases if (one.scheme, one.precision) == (case.scheme, case.precision)]
        return min(one["peak_mb"] for key in same if key.across == across for one in self.cases[key])


def ratios(above, below):
    """Ratios round by round: what disturbs a round disturbs both."""
    return tuple(one / other for one, other in zip(above, below, strict=False))


def checks(results):
    """Every ``Check`` for which there are numbers."""
    found = [*_against_others(results), *_among_ours(results), *_of_memory(results)]
    return [check for check in found if check.values]


def _against_others(results):
    for across, threads, least in ((SMALL, 1, 1.2), (MIDDLE, 1, 1.4), (MIDDLE, 2, 1.4)):
        ours = results.cost(Case("standard", "f64", threads, across))
        theirs = results.peer_cost(LAMMPS, threads, across)
        yield Check(f"standard over {LAMMPS}, {_size(across, threads)}", ratios(theirs, ours), least)
    ours = results.cost(Case("standard", "f64", 2, MIDDLE))
    yield Check(f"standard over {PYSPH}, {_size(MIDDLE, 2)}", ratios(results.peer_cost(PYSPH, 2, MIDDLE), ours), 15)
    for threads in (1, 2):
        case = Case("standard", "f64", threads, MIDDLE)
        if case in results.cases:
            values = ratios(results.reference_cost(case), results.cost(case))
            yield Check(f"standard over the C++ loop, {_size(MIDDLE, threads)}", values, 0.6)


def _among_ours(results):
    def cost(scheme, threads, across):
        return results.cost(Case(scheme, "f64", threads, across))

    for threads in (1, 2):
        values = ratios(cost("consistent", threads, MIDDLE), cost("standard", threads, MIDDLE))
        yield Check(f"cost of consistent over standard, {_size(MIDDLE, threads)}", values, most=1.35)
    for scheme in ("standard", "consistent"):
        for across in (MIDDLE, LARGE):
            values = ratios(cost(scheme, 1, across), cost(scheme, 2, across))
            yield Check(f"2 threads over 1, {scheme}, {_particles(across)}", values, 1.7)
        values = ratios(cost(scheme, 2, LARGE), cost(scheme, 2, MIDDLE))
        yield Check(f"cost of 1e6 over 1e5 particles, {scheme}, 2 threads", values, most=1.25)


def _of_memory(results):
    for scheme in ("standard", "consistent"):
        case = Case(scheme, "f64", 2, LARGE)
        if case in results.cases:
            measured, said = results.memory(case)
            yield Check(f"bytes a particle, {scheme}, 1e6 particles", (measured,), most=600)
            yield Check(f"bytes over what tisph check says, {scheme}, 1e6 particles", (measured / said,), 0.8, 1.2)


def _size(across, threads):
    return f"{_particles(across)}, {threads} thread{'s' * (threads > 1)}"


def _particles(across):
    return f"{2 * across**2:.0e} particles".replace("e+0", "e")
