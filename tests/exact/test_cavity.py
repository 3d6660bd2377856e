"""Lid-driven cavity: tables against each other, the regular lid against its equation, orders and known numbers."""

import numpy as np
import pytest

from tisph.exact import cavity
from tisph.exact.cavity import RegularCavity

RANDOM = np.random.default_rng(5)
LIGHT = 20  # a degree that takes a twentieth of a second, for what holds at every degree


def test_tables_of_two_sources_agree():
    """At Re = 1000 both have the middle, and the extremes of one bound the lines of both, to 1e-5 and their places."""
    lines = {(line.source, line.component): line for line in cavity.centre_lines(1000)}
    assert len(lines) == 4
    for component in ("u", "v"):
        one, other = lines["Marchi et al. 2009", component], lines["Botella and Peyret 1998", component]
        _, here, there = np.intersect1d(one.coordinate, other.coordinate, return_indices=True)
        assert len(here) == 2  # 1/16 and 1/2
        assert np.abs(one.value[here] - other.value[there]).max() < 1e-5
    bounds = cavity.extremes(1000)
    assert set(bounds) == {"u_min", "v_min", "v_max", "psi_min"}
    for (_, component), line in lines.items():
        assert line.value.min() >= bounds[f"{component}_min"] - 1e-6
    assert lines["Botella and Peyret 1998", "v"].value.max() == pytest.approx(bounds["v_max"], abs=1e-4)


@pytest.mark.parametrize("reynolds", [100, 400])
def test_tables_lie_within_their_extremes(reynolds):
    bounds, lines = cavity.extremes(reynolds), cavity.centre_lines(reynolds)
    assert [(line.source, line.component, len(line.value)) for line in lines] == [
        ("Marchi et al. 2009", "u", 15),
        ("Marchi et al. 2009", "v", 15),
    ]
    for line in lines:
        least = line.value.min()
        assert bounds[f"{line.component}_min"] <= least <= 0.97 * bounds[f"{line.component}_min"]
    assert 0.98 * bounds["v_max"] <= lines[1].value.max() <= bounds["v_max"]


def test_another_reynolds_number_is_refused_with_those_that_there_are():
    with pytest.raises(ValueError, match="tabulated at Re = 100, 400, 1000, not 300"):
        cavity.extremes(300)


def residual(flow, x, y, step):
    """u dw/dx + v dw/dy - nu lap w by central differences of fourth order of the vorticity w."""
    weights, steps = np.array([1, -8, 8, -1]) / 12, np.array([-2, -1, 1, 2]) * step
    along = sum(w * flow.vorticity(x + s, y) for w, s in zip(weights, steps, strict=True)) / step
    across = sum(w * flow.vorticity(x, y + s) for w, s in zip(weights, steps, strict=True)) / step
    weights, steps = np.array([-1, 16, -30, 16, -1]) / 12, np.arange(-2, 3) * step
    bend = sum(w * (flow.vorticity(x + s, y) + flow.vorticity(x, y + s)) for w, s in zip(weights, steps, strict=True))
    u, v = flow.velocity(x, y)
    return u * along + v * across - flow.kinematic_viscosity * bend / step**2


def test_the_flow_obeys_its_equation_and_its_walls():
    """In a cavity that is no square, in units of its own: vorticity is carried and diffuses, off the corners."""
    flow = RegularCavity(width=2.0, height=1.5, speed=3.0, kinematic_viscosity=0.2, order=32)
    assert flow.reynolds == pytest.approx(30.0)
    x, y = RANDOM.uniform(0.3, 1.7, 50), RANDOM.uniform(0.2, 1.2, 50)
    # parts of the equation are up to 3; measured 8e-4 at degree 24, 1.2e-4 at 32, 3e-5 at 40, left by the corners
    assert np.abs(residual(flow, x, y, 0.01)).max() < 4e-4
    along, up = np.linspace(0.0, 2.0, 21), np.linspace(0.0, 1.5, 21)
    walls = {
        "lid": (along, 1.5, flow.lid(along)),
        "bottom": (along, 0.0, 0.0),
        "left": (0.0, up, 0.0),
        "right": (2.0, up, 0.0),
    }
    for x, y, speed in walls.values():
        u, v = flow.velocity(x, y)
        assert max(np.abs(u - speed).max(), np.abs(v).max()) < 1e-11
    assert flow.lid(1.0) == 3.0
    change = flow.stream_function(0.7, 0.9 + 1e-5) - flow.stream_function(0.7, 0.9 - 1e-5)
    assert change / 2e-5 == pytest.approx(flow.velocity(0.7, 0.9)[0], abs=1e-8)


@pytest.mark.parametrize("reynolds", [1.0, 100.0])
def test_degrees_agree(reynolds):
    """Where u is most wrong, near the upper corners, by the sixth order; and psi, as particles on 50 x 50 had it."""
    x, y = np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41))
    flows = [RegularCavity(1.0, 1.0, 1.0, 1 / reynolds, order) for order in (20, 26, 32)]
    u = [flow.velocity(x, y)[0] for flow in flows]
    errors = [np.abs(one - u[2]).max() for one in u[:2]]
    assert errors[0] < 2e-5
    assert errors[1] < errors[0] / 2
    psi = [flow.extremes()["psi_min"] for flow in flows]
    assert abs(psi[1] - psi[2]) < 1e-8
    assert psi[2] == pytest.approx(-0.08368, abs=2e-5)


def test_the_slowest_flow_is_symmetric_and_reversible():
    """Stokes flow: u even and v odd about x = 1/2; a lid the other way mirrors any flow."""
    x, y = RANDOM.uniform(0, 1, (2, 40))
    stokes = RegularCavity(1.0, 1.0, 1.0, 1e6, LIGHT)
    (u, v), (mirrored_u, mirrored_v) = stokes.velocity(x, y), stokes.velocity(1 - x, y)
    assert max(np.abs(u - mirrored_u).max(), np.abs(v + mirrored_v).max()) < 1e-6  # Re = 1e-6


def test_extremes_are_those_of_fine_lines():
    flow = RegularCavity(2.0, 2.0, 0.5, 0.01, LIGHT)
    fine = np.linspace(0.0, 2.0, 4001)
    found = flow.extremes()
    assert found["u_min"] == pytest.approx(flow.velocity(1.0, fine)[0].min() / 0.5, abs=1e-6)
    assert found["v_min"] == pytest.approx(flow.velocity(fine, 1.0)[1].min() / 0.5, abs=1e-6)
    assert found["v_max"] == pytest.approx(flow.velocity(fine, 1.0)[1].max() / 0.5, abs=1e-6)
    grid = flow.stream_function(fine[::40][:, None], fine[::40])
    assert grid.min() - 1e-4 < found["psi_min"] <= grid.min()


def test_a_flow_that_is_not_found_says_so():
    with pytest.raises(ValueError, match="take a higher order"):
        RegularCavity(1.0, 1.0, 1.0, 1e-5, 8).velocity(0.5, 0.5)
