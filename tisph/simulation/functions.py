"""Fields that are given as Python functions: an initial velocity, and a body force."""

import numpy as np

from tisph.errors import ConfigError


def with_functions(scene, scheme, initial_velocity, body_force):
    """Return ``scene`` with velocities at the start and an acceleration that are given as functions of (x, y, t).

    Each takes arrays (particles,) of places, and a time, and returns a pair: components along x and y, which broadcast
    to the places. There is no reference for such a flow. ConfigError where the scene, or the ``scheme`` (its type),
    has no use for them. Neither is there anything to check: the velocity should have no divergence and the period of
    the box, and the force that period, too.
    """
    free = scene.periodic == (True, True) and not scene.bodies and not scene.parallel
    if initial_velocity is not None and not free:
        raise ConfigError(
            "initial_velocity: this scene starts from rest or from its own solution; a velocity can be given where a "
            "flow starts from given velocities in a periodic box: scenes taylor_green and shear_layer"
        )
    if body_force is not None and not (free or (scheme == "implicit" and not scene.parallel)):
        raise ConfigError(
            f"body_force: scheme {scheme} knows no acceleration but a constant drive.acceleration here; a function can "
            "be given in the scenes taylor_green and shear_layer, and with scheme implicit in all two-dimensional flows"
        )
    if initial_velocity is None and body_force is None:
        return scene
    given = {"fields": (), "body_force": None, "initial": lambda _self, x, y: scene.initial(x, y)}
    if body_force is not None:
        given["body_force"] = staticmethod(_on_places(body_force))
    if initial_velocity is not None:
        velocity = _on_places(initial_velocity)

        def initial(_self, x, y):
            return {**scene.initial(x, y), **dict(zip(("u", "v"), velocity(x, y, scene.start_time), strict=True))}

        fastest = float(np.hypot(*velocity(*scene.lattice(), scene.start_time)).max())
        given |= {"initial": initial, "peak_velocity": max(scene.peak_velocity, fastest)}
    changed = object.__new__(type(type(scene).__name__, (type(scene),), given))
    vars(changed).update(vars(scene))
    return changed


def _on_places(function):
    """Return ``function`` with both components as arrays of finite numbers, of the shape of the places."""

    def on_places(x, y, t):
        values = [np.broadcast_to(np.asarray(each, dtype=float), x.shape) for each in function(x, y, t)]
        if len(values) != 2 or not np.isfinite(values).all():
            raise ConfigError(f"{function}: must return two components of finite numbers, at t = {t:g}")
        return values

    return on_places
