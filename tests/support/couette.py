"""Start-up Couette flow of a few particles, for tests of what runs leave and say."""

import json

FLOW = {
    "name": "small",
    "scene": "channel",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"gap": 1.0, "length": 1.0},
    "walls": {"top": {"velocity": 0.5}},
    "discretisation": {"particles_across": 12},
    "time": {"end": 1.0},
    "runtime": {"threads": 1},
}


def couette(**sections):
    """Return the config with these ``sections`` in the place of its own, or beside them."""
    return {**FLOW, **sections}


def couette_text(**sections):
    """Return the same as the text of a config file: JSON is YAML."""
    return json.dumps(couette(**sections))
