"""The flows of the stability matrix: a table of what a config says of each, and by what its runs are judged.

Every flow has a length, a density and a reference velocity of 1, so that the viscosity is 1/Re.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from tisph.studies.flows import digits, merged, oldroyd_b, walls
from tisph.studies.stability import axisymmetric, free_bodies
from tisph.studies.stability.free_bodies import ACROSS as BODY_ACROSS

SOLVENT_FRACTION = 0.1
"""The smallest for which Oldroyd-B flow is verified with the explicit scheme."""

PENETRATION = 1 / 3
"""Depth sqrt(2 nu/w) to which an oscillating wall moves the fluid, in gaps."""

THICKNESS = 1 / 30
"""Of the shear layers, in sides of their square: the thick ones of the literature (``scenes/shear_layer.py``)."""

PREDICTABLE = 5.0
"""Time, in lengths over speed, up to which vortices can be compared at Reynolds numbers above 1000: disturbances of
their size grow by a factor e in 2, there is nothing to damp them, and the exact flow is one that no run can stay on."""

SLOW_TO_FAST = (0.1, 1.0, 10.0)
"""Weissenberg numbers by gap and wall between cylinders."""

MOBILITY = 0.2
"""Of Giesekus fluids."""

FAR = (0.01, 10.0, 100.0)
"""Weissenberg numbers that the implicit scheme alone is tried at."""

RADIUS, ACROSS, ALONG = 3, 16, 24
"""Radius of a cylinder near the lower wall of a channel, height and length of the channel, in spacings."""

SETTINGS = {"": (18.0, 12.0), "_driven": (18.0, 12.0), "_lattice": (12.0, 12.0)}
"""What bodies are in, as the ends of names: a channel that they move along, one whose fluid is driven past them, and a
lattice; with the middle of each in spacings."""

TOO_SMALL = ("circle2", "square0")
"""Shapes that are refused."""

FINER = "finer"
"""Measure of a flow without a reference: the drag, over that of a run with twice the particles across; of a free body
its velocities, of Taylor's vortices the torque and the radial velocity."""

BOTH_STRESSES = "both_stresses"
"""Measure of a suspension: the shear stress by the bodies off that on the walls."""

EXACT = "exact"
"""Measure of flow in a pipe: the largest error of the velocity (L2) and of the loads on the walls."""


@dataclass(frozen=True)
class Flow:
    """``change(nu)``: what a viscosity makes of the config.

    ``measure``: the error that is judged, rms where the velocity crosses zero or decays; None without a reference.
    ``peak``: bound of the speed in reference velocities, see ``Scene.peak_velocity``. A ``doubly_periodic``
    flow is in a square; the ``change`` of one with ``curved_walls`` is the whole config; all others are in a channel.
    ``largest``: error of a stable run between such walls, 12 particles across; ``refused``: whether none is allowed.
    ``viscoelastic``: whether the fluid is, where the flow is not in a channel.
    """

    change: Callable
    measure: str | None = "l2"
    peak: float = 1.0
    doubly_periodic: bool = False
    curved_walls: bool = False
    largest: float = 0.0
    refused: bool = False
    viscoelastic: bool = False

    def unit_time(self, reynolds):
        """Return the time t* = 1 in lengths over reference velocity: in a channel the viscous time."""
        return 1.0 if self.doubly_periodic or self.curved_walls else reynolds


def _couette(nu):
    return merged(_viscosity(nu), walls(0.0, 1.0))


def _poiseuille(nu):
    """Mean speed g H^2 / (12 nu) = 1."""
    return merged(_viscosity(nu), {"drive": {"acceleration": digits(12.0 * nu)}})


def _backflow(nu):
    """g H^2 / (2 nu U) = -4: the fluid flows back over three quarters of the gap."""
    return merged(_viscosity(nu), walls(0.0, 1.0), {"drive": {"acceleration": digits(-8.0 * nu)}})


def _oscillating(nu):
    frequency = digits(2.0 * nu / PENETRATION**2)
    return merged(_viscosity(nu), {"walls": {"top": {"amplitude": 1.0, "angular_frequency": frequency}}})


def _polymer(weissenberg):
    """Couette flow of an Oldroyd-B fluid; its relaxation time is the Weissenberg number."""
    return lambda nu: merged(oldroyd_b(weissenberg, SOLVENT_FRACTION), _couette(nu))


