"""One cell of the stability matrix: a flow, how it is computed, and what is required of the run.

A time is counted in lengths over reference velocity; in a channel t* = 1 is at t = Re, in all other flows at t = 1.
"""

from dataclasses import dataclass, replace

from tisph.equation_of_state import SCALE_RATIO, Tait, sound_speed
from tisph.schemes._time_step import AUTO_CFL
from tisph.schemes.auto import ELASTIC_STEPS
from tisph.schemes.implicit import LARGEST_STRAIN
from tisph.studies.flows import digits, merged
from tisph.studies.stability.flows import BODY_ACROSS, FINER, FLOWS, PREDICTABLE, SOLVENT_FRACTION

TOLERANCE, STRAIN = 3e-7, 0.5
"""Defaults of scheme ``implicit``, which step multiples start from."""

ELASTIC_TOLERANCE, ELASTIC_STRAIN = ELASTIC_STEPS["balanced"]
"""Of a viscoelastic fluid, the same of ``auto``, whose steps are three times as long."""

TWO_DIMENSIONAL_TOLERANCE, COURANT = 2e-6, 0.3
"""The same of a two-dimensional flow."""

SAMPLES = (0.25, 0.5, 0.75, 1.0)
"""Parts of a run after which it has a sample; growth is what the last two show."""

STABLE, FINISHED, FLAGGED, REFUSED = "stable", "finished", "flagged", "refused"
"""What is required: a stable run; one that finishes without growth, with an error that the map has; anything but a
silent failure, that is a wrong result without a warning; that ``tisph check`` refuses it."""

REQUIRED = ("couette", "poiseuille", "taylor_green", "shear_layer", "annulus0.5", "annulus0.9")
"""Flows of which more than ``FLAGGED`` is required."""

FINER_JITTER = 0.3
"""Of runs with twice the particles."""

RESOLVED = 10.0
"""Cell Reynolds number up to which a flow between curved walls has to be stable, 12 across or more."""


