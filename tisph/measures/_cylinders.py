"""A rheometer of two cylinders, seen as the plane one that ``rheometry.py`` reads.

The stress at the moving cylinder, of radius a, is its torque per length over 2 pi a^2. The nominal shear rate there, of
the usual evaluation, is that of steady flow of a fluid of constant viscosity, 2 W b^2/(a^2 - b^2) with the radius b of
the other cylinder and the angular velocity W. Without inertia it holds for all linear fluids.
"""

from types import SimpleNamespace

import numpy as np

from tisph.errors import ConfigError
from tisph.exact.linear_viscoelasticity import cylinder_apparent_viscosity


def as_plane(annulus, table):
    """Return what stands for the channel, its moving wall, and the columns of the history as of an upper wall.

    ConfigError where not one cylinder alone moves. ``gap`` is 1: the wall has the nominal shear rate for its speed.
    """
    moving = [name for name in ("inner", "outer") if getattr(annulus, name).largest_speed]
    if len(moving) != 1:
        raise ConfigError("a rheometer has one moving cylinder and one at rest")
    if "torque_inner_exact" not in table:
        raise ConfigError("its history has no torques beside the exact ones: it has not ended")
    radii = annulus.inner_radius, annulus.outer_radius
    own, other = radii if moving == ["inner"] else radii[::-1]
    wall = getattr(annulus, moving[0]).scaled(2 * other**2 / abs(own**2 - other**2))
    # what the fluid does to the cylinder that moves is against its motion
    columns = {name: -table[f"torque_{moving[0]}{name}"] / (2 * np.pi * own**2) for name in ("", "_exact")}
    plane = SimpleNamespace(
        gap=1.0,
        density=annulus.density,
        dynamic_viscosity=annulus.dynamic_viscosity,
        solvent_viscosity=annulus.solvent_viscosity,
        viscous_stress=lambda rate: annulus.dynamic_viscosity * rate,
        top=wall,
        apparent_viscosity=lambda viscosity, frequency: cylinder_apparent_viscosity(
            viscosity, frequency, annulus.density, own, other
        ),
    )
    shears = {f"wall_shear{name}": values for name, values in columns.items()}
    normals = {f"n1{end}": table[f"n1_{moving[0]}{end}"] for end in ("", "_exact") if f"n1_{moving[0]}{end}" in table}
    return plane, wall, {"t": table["t"], "strain": wall.displacement(table["t"]), **shears, **normals}