def _polymers(*weissenbergs):
    return {f"oldroyd{weissenberg:g}": Flow(_polymer(weissenberg)) for weissenberg in weissenbergs}


def _with_polymer(flow, weissenberg, law="oldroyd_b"):
    """A ``flow`` from rest, or from its vortices, of a viscoelastic fluid."""
    rheology = {"type": law, "relaxation_time": weissenberg, "solvent_fraction": SOLVENT_FRACTION}
    if law == "giesekus":
        rheology["mobility"] = MOBILITY
    return lambda nu: merged(flow(nu), {"fluid": {"rheology": rheology}})


def _started(flow):
    """Return a ``flow`` from rest."""
    return lambda nu: merged(flow(nu), {"initial": {"state": "rest"}})


def _cylinders_with_polymer():
    return {
        f"annulus_{law}{weissenberg:g}": Flow(
            _with_polymer(_started(_annulus(0.5)), weissenberg, law), curved_walls=True, largest=1e-3, viscoelastic=True
        )
        for law in ("oldroyd_b", "giesekus")
        for weissenberg in SLOW_TO_FAST
    }


def _vortices(nu):
    return merged(_viscosity(nu), {"scene": "taylor_green", "initial": {"velocity": 1.0}})


def _layers(nu):
    start = {"velocity": 1.0, "thickness": digits(THICKNESS)}
    return merged(_viscosity(nu), {"scene": "shear_layer", "initial": start})


def _annulus(ratio):
    """Steady flow between cylinders of a ratio of radii, of which the inner one rotates; the gap is 1."""
    inner, outer = (digits(radius / (1.0 - ratio)) for radius in (ratio, 1.0))
    walls_given = {"inner": {"angular_velocity": digits(1.0 / inner)}}
    scene = {"scene": "annulus", "initial": {"state": "developed"}}
    cylinders = {"geometry": {"inner_radius": inner, "outer_radius": outer}, "walls": walls_given}
    return lambda nu: merged(_viscosity(nu), scene, cylinders)


def _cavity(profile):
    scene = {"scene": "cavity", "geometry": {"width": 1.0, "height": 1.0}}
    return lambda nu: merged(_viscosity(nu), scene, {"walls": {"lid": {"velocity": 1.0, "profile": profile}}})


def _cylinder(gap):
    """A cylinder at rest, ``gap`` spacings above a wall at rest, under one that moves."""
    spacing = 1.0 / ACROSS
    body = {"centre": [0.5 * ALONG * spacing, (RADIUS + gap) * spacing], "radius": RADIUS * spacing}
    channel = {"scene": "channel", "geometry": {"gap": 1.0, "length": ALONG * spacing}, "bodies": [body]}
    return lambda nu: merged(_viscosity(nu), channel, {"walls": {"top": {"velocity": 1.0}}})


def _spacings(*numbers):
    return [digits(number / BODY_ACROSS) for number in numbers]


def _circle(radius):
    return {"type": "circle", "radius": digits(radius / BODY_ACROSS)}


def _polygon(radius, *corners):
    corners = [_spacings(*corner) for corner in corners]
    return {"type": "polygon", "angle": 0.3, "corners": corners, "corner_radius": digits(radius / BODY_ACROSS)}


def _ellipse(radius):
    """Half-axes of 6 and sqrt(6 radius) spacings: the smallest radius of curvature is the ``radius``."""
    angles = [2.0 * math.pi * k / 72 for k in range(72)]
    points = [_spacings(6.0 * math.cos(each), math.sqrt(6.0 * radius) * math.sin(each)) for each in angles]
    return {"type": "curve", "points": points}


def _past(setting, *placed):
    """Flow from rest past pairs of a shape and its place in spacings: they move, or an acceleration moves the fluid.

    By inertia or by friction its speed becomes about 1.
    """
    bodies = [
        {**shape, "centre": _spacings(*place), "motion": "fixed" if setting else {"velocity": [1.0, 0.0]}}
        for shape, place in placed
    ]
    scene = {"scene": "channel", "geometry": {"gap": 1.0, "length": 1.5}}
    if setting == "_lattice":
        scene = {"scene": "lattice", "geometry": {"length": 1.0, "height": 1.0}}
    drive = lambda nu: {"drive": {"acceleration": digits(1.0 + 12.0 * nu)}} if setting else {}  # noqa: E731
    return lambda nu: merged(_viscosity(nu), scene, {"bodies": bodies}, drive(nu))


