"""What each scheme supports: rheologies, ways to drive a wall, wall treatments at bodies."""

EXPLICIT_RHEOLOGIES = ("newtonian", "oldroyd_b")
"""Rheologies of the explicit scheme; the implicit one takes each that has a ``Law``, and ``multi_mode``."""

AROUND_BODIES = ("adami", "virtual_image", "comoving_image")
"""Wall treatments of the explicit scheme at walls of bodies; the first one where a config names none."""

STRESS_CONTROLLED = [(side, "stress_controlled") for side in ("bottom", "top")]
"""Walls that may be stress-controlled, and the property that says so."""

SCHEDULED = [(side, "velocities") for side in ("bottom", "top")]
SCHEDULED += [(side, "angular_velocities") for side in ("inner", "outer")]
"""Walls that may have velocities at times, and the key of these."""


def problems(config, scheme):
    """Yield dotted key and text where ``scheme`` cannot serve the rheology of the config, or the motion of a wall."""
    walls = getattr(config, "walls", None)
    for keys, kind in ((STRESS_CONTROLLED, "stress-controlled wall"), (SCHEDULED, "wall with velocities at times")):
        found = [side for side, key in keys if getattr(getattr(walls, side, None), key, None)]
        if found and scheme != "implicit":
            yield "scheme.type", f"{scheme} has no {kind} (walls.{found[0]}); take implicit"
    name = config.fluid.rheology.type
    if scheme == "wcsph" and name not in EXPLICIT_RHEOLOGIES:
        yield "scheme.type", f"wcsph has no {name} fluid; take implicit"
