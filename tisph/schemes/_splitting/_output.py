"""The state at any time within the last step, from what the particles carry."""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.schemes._splitting._series import PRESSURES, VELOCITIES, Times
from tisph.snapshot import STRESSES, Snapshot


def carried_in_order(scheme):
    """Return what the particles of liquid carry, where they are, and tensors, in the order of creation."""
    history, liquid = scheme.history, scheme.flow.n_fluid
    created = _order(scheme)
    fields = [history.carried, history.position, *([scheme.polymer.tensors] if scheme.polymer else [])]
    return [active(field)[:liquid][created].astype(float) for field in fields]


def _order(scheme):
    """Return where the particles lie in memory (n,), in the order of creation."""
    return np.argsort(active(scheme.history.number)[: scheme.flow.n_fluid])


def state(scheme, time):
    """Return the ``Snapshot`` at ``time`` on the polynomials through what the particles carry, ``scheme.seen``."""
    flow, bounds, age = scheme.flow, scheme.bounds, scheme.time - time
    _, carried, position, *tensors = scheme.seen
    lengths = scheme.lengths or [1.0]
    times = Times([0.0, *lengths], lengths[0])
    velocities = carried[:, : 2 * VELOCITIES].reshape(len(carried), VELOCITIES, 2)
    pressure, velocity = carried[:, 2 * VELOCITIES], velocities[:, 0]
    if age:
        velocity = np.einsum("a,iac->ic", times.at(age, VELOCITIES), velocities)
        position = position - np.einsum("a,iac->ic", times.since(age), velocities)
        pressure = carried[:, 2 * VELOCITIES :] @ times.at(age, PRESSURES)
    if bounds and bounds.corners:
        if age:
            at = lambda part: times.at(part * age, VELOCITIES)  # noqa: E731
            position = bounds.corners.paths.find(at, -age)[_order(scheme)]
        velocity = velocity + bounds.corners.velocity(position)
        pressure = pressure + bounds.corners.pressure(position)
    stress = [flow.density * part for part in scheme.polymer.at(times, age, *tensors)] if tensors else []
    return Snapshot(
        t=time,
        step=scheme.steps,
        x=position[:, 0] % flow.length + flow.origin[0],
        y=position[:, 1] % flow.height + flow.origin[1],
        u=velocity[:, 0].copy(),
        v=velocity[:, 1].copy(),
        density=np.full(len(position), flow.density),
        pressure=flow.density * (pressure - pressure.mean()),
        bodies=bounds.bodies(time, times, age) if bounds else None,
        steepest=scheme.steepest,
        **dict(zip(STRESSES, stress, strict=False)),
    )
