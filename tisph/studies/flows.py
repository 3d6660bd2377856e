"""The flows that runs are verified with, as configs in plain dicts, and how configs are put together.

Each has a gap of 1 and a density of 1. The Newtonian ones have nu = 0.01, so t = 100 t*; the viscoelastic ones
have a total viscosity of 1, so t = t*. The channel is as short as the neighbour search allows at 25 particles
across: nothing depends on x but what disorder makes of it, and runs cost less.
"""

from dataclasses import dataclass

NEWTONIAN = {
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 0.4},
    "walls": {"treatment": {"type": "consistent_image"}},
    "discretisation": {"particles_across": 50},
    "scheme": {"type": "wcsph"},
}


def digits(number):
    """The number to twelve digits, so that it reads as it is meant."""
    return float(f"{number:.12g}")


def oldroyd_b(relaxation_time=1.0, solvent_fraction=0.1):
    """Change that makes the fluid an Oldroyd-B fluid of total viscosity 1."""
    rheology = {"type": "oldroyd_b", "relaxation_time": relaxation_time, "solvent_fraction": solvent_fraction}
    return {"fluid": {"kinematic_viscosity": 1.0, "rheology": rheology}}


def across(number):
    """Change of the number of particles across the gap."""
    return {"discretisation": {"particles_across": number}}


def jitter(amount, seed=0):
    """Change of the particles' random displacement at the start."""
    return {"initial": {"jitter": amount, "seed": seed}}


def walls(bottom, top):
    """Change of the walls' constant velocities."""
    return {"walls": {"bottom": {"velocity": bottom}, "top": {"velocity": top}}}


def at_times(samples):
    """Change of the times of samples, the last of which is the end."""
    samples = [digits(time) for time in samples]  # 1.8, not 1.7999999999999998
    return {"time": {"end": samples[-1], "samples": samples}}


def treatment(name):
    """Change of the wall treatment."""
    return {"walls": {"treatment": {"type": name}}}


def drive(acceleration):
    """Change of the body acceleration."""
    return {"drive": {"acceleration": acceleration}}


def implicit(order=4):
    """Change to the implicit scheme with operators of an order."""
    return {"scheme": {"type": "implicit", "operators": {"order": order}}}


def state(name):
    """Change of the initial state."""
    return {"initial": {"state": name}}


def _oscillating_top(angular_frequency, phase="cos"):
    return {"walls": {"top": {"amplitude": 0.25, "angular_frequency": angular_frequency, "phase": phase}}}


@dataclass(frozen=True)
class Flow:
    """A flow: its config without times, the t* of its samples, and which error says most about it.

    ``measure`` is ``l2``, or ``rms`` where u crosses zero, so that the exact flow is a poor scale.
    """

    title: str
    config: dict
    samples: tuple[float, ...]
    measure: str

    def at(self, *changes, samples=None):
        """Config of a run with ``changes`` merged in, in turn, and samples at other t* than the flow's if given."""
        return sampled(merged(self.config, *changes), samples or self.samples)


def _flow(title, samples, measure, *changes):
    return Flow(title, merged(NEWTONIAN, *changes), samples, measure)


def sampled(config, sample_times):
    """The config with samples at the given t* = nu t/gap^2, which ends at the last one."""
    viscous_time = config["geometry"]["gap"] ** 2 / config["fluid"]["kinematic_viscosity"]
    return {**config, **at_times([t_star * viscous_time for t_star in sample_times])}


def merged(config, *changes):
    """Copy of a nested dict with the values of others put in their place, in turn."""
    result = dict(config)
    for change in changes:
        for key, value in change.items():
            result[key] = merged(result.get(key, {}), value) if isinstance(value, dict) else value
    return result


# Re = 50, and the shear layer is well inside the channel at t* = 0.027.
COUETTE = _flow("Couette", (0.027,), "l2", walls(0.0, 0.5))

# u_max = g H^2 / (8 nu) = 0.25
POISEUILLE = _flow("Poiseuille", (0.1,), "l2", drive(0.02))

# From the developed flow a discrete steady state is reached to exp(-pi^2 t*) = 0.7 %, as from rest at t* = 1.5, but
# without waiting for the flow itself to develop.
POISEUILLE_STEADY = _flow("steady Poiseuille", (0.5,), "l2", drive(0.02), state("developed"))

# g H^2 / (2 nu U) = -4: u is negative below y = 3/4 once it has developed.
BACKFLOW = _flow("Couette-Poiseuille, backflow", (0.1,), "rms", drive(-0.02), walls(0.0, 0.25))

# Penetration depth sqrt(2 nu/w) = H/2 (slow), H/5 and H/10 (fast). The samples are at phases w t = 2 and 4; 5; 8 and
# 21 (80 and 97 % of the amplitude of the wall's stress): near a zero of the stress an error in phase, which is small
# over its amplitude, would be large over the stress of that moment.
OSCILLATING_SLOW = _flow("slowly oscillating wall", (0.25, 0.5), "rms", _oscillating_top(0.08))
OSCILLATING = _flow("oscillating wall", (0.1,), "rms", _oscillating_top(0.5, "sin"))
OSCILLATING_FAST = _flow("fast oscillating wall", (0.04, 0.105), "rms", _oscillating_top(2.0), state("developed"))

_STOP = {"walls": {"top": {"velocity": 0.0, "velocity_before": 0.5}}}
STOPPED = _flow("stopped wall", (0.027, 0.1), "rms", _STOP, state("developed"))

# Weissenberg number 1 and elasticity number 1
OLDROYD_B_COUETTE = _flow("Oldroyd-B Couette", (0.5, 1.0, 2.0), "l2", oldroyd_b(), walls(0.0, 1.0))
OLDROYD_B_POISEUILLE = _flow("Oldroyd-B Poiseuille", (0.5, 1.0, 2.0), "l2", oldroyd_b(), drive(1.0))
