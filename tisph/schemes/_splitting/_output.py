"""The state at any time within the last step, from the time levels of the particles; numbers of the run."""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.schemes._splitting._bdf import PRESSURES, VELOCITIES, TimeWeights
from tisph.snapshot import STRESSES, STRESSES_AROUND, Snapshot


def levels_in_order(scheme):
    """Return fields, positions and tensors of the fluid particles, in the order of creation."""
    levels, fluid = scheme.levels, scheme.problem.n_fluid
    created = _order(scheme)
    fields = [levels.fields, levels.position, *([scheme.polymer.tensors] if scheme.polymer else [])]
    return [active(field)[:fluid][created].astype(float) for field in fields]


def _order(scheme):
    """Return where the particles lie in memory (n,), in the order of creation."""
    return np.argsort(active(scheme.levels.number)[: scheme.problem.n_fluid])


def state(scheme, time):
    """Return the ``Snapshot`` at ``time`` on the polynomials through the levels in ``scheme.output_cache``."""
    problem, walls, offset = scheme.problem, scheme.wall_boundary, scheme.time - time
    _, fields, position, *tensors = scheme.output_cache
    dts = scheme.dts or [1.0]
    times = TimeWeights([0.0, *dts], dts[0])
    first, components = scheme.levels.first_pressure, scheme.levels.components
    velocities = fields[:, :first].reshape(len(fields), VELOCITIES, components)
    axis = position[:, 1] + problem.origin[1]
    velocities = np.stack([problem.velocities(velocities[:, level], axis) for level in range(VELOCITIES)], axis=1)
    pressure, velocity = fields[:, first], velocities[:, 0]
    if offset:
        velocity = np.einsum("a,iac->ic", times.interpolation(offset, VELOCITIES), velocities)
        position = position - np.einsum("a,iac->ic", times.integral(offset), velocities[..., :2])
        pressure = fields[:, first:] @ times.interpolation(offset, PRESSURES)
        if problem.axisymmetric:  # what is interpolated around the axis is the circulation
            velocity[:, 2] *= axis / (position[:, 1] + problem.origin[1])
    if walls and walls.corners:
        if offset:
            at = lambda part: times.interpolation(part * offset, VELOCITIES)  # noqa: E731
            position = walls.corners.paths.find(at, -offset)[_order(scheme)]
        velocity = velocity + walls.corners.velocity(position)
        pressure = pressure + walls.corners.pressure(position)
    stress = [problem.density * part for part in scheme.polymer.at(times, offset, *tensors, axis)] if tensors else []
    return Snapshot(
        t=time,
        step=scheme.steps,
        **dict(zip("xy", problem.places(position), strict=True)),
        u=velocity[:, 0].copy(),
        v=velocity[:, 1].copy(),
        w=velocity[:, 2].copy() if problem.axisymmetric else None,
        density=np.full(len(position), problem.density),
        pressure=problem.density * (pressure - pressure.mean()),
        bodies=walls.bodies(time, times, offset) if walls else None,
        steepest=scheme.stress_resolution if scheme.polymer else None,
        added_power=None if scheme.polymer else scheme.stress_resolution,
        load_scatter=walls.load_scatter if walls else None,
        divergence=scheme.residual,
        acceleration=scheme.mean_velocity.acceleration if scheme.mean_velocity else None,
        **dict(zip((*STRESSES, *STRESSES_AROUND), stress, strict=False)),
    )


def numbers_of(scheme):
    """Return what ``summary.json`` says about a scheme."""
    return {
        "mach": 0.0,
        "sound_speed": None,
        "particles_wall": 0,
        "neighbours_mean": scheme.points.mean_length(),
        "steps_rejected": scheme.rejected,
        "order_reduced": scheme.order_reduced,
        "neighbourhoods_dropped": scheme.singular,
        "divergence": scheme.residual,
        "iterations_pressure": scheme.iterations[0] / max(scheme.steps, 1),
        "iterations_velocity": scheme.iterations[1] / max(scheme.steps, 1),
        **(scheme.wall_boundary.contacts() if scheme.wall_boundary else {}),
    }
