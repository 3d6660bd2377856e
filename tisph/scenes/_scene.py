"""What a run asks of a scene, whatever it is: its box, fluid, start, scales, reference, and what is looked at.

A scene is one file of this folder with two names: ``Config``, the model of its config (``tisph/config/schema.py``),
and ``Scene``, a frozen dataclass derived from the ``Scene`` here. Everything above it, from the observers to the
pictures, asks no more than what is here. A scene must give what has no value here and what raises NotImplementedError;
The defaults of all other names describe a fluid at rest in a periodic box.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.scenes._layers import PolymerParameters
from tisph.scenes._views import COLOURS, MovieView, Profile, TimeSeries, movie_view


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A fluid in the box 0 <= x <= width, 0 <= y <= height; every number in the config's units."""

    density: float
    """Density of the fluid."""

    kinematic_viscosity: float
    """Kinematic viscosity, of solvent and polymer together."""

    spacing: float
    """Distance between neighbouring particles at the start."""

    units: Any
    """``config.schema.Units``: labels of the units for plots and tables."""

    rheology: Any = None
    """Parameters of a fluid that is not Newtonian, else None."""

    given_velocity: float | None = None
    """Reference velocity that the config gives; None where ``velocity_scale`` serves."""

    columns: int = 0
    """Particles along x at the start, in a box without ``bodies``."""

    rows: int = 0
    """Particles along y at the start, in a box without ``bodies``."""

    start_time = 0.0
    """Time at which the run's clock starts."""

    elastic_speed = 0.0
    """Speed of shear waves in the polymer [length/time]."""

    acceleration = 0.0
    """Body acceleration along x."""

    kept_mean_velocity = None
    """Mean velocity along x that a pressure gradient keeps; None where the acceleration is given."""

    body_force = None
    """Function of places x, y and a time, with the ``components`` of the acceleration there; None without one."""

    conformation_source = None
    """Function of places x, y and a time, with the components of a source of the conformation tensor; None without."""

    initial_velocity = None
    """Function of x, y with the velocities (components, ...) of the fluid before bodies start; None at rest."""

    has_own_start = False
    """Whether a user gave the initial velocity, which may have a divergence."""

    swirls = False
    """Whether the fluid may turn around the axis of symmetry."""

    contact = None
    """Distance [length] and pressure [mass/(length time^2)] at which free bodies push each other off."""

    origin = (0.0, 0.0)
    """Lowest corner of the box."""

    bodies = ()
    """``geometry.body.Body`` of each wall that is not a plane wall of a channel."""

    corners = ()
    """``exact.sliding_corner.CornerSingularity`` of each corner at which the velocities of two walls differ."""

    jump_times = ()
    """Times after the start at which the velocity of a body, or its acceleration, jumps."""

    initial_conformation_excess = None
    """Function of places, the C of the modes of a polymer there when the run starts; None where it starts from rest."""

    periodic = (True, True)
    """Whether the box is periodic in x and y."""

    axisymmetric = False
    """Whether y is the distance from an axis of symmetry, and not planar flow; velocities then have a ``w``."""

    parallel = False
    """Whether all flow is along x, so that a scheme may leave out what only crossing flow needs."""

    fields = ()
    """Those fields of a snapshot, by name, that ``exact`` knows; none without a reference solution."""

    flow_quantities = ()
    """Those of the ``diagnostics`` that are numbers of the flow, not errors: extrapolated to spacing 0."""

    extra_series = None
    """``_views.ExtraSeries``: what ``history.csv`` has beside what is followed."""

    frame_velocity = 0.0
    """Velocity along x of the frame that the flow has of its own, to which speeds and errors refer."""

    time_formula = "Ut/L"
    """Time over ``time_scale``, in words."""

    @classmethod
    def from_config(cls, config: Any) -> "Scene":
        """The scene that a validated config describes."""
        raise NotImplementedError

    @staticmethod
    def fluid_of(config: Any) -> dict[str, Any]:
        """The fluid, spacing and units that a validated config describes, as arguments of a scene."""
        return {
            "density": config.fluid.density,
            "kinematic_viscosity": config.kinematic_viscosity,
            "spacing": config.spacing,
            "units": config.units,
            "rheology": None if config.fluid.rheology.type == "newtonian" else config.fluid.rheology,
            "given_velocity": config.reference.velocity if config.reference else None,
        }

    @property
    def polymer(self):
        """Relaxation time and solvent fraction of a fluid with polymer, by which times are told; None without."""
        return PolymerParameters.of(self.rheology)

    @property
    def components(self):
        """Number of the components of a velocity: u and v, and w where there is one."""
        return 3 if self.axisymmetric else 2

    @property
    def extent(self):
        """Width and height of the box."""
        raise NotImplementedError

    @property
    def particles(self):
        """Number of fluid particles."""
        return self.rows * self.columns

    @property
    def has_free_bodies(self):
        """Whether the flow carries any of the ``bodies``."""
        return any(body.free for body in self.bodies)

    @property
    def walls(self):
        """Pairs (side, ``WallMotion``) of the plane walls, from top to bottom, side being ``top`` or ``bottom``."""
        return ()

    @property
    def reference_length(self):
        """Length of the Reynolds number."""
        raise NotImplementedError

    @property
    def velocity_scale(self):
        """Velocity that walls, bodies, the drive or the start set; 0 where they do not move the fluid."""
        raise NotImplementedError

    @property
    def reference_velocity(self):
        """Velocity over which errors are given: that of the config, else ``velocity_scale``."""
        return self.given_velocity or self.velocity_scale

    def velocity_name(self, own):
        """Name of the reference velocity in tables and pictures: ``own`` where it is the ``velocity_scale``."""
        return "reference velocity U" if self.given_velocity else own

    @property
    def peak_velocity(self):
        """Bound of the speed in the flow."""
        return max(self.reference_velocity, self.velocity_scale)

    @property
    def time_scale(self):
        """Time of the dimensionless time t* = t / this."""
        return self.reference_length / self.reference_velocity

    @property
    def viscous_time(self):
        """Time reference length^2 / kinematic viscosity in which momentum diffuses that far."""
        return self.reference_length**2 / self.kinematic_viscosity

    @property
    def reynolds(self):
        """Reynolds number, reference velocity * reference length / kinematic viscosity."""
        return self.reference_velocity * self.reference_length / self.kinematic_viscosity

    @property
    def dynamic_viscosity(self):
        """Density * kinematic viscosity, in total."""
        return self.density * self.kinematic_viscosity

    @property
    def solvent_viscosity(self):
        """Kinematic viscosity of the solvent alone."""
        return self.kinematic_viscosity * (self.polymer.solvent_fraction if self.polymer else 1.0)

    @property
    def weissenberg(self):
        """Weissenberg number, relaxation time * reference velocity / reference length; 0 without polymer."""
        if self.polymer is None:
            return 0.0
        return self.polymer.relaxation_time * self.reference_velocity / self.reference_length

    @property
    def vanishing_scale(self):
        """Whether the velocity crosses zero or decays, so that an error relative to it says little."""
        return False

    def narrowest(self, t):
        """Smallest radius of a wall that bulges into the fluid, and smallest gap between two walls at time ``t``.

        Pairs of a size [length], infinite without one, and what it is, in words.
        """
        return (math.inf, ""), (math.inf, "")

    def seen(self, snapshot):
        """The same scene with free bodies where they are in ``snapshot``, moving on as they do there."""
        return self

    def in_flow_frame(self):
        """The same scene as it is seen from a frame that moves with ``frame_velocity``."""
        return self

    def thinnest_layer(self, t):
        """Depth [length] of the thinnest layer in the flow at time ``t`` and where it is; infinite without one."""
        return math.inf, ""

    def drift(self, snapshot):
        """Velocity by which all together moves too fast, over that of bodies against the fluid; 0 where walls hold."""
        return 0.0

    def lattice(self):
        """Cell centres as arrays (x, y) of shape (particles,), row by row from the bottom."""
        y, x = np.meshgrid(np.arange(self.rows) + 0.5, np.arange(self.columns) + 0.5, indexing="ij")
        return self.spacing * x.ravel(), self.spacing * y.ravel()

    def jittered(self, seed, jitter):
        """Cell centres displaced at random, uniformly within +- ``jitter`` * spacing in x and y.

        ``0 <= jitter < 0.5`` (else ValueError), so that each particle stays in its cell, and in the box. The same
        ``seed`` gives the same positions.
        """
        if not 0 <= jitter < 0.5:
            raise ValueError(f"jitter {jitter} is outside [0, 0.5)")
        x, y = self.lattice()
        shift_x, shift_y = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, x.size))
        return x + jitter * self.spacing * shift_x, y + jitter * self.spacing * shift_y

    def initial(self, x, y):
        """Fields at the places ``x``, ``y`` when the run starts, by name: at least ``u`` and ``v``."""
        raise NotImplementedError

    def exact(self, field, x, y, t):
        """Reference for one of ``fields``, if any, at places ``x``, ``y`` and times ``t``; they broadcast."""
        raise NotImplementedError

    def diagnostics(self, snapshot, series):
        """What ``summary.json`` gets of a sample beside the errors: numbers by name, also true, false and words;
        None for what does not exist.

        ``snapshot`` has its ``reference``, as far as there is one; ``series`` has ``TimeSeries.places``, what
        ``TimeSeries.measure`` returns for it, and, in a run, the pair of times (records,) and of what it was at all of
        them, later ones too, (records, numbers).
        """
        return {}

    def description(self):
        """Sizes of the scene by name, for the files of a run."""
        width, height = self.extent
        return {"width": width, "height": height}

    def parameters(self):
        """Pairs (label, text) of what the flow is, independent of particles, for ``tisph check``."""
        raise NotImplementedError

    def profiles(self) -> list[Profile]:
        """What ``profiles.png`` shows."""
        raise NotImplementedError

    def time_series(self, **settings) -> TimeSeries:
        """What ``history.csv`` and ``history.png`` show; ``settings`` are those of ``Config.time_series``."""
        raise NotImplementedError

    def movie_profiles(self) -> dict[str, Profile]:
        """Profiles of the quantities that a movie may be coloured by, by name; ``speed`` is one of the velocity."""
        profiles = self.profiles()
        return {profile.name: profile for profile in profiles if profile.unit == "velocity"} | {"speed": profiles[0]}

    def movie_series(self) -> TimeSeries:
        """What a movie shows in time."""
        return self.time_series()

    def movie_ends(self, name, profile, end):
        """Smallest and largest value to time ``end`` of ``profile``, the one ``name`` of ``movie_profiles``."""
        return profile.extremes(self.start_time, end)

    def movie_fields(self, name):
        """Fields of a snapshot that a movie coloured by ``name`` needs beside places, velocities and shear stress."""
        return COLOURS[name].fields if name in COLOURS else ()

    def movie_view(self, name, end) -> MovieView:
        """What a movie to time ``end`` shows whose fluid is coloured by ``name``."""
        return movie_view(self, name, end)
