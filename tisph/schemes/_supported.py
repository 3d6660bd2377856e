"""What each scheme supports: rheologies, ways to drive a wall, wall treatments at bodies."""

SERVED = {
    "implicit": [
        "newtonian",
        "oldroyd_b",
        "giesekus",
        "phan_thien_tanner",
        "fene_p",
        "multi_mode",
        "power_law",
        "carreau_yasuda",
        "herschel_bulkley",
    ],
    "wcsph": ["newtonian", "oldroyd_b"],
}

AROUND_BODIES = ("adami", "virtual_image", "comoving_image")
"""Wall treatments of the explicit scheme at walls of bodies; the first one where a config names none."""

DRIVEN = [("bottom", "driven"), ("top", "driven")]
"""Walls that a stress may drive, and the property that says so."""

SCHEDULED = [(side, "velocities") for side in ("bottom", "top")]
SCHEDULED += [(side, "angular_velocities") for side in ("inner", "outer")]
"""Walls that may have velocities at times, and the key of these."""


def problems(config, scheme):
    """Yield dotted key and text where ``scheme`` cannot serve the rheology of the config, or what drives a wall."""
    walls = getattr(config, "walls", None)
    for keys, kind in ((DRIVEN, "that a stress drives"), (SCHEDULED, "with velocities at times")):
        found = [side for side, key in keys if getattr(getattr(walls, side, None), key, None)]
        if found and scheme != "implicit":
            yield "scheme.type", f"{scheme} has no wall {kind} (walls.{found[0]}); take implicit"
    name = config.fluid.rheology.type
    if name in SERVED[scheme]:
        return
    others = [other for other, served in SERVED.items() if name in served]
    way = f"take {' or '.join(others)}" if others else f"it has {' and '.join(SERVED[scheme])}"
    yield "scheme.type", f"{scheme} has no {name} liquid; {way}"
