"""Fields that are given as Python functions: an initial velocity, a body force, a source of the conformation."""

import numpy as np

from tisph.errors import ConfigError


def with_functions(scene, scheme, initial_velocity=None, body_force=None, conformation_source=None):
    """Return ``scene`` with an initial velocity, an acceleration and a source given as functions of (x, y, t).

    Each function takes arrays (particles,) of places, and a time. It returns physical components, which broadcast to
    the places: velocity and acceleration along x and y, and around the axis as a third one where the flow is
    axisymmetric; the source as xx, xy, yy, in axisymmetric flow xx, xr, rr, tt, xt, rt of the conformation tensor per
    time. A drive of the config acts beside the body force. Such a flow has no reference. ConfigError where the scene,
    or the ``scheme`` (its type), has no use for one of them.
    """
    free = scene.periodic == (True, True) and not scene.bodies and not scene.parallel
    planar = scheme == "implicit" and not scene.parallel
    if initial_velocity is not None and not (free or planar):
        raise ConfigError(
            f"initial_velocity: with scheme {scheme} this scene starts from rest or from its own solution; a function "
            "can be given in the scenes taylor_green and shear_layer, and with scheme implicit in all two-dimensional "
            "flows"
        )
    if body_force is not None and scheme == "implicit" and scene.parallel:
        raise ConfigError(
            f"body_force: scheme {scheme} knows no acceleration but a constant drive.acceleration in a channel without "
            "bodies; a function can be given with scheme wcsph, and with implicit in all two-dimensional flows"
        )
    if conformation_source is not None and not (planar and scene.polymer and len(scene.rheology.laws(1.0)) == 1):
        raise ConfigError(
            "conformation_source: must be left out here; it is for two-dimensional flow of a fluid whose polymer has "
            "one relaxation time, with scheme implicit"
        )
    if initial_velocity is None and body_force is None and conformation_source is None:
        return scene
    given = {"fields": (), "initial": lambda _self, x, y: scene.initial(x, y)}
    if scene.axisymmetric:
        given["swirls"] = True
    if body_force is not None:
        force = _on_places(body_force, scene.components)
        given["body_force"] = staticmethod(_sum(force, scene.body_force))
        if scene.frame_velocity:

            def moved(x, y, t):
                return force((x + scene.frame_velocity * (t - scene.start_time)) % scene.extent[0], y, t)

            frame = with_functions(scene.in_flow_frame(), scheme, body_force=moved)
            given["in_flow_frame"] = lambda _self: frame
    if conformation_source is not None:
        given["conformation_source"] = staticmethod(_on_places(conformation_source, 6 if scene.axisymmetric else 3))
    if initial_velocity is not None:
        velocity = _on_places(initial_velocity, scene.components)

        def initial(_self, x, y):
            return {**scene.initial(x, y), **dict(zip("uvw", velocity(x, y, scene.start_time), strict=False))}

        given |= {"initial": initial, "has_own_start": planar}
        given["initial_velocity"] = staticmethod(lambda x, y: np.stack(velocity(x, y, scene.start_time)))
        if free:
            fastest = float(np.hypot(*velocity(*scene.lattice(), scene.start_time)).max())
            given["peak_velocity"] = max(scene.peak_velocity, fastest)
    changed = object.__new__(type(type(scene).__name__, (type(scene),), given))
    vars(changed).update(vars(scene))
    return changed


def _on_places(function, count):
    """Return ``function`` with ``count`` components as arrays of finite numbers, of the shape of the places.

    Three components may be two: the one around the axis is 0 then.
    """

    def on_places(x, y, t):
        values = [np.broadcast_to(np.asarray(each, dtype=float), x.shape) for each in function(x, y, t)]
        if count == 3 and len(values) == 2:
            values.append(np.zeros(x.shape))
        if len(values) != count or not np.isfinite(values).all():
            raise ConfigError(f"{function}: must return {count} components of finite numbers, at t = {t:g}")
        return values

    return on_places


def _sum(function, other):
    """Return the sum of two functions; ``other`` may be None."""
    if other is None:
        return function

    def both(x, y, t):
        return [a + b for a, b in zip(function(x, y, t), other(x, y, t), strict=True)]

    return both
