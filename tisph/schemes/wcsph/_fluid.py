"""The weakly compressible fluid as kernels see it: numbers in fields, which are not compiled in."""

from typing import Any

from tisph.runtime import scalar, ti
from tisph.scenes._scene import Scene
from tisph.schemes.wcsph.equation_of_state import Tait, series


@ti.data_oriented
class Fluid:
    """Weakly compressible fluid; all pressures and stresses are over the reference density (length^2/time^2).

    Tait equation of state p / rho0 = c^2/gamma ((1 + s)^gamma - 1), s = rho/rho0 - 1, as a polynomial in s.
    ``pressure_cutoff`` (over density) or None limits tension. ``kinematic_viscosity``: solvent viscosity. ``stress``:
    law of the stress that particles carry (``Stress`` of a rheology), None for a Newtonian fluid.
    """

    def __init__(self, scene: Scene, equation_of_state: Tait, sound_speed: float, stress: Any):
        self.stress = stress
        self.carries_stress = stress is not None
        self.gamma = equation_of_state.gamma
        self.coefficients = series(self.gamma)
        self.limits_tension = equation_of_state.pressure_cutoff is not None
        self.kinematic_viscosity = scalar(scene.solvent_viscosity)
        self.sound_speed = scalar(sound_speed)
        if equation_of_state.pressure_cutoff is not None:
            self.pressure_cutoff = scalar(equation_of_state.pressure_cutoff / scene.density)

    @ti.func
    def pressure(self, compression):
        """Return the pressure over the reference density."""
        series = 0.0
        for coefficient in ti.static(self.coefficients):
            series = series * compression + coefficient
        pressure = self.sound_speed[None] ** 2 * series * compression
        if ti.static(self.limits_tension):
            pressure = ti.max(pressure, self.pressure_cutoff[None])
        return pressure

    @ti.func
    def stiffness(self, compression):
        """Return the slope of pressure over compression, c^2 (1 + s)^(gamma - 1)."""
        return self.sound_speed[None] ** 2 * (1.0 + compression) ** (self.gamma - 1)
