"""The annulus between two cylinders around one axis: exact solution, and what is measured."""

from dataclasses import dataclass

import numpy as np

from tisph.measures.metrics import field_error, relative_difference
from tisph.scenes import _two_dimensional
from tisph.scenes._annulus import views
from tisph.scenes._annulus.cylinders import Cylinders
from tisph.scenes._annulus.flow import cartesian, polar, reference_flow
from tisph.snapshot import STRESSES


@dataclass(frozen=True, kw_only=True)
class Annulus(Cylinders):
    """Two cylinders around one axis, with the reference of the flow between them at all times."""

    flow_quantities = ("torque_inner", "torque_outer")

    @property
    def fields(self):
        """Velocity and pressure, and the stresses of a polymer."""
        return ("u", "v", "pressure", *(STRESSES if self.polymer else ()))

    @property
    def _flow(self):
        return reference_flow(self)

    def radii(self, x, y):
        """Distance of places from the axis."""
        return np.hypot(np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1]))

    def around(self, snapshot):
        """Velocity around the axis, array (particles,)."""
        x, y = snapshot.x - self.centre[0], snapshot.y - self.centre[1]
        return (x * snapshot.v - y * snapshot.u) / np.hypot(x, y)

    def exact_around(self, x, y, t):
        """Exact velocity around the axis."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        return self._flow.velocity(radius, t)

    def exact_vorticity(self, x, y, t):
        """Exact vorticity dv/dx - du/dy (1/time), the shear rate r d(u/r)/dr and twice u/r."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        return self._flow.shear_rate(radius, t) + 2 * self.exact_around(x, y, t) / radius

    def exact(self, field, x, y, t):
        """Exact value of one of ``fields``; of zero mean for the pressure, at one time."""
        if field == "pressure":
            return self._exact_pressure(x, y, t)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        if field in STRESSES:
            return cartesian(self.exact_polymer_stress(x, y, t), *away)[STRESSES.index(field)]
        part = -away[1] if field == "u" else away[0]
        return part / np.hypot(*away) * self.exact_around(x, y, t)

    def exact_polymer_stress(self, x, y, t):
        """Exact stress of the polymer in polar components, shape (3, ...): around the axis, shear, along the radius."""
        return self.density * self._flow.polymer_stress(self.radii(x, y), t)

    @property
    def initial_conformation_excess(self):
        """``conformation_excess`` when the run starts; None from rest, which has none."""
        return None if self.initial_state == "rest" else self._excess_at

    def _excess_at(self, x, y):
        """C (components, n) of each mode, xx, xy, yy (and zz), at places ``x``, ``y`` (n,) when the run starts."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        modes = self._flow.conformation_excess(radius, self.start_time)
        return [np.concatenate([cartesian(mode[:3], *away), mode[3:]]) for mode in modes]

    def polymer_stress(self, snapshot):
        """Shear stress (particles,) of the polymer, and its N1, the stress around the axis less that along radii."""
        away = snapshot.x - self.centre[0], snapshot.y - self.centre[1]
        return polar([getattr(snapshot, name) for name in STRESSES], *away)

    def _exact_pressure(self, x, y, t):
        def at(time):
            return self._flow.pressure(self.radii(x, y), time, density=self.density)

        times = np.unique(t)
        if len(times) == 1:
            return at(times[0]) + np.zeros(np.shape(t))
        return np.concatenate([np.broadcast_to(at(time), np.shape(x)) for time in times], axis=-1)

    def initial(self, x, y):
        """The exact velocity, and stress of a polymer, when the run starts."""
        names = [name for name in self.fields if name != "pressure"]
        return {name: self.exact(name, x, y, self.start_time) for name in names}

    def exact_torques(self, t):
        """Torques of the fluid on the inner and the outer cylinder, per length of the axis."""
        return self._flow.torque(t, density=self.density)

    @property
    def extra_series(self):
        """First normal stress difference of a polymer at both cylinders, ``n1_inner`` and ``n1_outer``."""
        return views.extra_series(self) if self.polymer else None

    def exact_normal_stress(self, t):
        """Exact N1 (2, times) of the polymer at the inner and the outer cylinder."""
        radii = np.array([[self.inner_radius], [self.outer_radius]])
        around, _, along = self.density * self._flow.polymer_stress(radii, np.asarray(t))
        return around - along

    def diagnostics(self, snapshot, series):
        """Errors of pressure and stresses, torques with their references, and ``_two_dimensional.diagnostics``.

        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), p - p_exact less its mean. ``torque_inner`` and
        ``torque_outer``: of the fluid on the cylinders, per length of the axis, each also ``_exact``. With polymer
        ``shear_stress_l2`` and ``normal_stress_l2``, those of its shear stress and N1 in polar components.
        """
        numbers = {"l2_pressure": field_error(self, snapshot, "pressure"), **self._stress_errors(snapshot)}
        exact = self.exact_torques(snapshot.t)
        for index, name in enumerate(("inner", "outer")):
            numbers[f"torque_{name}"] = snapshot.bodies.torque[index]
            numbers[f"torque_{name}_exact"] = exact[index]
        return {**numbers, **_two_dimensional.diagnostics(self, snapshot)[1]}

    def _stress_errors(self, snapshot):
        if self.polymer is None:
            return {}
        around, exact, along = self.exact_polymer_stress(snapshot.x, snapshot.y, snapshot.t)
        shear, normal = self.polymer_stress(snapshot)
        return {
            "shear_stress_l2": relative_difference(shear, exact),
            "normal_stress_l2": relative_difference(normal, around - along),
        }

    movie_ends = views.movie_ends
    movie_profiles = views.movie_profiles
    parameters = views.parameters
    profiles = views.profiles
    time_series = views.time_series

    def movie_fields(self, name):
        """Also all of the stress where its shear component around the axis is shown."""
        return ("stress_xx", "stress_yy") if name == "shear_stress" else super().movie_fields(name)