def _shapes():
    """Circles by radius, polygons by that of their corners, ellipses by their smallest one, in spacings."""
    yield from ((f"circle{radius:g}", _circle(radius)) for radius in (2.0, 2.5, 3.0, 4.0, 6.0, 8.0))
    square, triangle = ((-5, -5), (5, -5), (5, 5), (-5, 5)), ((-7, -5), (7, -5), (0, 7))
    yield from ((f"square{radius:g}", _polygon(radius, *square)) for radius in (0.0, 2.0, 2.5, 3.0, 4.0))
    yield from ((f"triangle{radius:g}", _polygon(radius, *triangle)) for radius in (2.5, 3.0, 3.5))
    yield from ((f"ellipse{radius:g}", _ellipse(radius)) for radius in (2.5, 3.0, 4.0))


def _bodies():
    """Shapes in the middle of each setting; circles by their gap to a wall or a copy; pairs by their distance."""
    four = _circle(4.0)
    for setting, (x, y) in SETTINGS.items():
        for name, shape in _shapes():
            yield f"{name}{setting}", _past(setting, (shape, (x, y))), name in TOO_SMALL
        for gap in (2.0, 3.0, 4.0, 5.0):
            one, apart = (four, (x, 4.0 + gap)), 4.0 + 0.5 * gap
            pair = (four, (x - apart, y)), (four, (x + apart, y))
            if setting == "_lattice":
                one, pair = (_circle(12.0 - 0.5 * gap), (x, y)), ((four, (x, y - apart)), (four, (x, y + apart)))
            yield f"gap{gap:g}{setting}", _past(setting, one), False
            yield f"pair{gap:g}{setting}", _past(setting, *pair), False


def _viscosity(nu):
    return {"fluid": {"kinematic_viscosity": digits(nu)}}


FLOWS = {
    "couette": Flow(_couette),
    "poiseuille": Flow(_poiseuille, peak=1.5),
    "backflow": Flow(_backflow, "rms", peak=2.0),
    "oscillating": Flow(_oscillating, "rms"),
    **_polymers(*sorted((0.1, 1.0, 5.0, *FAR))),
    "taylor_green": Flow(_vortices, "rms", doubly_periodic=True),
    "shear_layer": Flow(_layers, None, peak=1.25, doubly_periodic=True),
    "annulus0.2": Flow(_annulus(0.2), curved_walls=True, largest=1e-3),
    "annulus0.5": Flow(_annulus(0.5), curved_walls=True, largest=1e-3),
    "annulus0.9": Flow(_annulus(0.9), curved_walls=True, largest=1e-3),
    "regular_lid": Flow(_cavity("regular"), curved_walls=True, largest=0.03),
    "sharp_lid": Flow(_cavity("sharp"), "centre_line_error", curved_walls=True, largest=0.02),
    **_cylinders_with_polymer(),
    "lid_oldroyd_b0.1": Flow(_with_polymer(_cavity("regular"), 0.1), None, curved_walls=True, viscoelastic=True),
    "layer_oldroyd_b1": Flow(_with_polymer(_layers, 1.0), None, peak=1.25, doubly_periodic=True, viscoelastic=True),
    "cylinder1.5": Flow(_cylinder(1.5), "unbalanced", curved_walls=True, refused=True),
    "cylinder2": Flow(_cylinder(2.0), "unbalanced", curved_walls=True, largest=0.02),
    "cylinder5": Flow(_cylinder(5.0), "unbalanced", curved_walls=True, largest=0.02),
    **{
        name: Flow(change, FINER, curved_walls=True, largest=0.16, refused=refused)
        for name, change, refused in _bodies()
    },
    **{
        name: Flow(change, BOTH_STRESSES if name.startswith("suspension") else FINER, curved_walls=True, largest=0.16)
        for name, change in free_bodies.flows()
    },
    **{name: Flow(change, EXACT, curved_walls=True, largest=0.01) for name, change in axisymmetric.beside_exact()},
    **{name: Flow(change, FINER, curved_walls=True, largest=0.16) for name, change in axisymmetric.beside_finer()},
}
"""The number behind oldroyd, oldroyd_b and giesekus is Wi, that behind annulus the ratio of the radii, that behind
cylinder the gap in spacings if there are ``ACROSS``; those of bodies are as ``_shapes``, ``_bodies`` and
``free_bodies.flows`` say; of axisymmetric flow radius ratios, and spacings to a sphere's radius or gap."""
