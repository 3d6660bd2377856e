"""Quantities, colours, limits and stresses that movies show."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from report_scene import END, Drawn, make_annulus, make_channel, make_polymer_channel, make_snapshot, make_video, shown

from tisph import scenes
from tisph.config import loader
from tisph.config.schema import colours
from tisph.geometry.motion import WallMotion
from tisph.report import style
from tisph.report.quantities import Spread, limits_of
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Snapshot

DEVELOPED = {"initial_state": "developed"}
PARABOLA = 2e-3 * 0.01**2 / 8e-6  # largest speed g H^2/(8 nu) of the developed driven flow


def test_ranges_fit_the_run_and_not_the_flow_that_it_would_become():
    channel = make_channel(top=WallMotion(0.0), acceleration=2e-3)
    long, short = (shown("speed", channel, end).colour_range[1] for end in (300.0, 5.0))
    assert long == pytest.approx(PARABOLA, rel=1e-12)  # three digits, rounded up: 0.025
    # At mid-gap t* = 0.05 the walls are not felt: u is close to g t, and rounding up adds 1 % at most.
    assert short == pytest.approx(2e-3 * 5.0, rel=0.1)


def test_limits_of_stored_frames_whose_areas_vary_have_all_particles():
    """Frames are in single precision, in which the sum of these weights is off by 2.8."""
    area = np.repeat(np.float32([1e-4, 1e-4 / 16]), [19_000, 1_000])
    frame = Snapshot(0.0, 0, *np.tile(np.linspace(0.0, 1.0, len(area)), (6, 1)), area=area)
    spread = Spread()
    spread.add(frame.x, frame.weight)
    assert spread.ends == pytest.approx((0.0, 1.0), abs=0.02)  # limits leave out a hundredth


def test_profile_axis_shows_a_flow_back():
    channel = make_channel(acceleration=-4e-3)
    speed = shown("speed", channel, end=300.0)
    # Developed: u = U eta - 4 P eta (1 - eta) with P = g H^2/(8 nu) = 0.05, smallest at eta = (1 - U/4P)/2.
    eta = 0.5 * (1.0 - 0.005 / 0.2)
    lowest = 0.005 * eta - 0.2 * eta * (1.0 - eta)
    width = 0.005 - lowest
    # Looked at in steps of a hundredth of the gap: 4 P (1/200)^2 = 5e-6 above the minimum at most, plus its margin.
    assert speed.profile_range == pytest.approx((lowest - 0.08 * width, 0.005 + 0.08 * width), abs=6e-6)
    assert speed.colour_range[1] == pytest.approx(-lowest, rel=0.01)  # rounded up to three digits


def test_run_that_ends_before_anything_moves_has_axes_all_the_same():
    channel = make_channel(top=WallMotion(0.0), acceleration=2e-3)
    speed = shown("speed", channel, end=0.0)
    assert speed.colour_range == (0.0, 1.0)
    assert speed.profile_range[0] < speed.profile_range[1]


def test_shear_stress_is_centred_at_zero_and_reaches_what_the_run_reaches():
    channel = make_polymer_channel()
    for end, largest in ((0.5, 2e-4), (5.0, 4e-4)):
        stress = shown("shear_stress", channel, end)
        # linear in y, but growing in time up to t = 1: a tenth of the colours may be cut off
        low, high = stress.colour_range
        assert low == -high
        assert 0.9 * largest < high <= largest
        assert stress.profile_range == pytest.approx((-1.16 * high, 1.16 * high), rel=0.01)
    assert stress.unit == "Pa"


def test_limits_of_colours_come_from_the_whole_field_and_run():
    line = np.linspace(-1.0, 1.0, 1001)
    assert limits_of(line) == (-1.0, 1.0)  # linear values are shown as far as they go
    outlier = [1e3, np.nan, np.inf]  # one number of 2000
    assert limits_of(np.concatenate([line, line, outlier])) == (-1.0, pytest.approx(1.0, abs=0.2))
    # fluid at rest does not lower them: a vortex has the same in a box four times as large
    vortex = 1.0 / (np.hypot(*np.mgrid[-2:2:81j, -2:2:81j]).ravel() + 0.1)
    alone, padded = limits_of(vortex)[1], limits_of(np.concatenate([vortex, np.zeros(3 * vortex.size)]))[1]
    # the 99.9 % quantile, beyond which sizes are cut off, is all that sees the fluid at rest
    assert 0.75 * alone < padded < vortex.max()
    assert np.quantile(np.concatenate([vortex, np.zeros(3 * vortex.size)]), 0.98) < 0.6 * padded
    assert limits_of(-vortex) == (-alone, 0.0)
    assert limits_of(np.concatenate([vortex, [-1e-6]]))[0] == 0.0  # 1e-6 of the other sign is none
    assert limits_of(np.zeros(3)) == limits_of(np.empty(0)) == (0.0, 0.0)


@pytest.mark.parametrize("rheology", ["newtonian", "power_law", "oldroyd_b"])
def test_rate_viscosity_and_stress_of_simple_shear(rheology):
    """Of u = 0.5 y: rate 0.5, viscosity mu or K rate^(n-1), or of the solvent and S/rate; fits are exact for them."""
    from polymer_laws import oldroyd_b

    from tisph import registry

    fluid = oldroyd_b(2.0, 0.5) if rheology == "oldroyd_b" else {}
    if rheology == "power_law":
        parameters = registry.load("rheology", "power_law").Parameters
        fluid = {"rheology": parameters(index=0.5, reference_rate=1.0, least_rate=1e-6)}
    channel = make_channel(rows=20, **fluid)
    x, y = channel.lattice()
    none, stress = np.zeros_like(x), np.full(x.shape, 3e-4)
    polymer = {"stress_xx": none, "stress_xy": stress, "stress_yy": none} if channel.polymer else {}
    snapshot = Snapshot(1.0, 0, x, y, 0.5 * y, none, none, none, **polymer)
    law = channel.viscous_stress(0.5) / 0.5  # solvent, or inelastic fluid
    expected = {"shear_rate": 0.5, "viscosity": law, "shear_stress": law * 0.5}
    if channel.polymer:
        expected |= {"viscosity": law + 3e-4 / 0.5, "shear_stress": 3e-4}
    for name, value in expected.items():
        found = channel.movie_view(name, 1.0).of(snapshot)
        assert np.allclose(found, value, rtol=1e-9)


def test_a_field_fills_the_fluid_with_the_colours_of_its_values():
    annulus = make_annulus(initial_state="developed")
    radius = np.linspace(1.0, 2.0, 17)[:-1] + 1.0 / 32
    angle = np.linspace(0.0, 2.0 * np.pi, 160, endpoint=False)
    x, y = (np.outer(radius, wave).ravel() for wave in (np.cos(angle), np.sin(angle)))
    snapshot = replace(make_snapshot(make_channel(), 1.0), x=x, y=y, v=x, u=-y, pressure=0 * x, density=0 * x)
    from tisph.snapshot import Bodies

    snapshot = replace(snapshot, bodies=Bodies.at(1.0, annulus.bodies, np.zeros((2, 2, 4))))
    drawn = Drawn(annulus, make_video(640, 320, limits=(0.0, 2.0)), "", END)
    box = drawn.render(snapshot)[drawn.layout.box.slices]
    rows, columns = np.mgrid[: box.shape[0], : box.shape[1]] + 0.5
    distance = np.hypot(
        drawn.layout.low[0] + columns / drawn.layout.pixels_per_length,
        drawn.layout.high[1] - rows / drawn.layout.pixels_per_length,
    )
    fluid = (distance > 1.1) & (distance < 1.9) & (np.abs(rows - box.shape[0] / 2) > 4)  # not the line of the profile
    expected = 255 * matplotlib.colormaps[style.COLOUR_MAP](distance[fluid] / 2.0)[:, :3]
    assert np.abs(box[fluid] - expected).max() < 8  # |u| = r: linear fits are off by some hundredths of a spacing


@pytest.mark.parametrize(
    ("flow", "expected"),
    [
        ({}, False),
        ({**DEVELOPED}, False),
        ({"top": WallMotion(0.0), "acceleration": 2e-3}, False),
        ({"acceleration": 2e-3}, False),
        ({"acceleration": -2e-3}, True),  # backflow: g H^2/(2 nu U) = -20
        ({"acceleration": -0.5e-4, **DEVELOPED}, False),  # -1/2: the drive does not turn the fluid round ...
        ({"acceleration": -0.5e-4}, True),  # ... except early on, where it does not feel the wall yet
        ({"bottom": WallMotion(-0.002)}, True),
        ({"bottom": WallMotion(0.002)}, False),
        ({"top": WallMotion(0.0, 0.005, 3.0)}, True),
        ({"top": WallMotion(0.0, before=0.005), **DEVELOPED}, True),
        ({"top": WallMotion(0.002, before=0.005), **DEVELOPED}, False),
    ],
)
def test_flows_that_cross_zero_or_die_away_are_known(flow, expected):
    assert make_channel(**flow).vanishing_scale == expected


HEATED_CAVITY = {
    "scene": "cavity",
    "fluid": {"density": 1.0, "kinematic_viscosity": 1.0},
    "geometry": {"width": 1.0, "height": 1.0},
    "walls": {"lid": {"velocity": 1.0}},
    "temperature": {"conductivity": 1.0, "heat_capacity": 1.0, "walls": {"left": 310.0, "right": 300.0}},
    "scalars": [{"name": "dye", "diffusivity": 1.0, "initial": "0.5*y"}],
    "discretisation": {"particles_across": 20},
    "time": {"end": END},
}


@pytest.mark.parametrize(
    ("name", "unit", "along", "ends"), [("temperature", "K", "x", (300.0, 310.0)), ("dye", "", "y", (0.0, 0.5))]
)
def test_colours_of_a_substance_span_its_least_to_largest_value(name, unit, along, ends):
    """On the line from the hot wall to the cold one; a substance named dye takes the place of the pattern."""
    config = loader.loaded(HEATED_CAVITY, {})
    assert name in colours(config)
    scene = scenes.of(config)
    start = start_snapshot(scene, start_values(scene, config.initial), "f64")
    start = replace(start, substances={**start.substances, "temperature": 310.0 - 10.0 * start.x})
    drawn = Drawn(scene, make_video(width=640, height=320, color_by=name))
    frame = drawn.render(start)
    values = start.substances[name]
    quantity = drawn.quantity
    assert quantity.colour_range == (values.min(), values.max()) == pytest.approx(ends, abs=0.1 * (ends[1] - ends[0]))
    assert (quantity.unit, quantity.colour_name, quantity.profile.line.along) == (unit, name, along)
    assert quantity.profile_range == pytest.approx(ends, abs=0.15 * (ends[1] - ends[0]))
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 100  # the colours of the field
