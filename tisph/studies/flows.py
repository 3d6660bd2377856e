"""How configs of studies, plain dicts, are put together from changes."""


def digits(number):
    """Return the number to twelve digits: 1.8, not 1.7999999999999998."""
    return float(f"{number:.12g}")


def merged(config, *changes):
    """Return a copy of a nested dict with the values of others put in their place, in turn."""
    result = dict(config)
    for change in changes:
        for key, value in change.items():
            result[key] = merged(result.get(key, {}), value) if isinstance(value, dict) else value
    return result


def oldroyd_b(relaxation_time=1.0, solvent_fraction=0.1):
    """Return the change that makes the fluid an Oldroyd-B fluid of total viscosity 1."""
    rheology = {"type": "oldroyd_b", "relaxation_time": relaxation_time, "solvent_fraction": solvent_fraction}
    return {"fluid": {"kinematic_viscosity": 1.0, "rheology": rheology}}


def walls(bottom, top):
    """Return the change of the walls' constant velocities."""
    return {"walls": {"bottom": {"velocity": bottom}, "top": {"velocity": top}}}
