"""The state of the fluid at one time, as NumPy arrays: what observers, plots and metrics read."""

from dataclasses import dataclass

import numpy as np

STRESSES = ("stress_xx", "stress_xy", "stress_yy")
"""What a snapshot has of a polymer's stress."""

STRESSES_AROUND = ("stress_tt", "stress_xt", "stress_yt")
"""The components around the axis of axisymmetric flow, the last two where walls turn around it."""

OPTIONAL = ("w", *STRESSES, *STRESSES_AROUND)
"""Fields that only some flows have."""


@dataclass(frozen=True)
class Bodies:
    """What the n bodies of a scene do at one time, and what the fluid does to them; per length across the plane.

    ``centre`` and ``velocity`` (n, 2), ``angle`` [radians] and ``angular_velocity`` (n,), counterclockwise; ``force``
    (n, 2) and ``torque`` (n,) around the centre, of which ``pressure_force`` and ``pressure_torque`` are the
    pressure's: NaN before the first step, and of a scheme that does not know them. ``stresslet`` (n,): integral of
    (x t_y + y t_x)/2 around the centre, of the traction t: over the area of a cell it is what a body in it adds to the
    mean shear stress. ``normal_stress`` (n,): first normal
    stress difference of a polymer, along the wall less across it, mean over the wall; None without one.
    ``contact_force`` (n, 2), ``contact_torque`` and ``contact_stresslet`` (n,): what near contact does to each, which
    is no part of ``force``, 0 without contact and NaN before the first step; None where the flow carries no body.
    """

    centre: np.ndarray
    angle: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    pressure_force: np.ndarray
    pressure_torque: np.ndarray
    normal_stress: np.ndarray | None = None
    stresslet: np.ndarray | None = None
    contact_force: np.ndarray | None = None
    contact_torque: np.ndarray | None = None
    contact_stresslet: np.ndarray | None = None

    @classmethod
    def at(cls, time, bodies, loads=None, normal_stress=None, contact=None):
        """Of ``bodies``, ``geometry.body.Body`` each, which move as they say; ``loads`` (2, n, 4) are on them.

        Those are force along x, along y, torque and stresslet, of all and of the pressure; ``contact`` (n, 4) has the
        same of near contact. None where they are not known.
        """
        if contact is None and any(body.free for body in bodies):
            contact = np.full((len(bodies), 4), np.nan)
        force, torque, stresslet = (None,) * 3 if contact is None else (contact[:, :2], contact[:, 2], contact[:, 3])
        loads = np.full((2, len(bodies), 4), np.nan) if loads is None else loads
        places = [body.at(time) for body in bodies]
        motions = [body.motion for body in bodies]
        return cls(
            centre=np.array([place.centre for place in places]),
            angle=np.array([place.angle for place in places]),
            velocity=np.array([motion.velocity(time) for motion in motions]),
            angular_velocity=np.array(
                [float(body.motion.rotation.velocity(time) + body.spin.velocity(time)) for body in bodies]
            ),
            force=loads[0, :, :2],
            torque=loads[0, :, 2],
            pressure_force=loads[1, :, :2],
            pressure_torque=loads[1, :, 2],
            stresslet=loads[0, :, 3],
            normal_stress=normal_stress,
            contact_force=force,
            contact_torque=torque,
            contact_stresslet=stresslet,
        )


@dataclass(frozen=True)
class Snapshot:
    """Fluid particles at time ``t``, in the order of their creation (row by row from the bottom).

    All arrays have shape (particles_fluid,) and the units of the config: positions ``x`` and ``y`` in the box of the
    scene, velocities ``u`` and ``v`` along them and, in axisymmetric flow, ``w`` around the axis y = 0, else None;
    density, pressure; polymer stresses [mass/(length time^2)] where the fluid has them, else None, with ``stress_tt``
    around the axis in axisymmetric flow, and where walls turn ``stress_xt`` and ``stress_yt``. ``reference``: arrays of
    the exact solution by the name of the field, where somebody has asked for them; ``bodies``, where there are any.
    ``steepest``: the largest change of the logarithm of a conformation tensor within a particle spacing, with x and y
    of where it is; ``added_power``: in a fluid of varying viscosity, the power of the viscous force that only errors
    of the operators add, over the dissipation; ``load_scatter``: the largest scatter of the force on a body from step
    to step, over that force, and the body's number; ``divergence``: of the velocities, root mean square over that of
    their gradient, by the operators of the scheme; ``acceleration``: the one along x that keeps a mean velocity. None
    where they are not known.
    """

    t: float
    step: int
    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray
    density: np.ndarray
    pressure: np.ndarray
    stress_xx: np.ndarray | None = None
    stress_xy: np.ndarray | None = None
    stress_yy: np.ndarray | None = None
    w: np.ndarray | None = None
    stress_tt: np.ndarray | None = None
    stress_xt: np.ndarray | None = None
    stress_yt: np.ndarray | None = None
    reference: dict[str, np.ndarray] | None = None
    bodies: Bodies | None = None
    steepest: tuple[float, float, float] | None = None
    added_power: float | None = None
    load_scatter: tuple[float, int] | None = None
    divergence: float | None = None
    acceleration: float | None = None
