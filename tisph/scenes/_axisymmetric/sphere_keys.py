"""Keys of the config of a sphere in a tube: its geometry, the body, the tube and what drives the fluid."""

from pydantic import model_validator

from tisph.config.base import Model, NonNegative, Positive, Signed, refusals
from tisph.scenes._axisymmetric.pipe_keys import Cylinder

FREE_KEYS = ("density", "force")


class Geometry(Model):
    """Radii of tube and sphere, and period along the axis [length].

    ``half_length``: of a spheroid, half of its axis along the tube; that of a sphere where left out.
    """

    unset_keys = ("half_length",)

    tube_radius: Positive
    sphere_radius: Positive
    length: Positive
    half_length: Positive | None = None


class Sphere(Model):
    """What the body does from t = 0 on: constant ``velocity`` along the axis, or ``free``; and what turns it.

    ``angular_velocity`` around the axis [1/time]. A free body has a ``density`` [mass/length^3], that of the fluid
    where left out, and a ``force`` along the axis from outside [mass length/time^2], as its weight less its buoyancy.
    """

    unset_keys = ("velocity", *FREE_KEYS)

    velocity: Signed | None = None
    free: bool = False
    density: NonNegative | None = None
    force: Signed | None = None
    angular_velocity: Signed = 0.0

    @model_validator(mode="after")
    def _check_free(self) -> "Sphere":
        wrong = ("velocity",) if self.free else FREE_KEYS
        text = f"is only for a sphere that is {'not ' if self.free else ''}free"
        found = [((key,), text, getattr(self, key)) for key in wrong if getattr(self, key) is not None]
        if found:
            raise refusals(found)
        return self


class Walls(Model):
    """The tube."""

    tube: Cylinder = Cylinder()


class Drive(Model):
    """Acceleration along the axis [length/time^2], or the mean velocity that closure ``no_flux`` keeps."""

    acceleration: Signed = 0.0
    mean_velocity: Signed = 0.0