@dataclass(frozen=True)
class Cell:
    """One run of the matrix.

    ``flow``: a key of ``FLOWS``; ``jitter`` in spacings; ``scheme``: a key of ``SCHEMES``; ``step``: length of the
    steps over that of the defaults; ``sound``: sound speed over the fastest velocity scale (explicit scheme only);
    ``aspect``: length of a channel over its gap; ``solvent``: its part of the viscosity of an Oldroyd-B fluid;
    ``t_star``: end of the run, if there is time for that.
    """

    flow: str = "couette"
    reynolds: float = 50.0
    jitter: float = 0.0
    across: int = 25
    scheme: str = "explicit"
    treatment: str = "consistent_image"
    step: float = 1.0
    sound: float = SCALE_RATIO
    precision: str = "f64"
    aspect: float = 2.0
    solvent: float = SOLVENT_FRACTION
    t_star: float = 1.0

    @property
    def name(self):
        """Name of its run: flow, Reynolds number, jitter, resolution and scheme, then what is not the default."""
        parts = [self.flow, f"re{self.reynolds:g}", f"j{self.jitter:g}", f"n{self.across}", SCHEMES[self.scheme]]
        usual = Cell()
        special = {
            "treatment": self.treatment.removesuffix("_image"),
            "step": f"s{self.step:g}",
            "sound": f"c{self.sound:g}",
            "precision": self.precision,
            "aspect": f"l{self.aspect:g}",
            "solvent": f"b{self.solvent:g}",
            "t_star": f"t{self.t_star:g}",
        }
        return "-".join(parts + [text for key, text in special.items() if getattr(self, key) != getattr(usual, key)])

    @property
    def baseline(self):
        """The same cell from the lattice; of a two-dimensional flow, where a lattice is no calmer, the cell itself.

        Around a body whose drag is compared it is one with twice the particles across, the same for every jitter.
        """
        if self.measure == FINER and self.across <= BODY_ACROSS and not FLOWS[self.flow].refused:
            return replace(self, across=2 * self.across, jitter=FINER_JITTER)
        return self if self.two_dimensional else replace(self, jitter=0.0)

    @property
    def cell_reynolds(self):
        """Reynolds number of a particle spacing, U dx / nu, by the viscosity of the solvent."""
        return self.reynolds / self.across / (self.solvent if self.has_polymer else 1.0)

    @property
    def usual(self):
        """Whether walls, steps and sound speed are the defaults."""
        defaults = Cell()
        return all(getattr(self, key) == getattr(defaults, key) for key in ("treatment", "step", "sound"))

    @property
    def has_polymer(self):
        """Whether the fluid is an Oldroyd-B fluid in a channel."""
        return self.flow.startswith("oldroyd")

    @property
    def weissenberg(self):
        """Relaxation time times wall speed over gap, of an Oldroyd-B fluid; else None."""
        return float(self.flow.removeprefix("oldroyd")) if self.has_polymer else None

    @property
    def elasticity(self):
        """Relaxation time over the viscous time, of an Oldroyd-B fluid."""
        return digits(self.weissenberg / self.reynolds)

    @property
    def doubly_periodic(self):
        """Whether it is in a periodic square, without walls."""
        return FLOWS[self.flow].doubly_periodic

    @property
    def curved_walls(self):
        """Whether it is between curved walls, in a cavity, or around a body."""
        return FLOWS[self.flow].curved_walls

    @property
    def two_dimensional(self):
        """Whether the flow is two-dimensional, so that no particle stays in its layer."""
        return self.doubly_periodic or self.curved_walls

    @property
    def measure(self):
        """Error that is judged: l2 or rms, None where there is none, or where the flow cannot be predicted."""
        lost = self.doubly_periodic and self.reynolds > 1000 and self.t_star > PREDICTABLE
        return None if lost else FLOWS[self.flow].measure

    @property
    def requirement(self):
        """``STABLE``, ``FINISHED``, ``FLAGGED`` or ``REFUSED``."""
        if self.doubly_periodic and self.scheme == "implicit 2":
            return REFUSED
        if self.curved_walls:
            return self._requirement_at_walls()
        resolved = self.across >= 25 and self.jitter <= 0.3 and self.scheme != "implicit 2"
        if not (self.usual and resolved and self.flow in REQUIRED):
            return FLAGGED
        if self.doubly_periodic:
            return self._requirement_if_periodic()
        if self.reynolds <= 1000:
            return STABLE
        return FINISHED if self.flow == "couette" else FLAGGED

    def _requirement_if_periodic(self):
        if self.scheme == "implicit 4":
            return STABLE
        return FINISHED if self.reynolds <= 1000 else FLAGGED

    def _requirement_at_walls(self):
        if FLOWS[self.flow].refused:
            return REFUSED
        resolved = self.across >= 12 and self.jitter <= 0.3 and self.cell_reynolds <= RESOLVED
        return STABLE if self.usual and resolved and self.flow in REQUIRED else FLAGGED

    @property
    def required(self):
        """Whether something is required of the result."""
        return self.requirement in (STABLE, FINISHED)

    def config(self, t_star):
        """Config of the run to ``t_star``, a plain dict without a name."""
        flow = FLOWS[self.flow]
        end = t_star * flow.unit_time(self.reynolds)
        return merged(
            {
                **self._box(),
                "fluid": {"density": 1.0},
                "initial": {"jitter": self.jitter},
                "discretisation": {"particles_across": self.across, "precision": self.precision},
                "time": {"end": digits(end), "samples": [digits(part * end) for part in SAMPLES]},
                "output": {"video": None},
                "runtime": {"threads": 1},
            },
            flow.change(1.0 / self.reynolds),
            {"fluid": {"rheology": {"solvent_fraction": self.solvent}}} if self.has_polymer else {},
            self._scheme_change(),
        )

    def _box(self):
        if self.curved_walls:
            return {}
        if self.doubly_periodic:
            return {"geometry": {"length": 1.0}}
        walls = {"treatment": {"type": self.treatment}}
        return {"scene": "channel", "geometry": {"gap": 1.0, "length": self.aspect}, "walls": walls}

    def _scheme_change(self):
        if self.scheme == "explicit":
            state = {"sound_speed": "auto" if self.sound == SCALE_RATIO else self._sound_speed()}
            change = {"scheme": {"type": "wcsph", "equation_of_state": state}}
            return merged(change, {"time": {"cfl": AUTO_CFL * self.step}} if self.step != 1.0 else {})
        scheme = {"type": "implicit", "operators": {"order": int(self.scheme[-1])}}
        if self.two_dimensional:  # other steps than the default are not controlled by their error
            usual = {} if self.curved_walls else {"tolerance": TWO_DIMENSIONAL_TOLERANCE}
            steps = usual if self.step == 1.0 else {"cfl": digits(COURANT * self.step)}
            return {"scheme": {**scheme, "largest_courant": COURANT}, "time": steps}
        # the error of a step scales with the third power of its length
        tolerance, strain = (ELASTIC_TOLERANCE, ELASTIC_STRAIN) if self.has_polymer else (TOLERANCE, STRAIN)
        return {
            "scheme": {**scheme, "largest_strain": digits(min(strain * self.step, LARGEST_STRAIN))},
            "time": {"tolerance": digits(tolerance * self.step**3)},
        }

    def _sound_speed(self):
        """Sound speed for ``sound`` times the velocity scale by which an automatic one goes."""
        nu = 1.0 / self.reynolds
        relaxation = self.weissenberg
        automatic = sound_speed(
            Tait(),
            reference_velocity=FLOWS[self.flow].peak,
            kinematic_viscosity=nu,
            length=1.0,
            density=1.0,
            elastic_speed=((1.0 - self.solvent) * nu / relaxation) ** 0.5 if relaxation else 0.0,
        )
        return digits(automatic * self.sound / SCALE_RATIO)


SCHEMES = {"explicit": "exp", "implicit 2": "imp2", "implicit 4": "imp4"}
"""Schemes and orders, and their short names."""
