"""What ``tisph bench features`` compares: scenes with and without a part, as configs in plain dicts."""

from dataclasses import dataclass

from tisph.verification.flows import drive, implicit, jitter, merged, oldroyd_b, walls

EXPLICIT = {
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 2.0},
    "discretisation": {"particles_across": 50},
    "walls": {"bottom": {"velocity": 0.0}, "top": {"velocity": 0.5}},
    "scheme": {"type": "wcsph"},
    "time": {"end": 20.0},
    "output": {"video": None},
    "runtime": {"threads": 1},
}
"""Start-up Couette flow, Re = 50, 5000 particles, with nothing that could be left out."""

# steps of 0.02 = spacing / wall velocity / 2, all alike: those that follow the flow differ from scene to scene
IMPLICIT = merged(EXPLICIT, implicit(), {"scheme": {"largest_strain": 0.7}, "time": {"cfl": 0.5, "tolerance": 3e-5}})

# as fast as the plain scene, so that steps are as long
BODY_ACCELERATION = drive(1e-3)
OSCILLATING = {"walls": {"top": {"velocity": None, "amplitude": 0.5, "angular_frequency": 0.5}}}
POLYMER = merged(oldroyd_b(relaxation_time=1.0, solvent_fraction=0.5), {"fluid": {"kinematic_viscosity": 0.01}})
CUTOFF = {"scheme": {"equation_of_state": {"type": "tait", "pressure_cutoff": -1.0}}}
ARTIFICIAL = {"scheme": {"artificial_viscosity": 0.1}}
STANDARD = {"scheme": {"operators": "standard"}}


@dataclass(frozen=True)
class Scene:
    """A config, run by the program, by one that ``stripped`` its unused parts, or by one ``without_shifting``."""

    config: dict
    stripped: bool = False
    without_shifting: bool = False


@dataclass(frozen=True)
class Comparison:
    """A part of the program and the names of the scenes with it and without it."""

    part: str
    scene: str
    without: str = "plain"


@dataclass(frozen=True)
class Group:
    """Scenes of one scheme by name, what to compare, and how many steps are timed at once."""

    scenes: dict
    comparisons: tuple
    steps: int


AGAIN, WITHOUT_CODE, SHIFTLESS = "the same again", "code of unused parts deleted", "no shifting"

GROUPS = {
    "explicit": Group(
        {
            "plain": Scene(EXPLICIT),
            AGAIN: Scene(EXPLICIT),
            WITHOUT_CODE: Scene(EXPLICIT, stripped=True),
            "polymer": Scene(merged(EXPLICIT, POLYMER)),
            "cutoff": Scene(merged(EXPLICIT, CUTOFF)),
            "artificial": Scene(merged(EXPLICIT, ARTIFICIAL)),
            "driven": Scene(merged(EXPLICIT, BODY_ACCELERATION)),
            "oscillating": Scene(merged(EXPLICIT, OSCILLATING)),
            "standard": Scene(merged(EXPLICIT, STANDARD)),
        },
        (
            Comparison("nothing: noise", AGAIN),
            Comparison("code of unused parts", "plain", WITHOUT_CODE),
            Comparison("polymer stress (oldroyd_b)", "polymer"),
            Comparison("pressure cutoff", "cutoff"),
            Comparison("artificial viscosity", "artificial"),
            Comparison("body acceleration", "driven"),
            Comparison("oscillating wall", "oscillating"),
            Comparison("shifting, corrections, density diffusion", "plain", "standard"),
        ),
        50,
    ),
    "implicit": Group(
        {
            "plain": Scene(IMPLICIT),
            AGAIN: Scene(IMPLICIT),
            SHIFTLESS: Scene(IMPLICIT, without_shifting=True),
            "driven": Scene(merged(IMPLICIT, BODY_ACCELERATION)),
            "oscillating": Scene(merged(IMPLICIT, OSCILLATING)),
            "jitter": Scene(merged(IMPLICIT, jitter(0.2))),
            "jitter, no shifting": Scene(merged(IMPLICIT, jitter(0.2)), without_shifting=True),
        },
        (
            Comparison("nothing: noise", AGAIN),
            Comparison("body acceleration", "driven"),
            Comparison("oscillating wall", "oscillating"),
            Comparison("shifting, lattice (nothing to shift)", "plain", SHIFTLESS),
            Comparison("shifting, jitter 0.2", "jitter", "jitter, no shifting"),
        ),
        4,
    ),
}


@dataclass(frozen=True)
class Part:
    """A part that is compiled in or not: the config that does not use it, said outright, and the names of its flags."""

    name: str
    unused: dict
    flags: tuple[str, ...]


PARTS = (
    Part("polymer stress", {"fluid": {"rheology": {"type": "newtonian"}}}, ("carries_stress", "tracks_walls")),
    Part("pressure cutoff", {"scheme": {"equation_of_state": {"pressure_cutoff": None}}}, ("limits_tension",)),
    Part("artificial viscosity", {"scheme": {"artificial_viscosity": 0.0}}, ("has_artificial_viscosity",)),
    Part("body acceleration", drive(0.0), ("driven",)),
    Part("oscillating wall", walls(0.0, 0.5), ("oscillates",)),
)
