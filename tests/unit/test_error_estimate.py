"""The error that `tisph check` states: how it goes with spacing, time, walls, liquid and cell Reynolds number."""

import math

import pytest

from tisph.cli.check import estimates

EXPLICIT = "scheme={type: wcsph}"
COARSE = "discretisation.particles_across=25"
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: %g, solvent_fraction: 0.25}"
AT_REST = "walls.top.velocity=0"
"""The flow of the case: gap 1, wall speed 0.5, nu = 1, 50 across, last sample at t = 1.8."""


@pytest.fixture
def error(case):
    """Return a function that states the error of the case with overrides."""
    return lambda *overrides: estimates(case(*overrides))["error"]


def test_follows_order_and_scheme(error):
    tight = ("scheme={type: implicit, largest_strain: 1e-3}", "time.tolerance=1e-10")
    # the operators' part alone: order 4 and 2 in the spacing
    assert error(*tight, COARSE) == pytest.approx(16 * error(*tight), rel=1e-3)
    assert error(EXPLICIT, COARSE) == pytest.approx(4 * error(EXPLICIT), rel=1e-12)


@pytest.mark.parametrize("scheme", [EXPLICIT, "scheme={type: implicit, operators: {order: 2}}"])
def test_says_nothing_of_flows_that_do_not_start_from_rest(error, scheme):
    assert error(scheme, "initial.state=developed") is None


def test_says_nothing_of_standard_operators(error):
    assert error("scheme={type: wcsph, operators: standard}") is None


def test_the_layer_grows_by_the_viscosity_of_the_solvent_first(error):
    """Depth sqrt(nu t): a quarter of the viscosity, four times the error; after many relaxation times no more."""
    newtonian = error(EXPLICIT)
    assert error(POLYMER % 1e6) / error(POLYMER % 1e-3) == pytest.approx(4.0, rel=1e-3)
    assert error(POLYMER % 1e-3) > newtonian


def test_an_oscillating_wall_moves_no_more_than_its_layer(error):
    """Of depth sqrt(nu / w): what a steady wall reaches at t = 1/w."""
    frequency, wall = 100.0, "walls.top={amplitude: 0.5, angular_frequency: 100.0}"
    early = (f"time.samples=[{1 / frequency}]", f"time.end={1 / frequency}")
    assert error(EXPLICIT, wall) == pytest.approx(error(EXPLICIT, *early), rel=1e-12)


def test_a_drive_adds_to_it_at_walls_that_do_not_obey_the_momentum_equation(error):
    """By g spacing^2 / (nu U) in proportion, here 12 (1/50)^2 whatever g is."""
    drive = (EXPLICIT, AT_REST, "drive.acceleration=1")
    adami = (*drive, "walls.treatment={type: adami}")
    at_rest = error(EXPLICIT, "walls.treatment={type: adami}")
    assert error(*adami) - at_rest == pytest.approx(0.2 * 12 / 50**2, rel=1e-9)
    assert error(*adami, "drive.acceleration=7") == pytest.approx(error(*adami), rel=1e-12)
    assert error(*drive) == pytest.approx(error(EXPLICIT), rel=1e-12)


def test_an_unresolved_start_costs_the_explicit_scheme_more(error):
    """With the square of the cell Reynolds number from 60 on, up to where the profile is lost; not without a wall
    that starts."""
    thin = [EXPLICIT, "time.samples=[1000]", "time.end=1000"]

    def at(viscosity, *overrides):
        cells = 0.5 / 50 / viscosity  # cell Reynolds number
        return error(*thin, f"fluid.kinematic_viscosity={viscosity}", *overrides), cells

    (resolved, _), (thicker, cells) = at(0.01 / 60), at(0.01 / 240)
    assert cells == pytest.approx(240)
    assert thicker / resolved == pytest.approx(4 * (240 / 60) ** 2, rel=1e-12)  # nu t is four times smaller
    assert at(1e-9)[0] == 0.5
    drive = (AT_REST, "drive.acceleration=1e-4")
    calm, driven = at(0.01 / 60, *drive)[0], at(0.01 / 240, *drive)[0]
    assert driven / calm == pytest.approx(4.0, rel=1e-12)
    assert math.isfinite(calm)
