"""The state of the fluid at one time, as NumPy arrays, for observers, plots and metrics."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

STRESSES = ("stress_xx", "stress_xy", "stress_yy")
"""Components of the polymer stress in a snapshot."""

STRESSES_AROUND = ("stress_tt", "stress_xt", "stress_yt")
"""Further components in axisymmetric flow, the last two where walls rotate around the axis."""

OPTIONAL = ("w", *STRESSES, *STRESSES_AROUND, "passages", "area")
"""Fields that only some flows have."""


@dataclass(frozen=True)
class Bodies:
    """Positions and motions of the n bodies of a scene at one time, and the loads of the fluid, per length.

    All numbers of a body that is not in the fluid, as it has left or not entered yet, are NaN.

    ``centre`` and ``velocity`` (n, 2), ``angle`` [radians] and ``angular_velocity`` (n,), counterclockwise. ``force``
    (n, 2) and ``torque`` (n,) around the centre, in total; ``pressure_force`` and ``pressure_torque``, the part of the
    pressure: NaN before the first step, and for a scheme that does not compute them. ``stresslet`` (n,): integral of
    (x t_y + y t_x)/2 around the centre, t being the traction; over the area of a cell it is the contribution of the
    body to the mean shear stress. ``normal_stress`` (n,): first normal stress difference of a polymer, along the wall
    less across it, mean over the wall; None without polymer. ``contact_force`` (n, 2), ``contact_torque`` and
    ``contact_stresslet`` (n,): loads of near contact, which are not part of ``force``: 0 without contact, NaN before
    the first step; None without free bodies. ``load_scatter`` (n, 3): scatter of force along x, along y and torque from
    step to step; ``load_size`` (n, 3): their root mean squares over the same steps. Both are NaN before the fifth step,
    None for a scheme that does not measure them.
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
    load_scatter: np.ndarray | None = None
    load_size: np.ndarray | None = None

    @classmethod
    def at(
        cls,
        time: float,
        bodies: Sequence[Any],
        loads: np.ndarray | None = None,
        normal_stress: np.ndarray | None = None,
        contact: np.ndarray | None = None,
    ) -> "Bodies":
        """Return positions and motions of ``bodies`` (``geometry.body.Body``) at ``time``, with their loads.

        ``loads`` (2, n, 4): force along x and y, torque and stresslet, in total and by the pressure. ``contact``
        (n, 4): the same four loads by near contact. None where they are not known.
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

    def among(self, numbers: Sequence[int], count: int) -> "Bodies":
        """Return these bodies as those with ``numbers`` among ``count``, with NaN for the others."""
        found: dict[str, Any] = {}
        for name, values in vars(self).items():
            if values is not None:
                found[name] = np.full((count, *values.shape[1:]), np.nan)
                found[name][numbers] = values
        return Bodies(**found)


@dataclass(frozen=True)
class Snapshot:
    """Fluid particles at time ``t``, in the order of their creation (row by row from the bottom).

    All arrays have shape (particles_fluid,) and the units of the config: positions ``x`` and ``y`` in the box of the
    scene, velocities ``u`` and ``v`` along them and, in axisymmetric flow, ``w`` around the axis y = 0, else None;
    density, pressure; polymer stresses [mass/(length time^2)] where the fluid has them, else None, with ``stress_tt``
    around the axis in axisymmetric flow, and where walls rotate ``stress_xt`` and ``stress_yt``. ``reference``: arrays
    of the exact solution by the name of the field, where they were requested; ``bodies``, where there are any.

    None where it is not known: ``steepest``: largest change of the logarithm of a conformation tensor within a particle
    spacing, and x and y of its position. ``added_power``: in a fluid of varying viscosity, power of the viscous force
    due to errors of the operators, over the dissipation. ``load_scatter``: largest scatter of the force on a body from
    step to step, over that force, and the body's number. ``velocity_scatter``: scatter of velocities from step to step,
    over the largest velocity, with free bodies or without inertia. ``divergence``: rms of the divergence of the
    velocities over the rms of their gradient, by the operators of the scheme. ``acceleration``: body acceleration along
    x that keeps a mean velocity. ``area`` (particles_fluid,): area that each particle stands for, where that varies.

    With open ends: ``flow_rates`` (2,) into the fluid through inlet and outlet [length^2/time]; ``backflow``: largest
    velocity into the fluid at the outlet, 0 without any; ``passages`` (particles_fluid,): how often the fluid of a
    particle has left, and other fluid has entered in its place.

    ``substances``: arrays (particles_fluid,) of the temperature and of dissolved substances by name, None without any.
    ``flows`` (substances, walls): amount of each that flows from each wall or body into the fluid in a time, per length
    in planar flow; heat of the temperature. In a channel the walls are the bottom and the top. ``received``
    (substances,): amount of each that the fluid has received since the start, through walls, from sources and by
    heating.
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
    velocity_scatter: float | None = None
    divergence: float | None = None
    acceleration: float | None = None
    flow_rates: np.ndarray | None = None
    backflow: float | None = None
    passages: np.ndarray | None = None
    area: np.ndarray | None = None
    substances: dict[str, np.ndarray] | None = None
    flows: np.ndarray | None = None
    received: np.ndarray | None = None

    def field(self, name: str) -> Any:
        """Return the array of a field, or of a substance, by its name; None where there is none."""
        return (self.substances or {}).get(name, getattr(self, name, None))

    @property
    def weight(self) -> Any:
        """Weight of each particle in sums over particles: its area over the mean area (particles,), 1 without areas."""
        return 1.0 if self.area is None else self.area / np.mean(self.area, dtype=float)

    def widths(self, spacing: float) -> np.ndarray:
        """Return the widths (particles,) [length] of the particles: roots of their areas, ``spacing`` without areas."""
        return np.full(len(self.x), spacing) if self.area is None else np.sqrt(self.area)
