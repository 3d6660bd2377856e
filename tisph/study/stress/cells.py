"""One cell of the stability matrix: a flow, how it is computed, and what is promised of the run.

Every flow has a gap, a density and a reference velocity of 1, so that the viscosity is 1/Re, a time is counted in
gaps over reference velocity, and t* = 1 is at t = Re.
"""

from dataclasses import dataclass, replace

from tisph.equation_of_state import SCALE_RATIO, Tait, sound_speed
from tisph.schemes._time_step import AUTO_CFL
from tisph.verification.flows import merged, oldroyd_b, walls

SOLVENT_FRACTION = 0.1
"""The smallest for which Oldroyd-B flow is verified."""

PENETRATION = 1 / 3
"""Depth sqrt(2 nu/w) to which an oscillating wall moves the liquid, in gaps."""

TOLERANCE, STRAIN = 3e-7, 0.5
"""Defaults of scheme ``implicit``, which step multiples start from."""

SAMPLES = (0.25, 0.5, 0.75, 1.0)
"""Parts of a run after which it is looked at; growth is what the last two show."""

STABLE, FINISHED, HONEST, REFUSED = "stable", "finished", "honest", "refused"
"""What is promised: a stable run; one that finishes without growth, with an error that the map states; anything but a
wrong result that looks right; that ``tisph check`` refuses it."""


@dataclass(frozen=True)
class Cell:
    """One run of the matrix.

    ``flow``: a key of ``FLOWS``; ``jitter`` in spacings; ``scheme``: a key of ``SCHEMES``; ``step``: length of the
    steps over that of the defaults; ``sound``: sound speed over the fastest velocity scale (explicit scheme only);
    ``aspect``: length of the channel over its gap; ``t_star``: end of the run, if there is time for that.
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
            "t_star": f"t{self.t_star:g}",
        }
        return "-".join(parts + [text for key, text in special.items() if getattr(self, key) != getattr(usual, key)])

    @property
    def calm(self):
        """The same cell from the lattice."""
        return replace(self, jitter=0.0)

    @property
    def cell_reynolds(self):
        """Reynolds number of a particle spacing, U dx / nu, by the viscosity of the solvent."""
        return self.reynolds / self.across / (SOLVENT_FRACTION if self.has_polymer else 1.0)

    @property
    def usual(self):
        """Whether walls, steps and sound speed are the defaults."""
        defaults = Cell()
        return all(getattr(self, key) == getattr(defaults, key) for key in ("treatment", "step", "sound"))

    @property
    def has_polymer(self):
        """Whether the liquid is an Oldroyd-B liquid."""
        return self.flow.startswith("oldroyd")

    @property
    def measure(self):
        """Error that is judged: l2, or rms where the velocity crosses zero."""
        return "rms" if self.flow in ("backflow", "oscillating") else "l2"

    @property
    def promise(self):
        """``STABLE``, ``FINISHED``, ``HONEST`` or ``REFUSED``."""
        if self.has_polymer and self.scheme != "explicit":
            return REFUSED
        resolved = self.across >= 25 and self.jitter <= 0.3 and self.scheme != "implicit 2"
        if not (self.usual and resolved and self.flow in ("couette", "poiseuille")):
            return HONEST
        if self.reynolds <= 1000:
            return STABLE
        return FINISHED if self.flow == "couette" else HONEST

    @property
    def promised(self):
        """Whether something is promised of the result."""
        return self.promise in (STABLE, FINISHED)

    def config(self, t_star):
        """Config of the run to ``t_star``, a plain dict without a name."""
        end = t_star * self.reynolds
        return merged(
            {
                "scene": "channel",
                "fluid": {"density": 1.0},
                "geometry": {"gap": 1.0, "length": self.aspect},
                "walls": {"treatment": {"type": self.treatment}},
                "initial": {"jitter": self.jitter},
                "discretisation": {"particles_across": self.across, "precision": self.precision},
                "time": {"end": _digits(end), "samples": [_digits(part * end) for part in SAMPLES]},
                "output": {"video": None},
                "runtime": {"threads": 1},
            },
            FLOWS[self.flow](1.0 / self.reynolds),
            self._scheme_change(),
        )

    def _scheme_change(self):
        if self.scheme == "explicit":
            state = {"sound_speed": "auto" if self.sound == SCALE_RATIO else self._sound_speed()}
            change = {"scheme": {"type": "wcsph", "equation_of_state": state}}
            return merged(change, {"time": {"cfl": AUTO_CFL * self.step}} if self.step != 1.0 else {})
        # the error of a step goes with the third power of its length
        return {
            "scheme": {
                "type": "implicit",
                "operators": {"order": int(self.scheme[-1])},
                "largest_strain": STRAIN * self.step,
            },
            "time": {"tolerance": _digits(TOLERANCE * self.step**3)},
        }

    def _sound_speed(self):
        """Sound speed for ``sound`` times the velocity scale by which an automatic one goes."""
        nu = 1.0 / self.reynolds
        relaxation = float(self.flow.removeprefix("oldroyd")) if self.has_polymer else None
        automatic = sound_speed(
            Tait(),
            reference_velocity=PEAK_VELOCITY.get(self.flow, 1.0),
            kinematic_viscosity=nu,
            length=1.0,
            density=1.0,
            elastic_speed=((1.0 - SOLVENT_FRACTION) * nu / relaxation) ** 0.5 if relaxation else 0.0,
        )
        return _digits(automatic * self.sound / SCALE_RATIO)


def _digits(number):
    """The number to twelve digits, so that it reads as it is meant."""
    return float(f"{number:.12g}")


def _couette(nu):
    return merged(_viscosity(nu), walls(0.0, 1.0))


def _poiseuille(nu):
    """Mean speed g H^2 / (12 nu) = 1."""
    return merged(_viscosity(nu), {"drive": {"acceleration": _digits(12.0 * nu)}})


def _backflow(nu):
    """g H^2 / (2 nu U) = -4: the liquid flows back over three quarters of the gap."""
    return merged(_viscosity(nu), walls(0.0, 1.0), {"drive": {"acceleration": _digits(-8.0 * nu)}})


def _oscillating(nu):
    frequency = _digits(2.0 * nu / PENETRATION**2)
    return merged(_viscosity(nu), {"walls": {"top": {"amplitude": 1.0, "angular_frequency": frequency}}})


def _polymer(weissenberg):
    """Couette flow of an Oldroyd-B liquid; its relaxation time is the Weissenberg number."""
    return lambda nu: merged(oldroyd_b(weissenberg, SOLVENT_FRACTION), _couette(nu))


def _viscosity(nu):
    return {"fluid": {"kinematic_viscosity": _digits(nu)}}


FLOWS = {
    "couette": _couette,
    "poiseuille": _poiseuille,
    "backflow": _backflow,
    "oscillating": _oscillating,
    "oldroyd0.1": _polymer(0.1),
    "oldroyd1": _polymer(1.0),
    "oldroyd5": _polymer(5.0),
}
"""What drives each flow, as the change of a config that a viscosity makes; the number behind oldroyd is Wi."""

PEAK_VELOCITY = {"poiseuille": 1.5, "backflow": 2.0}
"""Bound of the speed in reference velocities where it is not 1, see ``Channel.peak_velocity``."""

SCHEMES = {"explicit": "exp", "implicit 2": "imp2", "implicit 4": "imp4"}
"""Schemes and orders, and their short names."""
