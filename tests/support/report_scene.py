"""A channel, an annulus, and snapshots for the tests of the pictures: exact velocities on a lattice, no simulation."""

from types import SimpleNamespace

import numpy as np

from tisph import scenes
from tisph.config import load
from tisph.config.sections import Video
from tisph.geometry.motion import WallMotion
from tisph.report.movie import Movie, _Ranges
from tisph.report.quantities import quantity
from tisph.scenes.annulus import Annulus
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

END = 20.0


def make_video(width=480, height=240, color_by="speed", overlay="none", **more) -> SimpleNamespace:
    changes = {"fps": 25, "width": width, "height": height, "color_by": color_by, "overlay": overlay, **more}
    return SimpleNamespace(**vars(Video()) | changes)


class Drawn:
    """The frames of a movie, without its file."""

    def __init__(self, scene, video, title="test", end=END):
        self.scene, self.movie = scene, Movie("unused.mp4", scene, video, title, end)

    @property
    def renderer(self):
        return self.movie._renderer

    @property
    def layout(self):
        return self.renderer.layout

    @property
    def quantity(self):
        return self.renderer.quantity

    @property
    def disc_radius(self):
        return self.renderer._fluid.disc_radius

    def render(self, snapshot):
        """Where no reference tells the ranges, those of the first snapshot hold."""
        if not self.renderer:
            ranges = _Ranges(self.movie._view)
            ranges.add(self.movie._measured(snapshot))
            self.movie._renderer = self.movie._new_renderer(ranges)
        return self.movie.frame(snapshot)


def shown(name, scene, end, limits="auto"):
    """What a movie coloured by ``name`` shows."""
    return quantity(scene.movie_view(name, end), scene, limits)


VIDEO = make_video()


def make_channel(rows=10, **changes) -> Channel:
    settings = {
        "gap": 0.01,
        "length": 0.02,
        "density": 1000.0,
        "kinematic_viscosity": 1e-6,
        "bottom": WallMotion(0.0),
        "top": WallMotion(0.005),
        "initial_state": "rest",
        "start_time": 0.0,
        "units": SimpleNamespace(length="m", mass="kg", time="s"),
        **changes,
    }
    spacing = settings["gap"] / rows
    return Channel(**settings, rows=rows, spacing=spacing, columns=round(settings["length"] / spacing))


class PolymerChannel(Channel):
    """A channel whose exact fields can be read off: u = U y/H, S_xy = stress(t) (1 - 2 y/H), S_xx = stress(t)."""

    STRESS = 4e-4

    @classmethod
    def stress(cls, t):
        return cls.STRESS * np.minimum(t, 1.0)

    def exact_velocity(self, y, t):
        return self.top.cosine * np.asarray(y) / self.gap + 0.0 * np.asarray(t)

    def exact_polymer_stress(self, y, t):
        normal = self.stress(t) + 0.0 * np.asarray(y)
        return np.stack([normal, normal * (1.0 - 2.0 * np.asarray(y) / self.gap), np.zeros_like(normal)])


def make_polymer_channel(**changes) -> PolymerChannel:
    from polymer_laws import oldroyd_b  # not on the path of the process that test_report_drawing_process starts

    channel = make_channel(**oldroyd_b(2.0, 0.5), **changes)
    return PolymerChannel(**vars(channel))


def unit_channel(rows=50, **changes) -> Channel:
    """Re = 50 in units of the gap: gap 1, length 2, U = 0.5, nu = 0.01; density 2."""
    unit = {"gap": 1.0, "length": 2.0, "density": 2.0, "kinematic_viscosity": 0.01, "top": WallMotion(0.5)}
    return make_channel(rows, **{**unit, **changes})


def make_annulus(**changes) -> Annulus:
    settings = {
        "inner_radius": 1.0,
        "outer_radius": 2.0,
        "centre": (0.0, 0.0),
        "inner": WallMotion(1.0),
        "outer": WallMotion(0.0),
        "density": 1.0,
        "kinematic_viscosity": 0.02,
        "spacing": 1 / 8,
        "initial_state": "rest",
        "start_time": 0.0,
        "units": SimpleNamespace(length="m", mass="kg", time="s"),
    }
    return Annulus(**{**settings, **changes})


def make_snapshot(channel, t, slip=0.0) -> Snapshot:
    """Particles on the lattice with the exact velocity, plus ``slip`` times the reference velocity."""
    x, y = channel.lattice()
    return particles(channel, t, x, y, channel.exact_velocity(y, t) + slip * channel.reference_velocity)


def particles(channel, t, x, y, u) -> Snapshot:
    x, y, u = (np.asarray(values, dtype=float) for values in (x, y, u))
    zero = np.zeros_like(x)
    stresses = {}
    if channel.polymer:
        stresses = dict(zip(("stress_xx", "stress_xy", "stress_yy"), channel.exact_polymer_stress(y, t), strict=True))
    return Snapshot(t=t, step=0, x=x, y=y, u=u, v=zero, density=zero + channel.density, pressure=zero, **stresses)


def at_start(folder, text):
    """Return a function that gives config, scene and snapshot at t = 0 of the config ``text`` with overrides."""
    from tisph.simulation.state import start_snapshot, start_values  # it imports Taichi, which pictures do without

    def build(*overrides):
        (folder / "case.yaml").write_text(text)
        config = load(folder / "case.yaml", overrides)
        scene = scenes.of(config)
        return config, scene, start_snapshot(scene, start_values(scene, config.initial), "f64")

    return build
