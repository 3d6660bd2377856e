"""Which rheologies each scheme serves, and which a wall that is driven by a stress."""

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


def problems(config, scheme):
    """Yield dotted key and text where ``scheme`` cannot serve the rheology of the config, or what drives a wall."""
    walls = getattr(config, "walls", None)
    driven = [side for side in ("bottom", "top") if getattr(getattr(walls, side, None), "driven", False)]
    if driven and scheme != "implicit":
        yield "scheme.type", f"{scheme} has no wall that a stress drives (walls.{driven[0]}); take implicit"
    scheduled = [side for side in ("bottom", "top") if getattr(getattr(walls, side, None), "velocities", None)]
    if scheduled and scheme != "implicit":
        yield "scheme.type", f"{scheme} has no wall with velocities at times (walls.{scheduled[0]}); take implicit"
    name = config.fluid.rheology.type
    if name in SERVED[scheme]:
        return
    others = [other for other, served in SERVED.items() if name in served]
    way = f"take {' or '.join(others)}" if others else f"it has {' and '.join(SERVED[scheme])}"
    yield "scheme.type", f"{scheme} has no {name} liquid; {way}"
