"""What ``tisph bench throughput`` times: schemes, precisions, threads and sizes, as configs in plain dicts."""

from dataclasses import dataclass

from tisph.study.bench.cases import COUETTE
from tisph.verification.flows import merged

SCENE = merged(
    COUETTE,
    {
        "initial": {"jitter": 0.1},
        # 20 neighbours within the kernel, in the bulk of a lattice: pi 2.6^2 less the particle itself
        "discretisation": {"kernel": "wendland_c2", "smoothing_ratio": 1.3},
    },
)
"""Couette flow at Re = 50 on particles that are not quite on a lattice."""

EXPLICIT = {
    "initial": {"state": "developed"},
    "scheme": {"type": "wcsph", "equation_of_state": {"sound_speed": 5.0}},
    "time": {"end": 100.0},
}
"""Steady flow, so that every step and every time between two rebuilds is like the next."""

IMPLICIT = {
    "initial": {"state": "exact", "time": 1.0},
    "scheme": {"type": "implicit"},
    "time": {"end": 10.0, "cfl": 1.0},
}
"""Start-up flow once its layers are smooth, in steps of one length: about the mean of a run to t = 2.7."""

SCHEMES = {
    "standard": merged(EXPLICIT, {"scheme": {"operators": "standard"}}),
    "consistent": merged(EXPLICIT, {"scheme": {"operators": "consistent"}}),
    "implicit": IMPLICIT,
}
"""Change of the scene by the name of a scheme: the explicit one goes by that of its operators."""

ACROSS = (50, 224, 707)
"""Particles between the walls: 5 thousand, 100 thousand and a million in all."""

ROUNDS = 3


@dataclass(frozen=True)
class Case:
    """One scheme at one size, in one precision, with a number of threads."""

    scheme: str
    precision: str
    threads: int
    across: int

    @property
    def name(self):
        """Name of its files, less the number of the round."""
        return f"{self.scheme}_{self.precision}_{self.threads}_{self.across}"

    @property
    def particles(self):
        """Number of fluid particles: the channel is twice as long as wide."""
        return 2 * self.across**2

    @property
    def rounds(self):
        """How often it is run: less where a run takes half a minute, which averages over disturbances by itself."""
        if self.across < ACROSS[-1]:
            return ROUNDS
        return 1 if self.scheme == "implicit" else 2

    @property
    def config(self):
        """Its config."""
        discretisation = {"particles_across": self.across, "precision": self.precision}
        more = {"discretisation": discretisation, "runtime": {"threads": self.threads}}
        return merged(SCENE, SCHEMES[self.scheme], more)


def cases(quick):
    """All cases; ``quick``: those of the two smaller sizes in double precision, the smallest on one thread."""
    return [
        Case(scheme, precision, threads, across)
        for across in (ACROSS[:2] if quick else ACROSS)
        for precision in (("f64",) if quick else ("f64", "f32"))
        for threads in ((1,) if quick and across == ACROSS[0] else (1, 2))
        for scheme in SCHEMES
    ]
