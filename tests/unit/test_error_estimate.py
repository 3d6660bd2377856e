"""The error that `tisph check` states of every sample: how it is computed from rows of the lattice, and its limits.

That it is right is held by ``test_estimates.py``, against runs.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tisph import scenes, schemes
from tisph.cli.check import estimates
from tisph.kernels import quintic_spline, wendland_c2
from tisph.schemes._estimate import EXPLICIT_COST, IMPLICIT_COST, IMPLICIT_OVERHEAD
from tisph.schemes._forecast import beyond, elastic_rows, explicit_rows, implicit_rows
from tisph.schemes._forecast.images import images
from tisph.schemes._forecast.linear import LinearFlow
from tisph.schemes._forecast.stencils import kernel_sums, least_squares, sliding_viscosity
from tisph.schemes.implicit._scheme import control

EXPLICIT, IMPLICIT = "scheme={type: wcsph}", "scheme={type: implicit}"
COARSE, FEW = (f"discretisation.particles_across={number}" for number in (25, 10))
DISORDER = "initial.jitter=0.3"
OLDROYD_B = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.1}"
"""The flow of the case: gap 1, wall speed 0.5, nu = 0.01, 50 across, one sample at the end, t = 2."""


@pytest.fixture
def last(case):
    """Return a function that gives the estimates of the last sample of the case with overrides."""
    return lambda *overrides: estimates(case(*overrides))["samples"][-1]


def rows_of(case, *overrides):
    config, _ = schemes.resolve(case(*overrides))
    channel = scenes.of(config)
    if config.scheme.type == "wcsph":
        return explicit_rows.Rows(config, channel)
    targets = sorted({*config.time.samples, config.time.end})
    return implicit_rows.Rows(config, channel, control(config, channel, targets))


@pytest.mark.parametrize("order", [2, 4])
def test_least_squares_weights_are_exact_up_to_their_order(order):
    laplacian, across = least_squares(order)
    y = np.arange(len(laplacian)) - len(laplacian) // 2
    for power in range(1, order + 1):
        assert laplacian @ y**power == pytest.approx(2.0 * (power == 2), abs=1e-12)
        assert across @ y**power == pytest.approx(float(power == 1), abs=1e-12)


@pytest.mark.parametrize(("kernel", "ratio"), [(quintic_spline, 1.0), (wendland_c2, 1.3)])
def test_kernel_weights_are_exact_for_parabolas(kernel, ratio):
    laplacian, across = kernel_sums(kernel, ratio, standard=False)
    y = np.arange(len(laplacian)) - len(laplacian) // 2
    assert [laplacian @ y, laplacian @ y**2, across @ y, across @ y**2] == pytest.approx([0, 2, 1, 0], abs=1e-12)


def test_sliding_rows_have_another_viscosity():
    """None on the square lattice, and the same after whole spacings: the mean over a spacing is what is left."""
    assert sliding_viscosity(quintic_spline, 1.0, 0.0) == pytest.approx(1.0, abs=1e-14)
    whole = sliding_viscosity(quintic_spline, 1.0, 1.0)
    assert 1e-6 < abs(whole - 1.0) < 1e-3
    assert sliding_viscosity(quintic_spline, 1.0, 7.0) == whole
    # of so many neighbours sums are all but integrals, which do not see how rows stand
    assert sliding_viscosity(quintic_spline, 2.0, 1.0) == pytest.approx(1.0, abs=0.1 * abs(whole - 1.0))


def test_images_continue_a_straight_line(case):
    """u = U + s d at the depth d inside is u = U - s d beyond, for treatments that are exact for it."""
    treatments = {name: case(f"walls.treatment={{type: {name}}}", EXPLICIT).walls.treatment for name in WALLS}
    depths = np.arange(9) + 0.5
    for treatment in treatments.values():
        shares, wall = images(treatment, quintic_spline, 1.0, 3, 9)
        assert wall * 0.7 - shares @ (0.7 + 0.2 * depths) == pytest.approx(0.7 - 0.2 * depths[:3], rel=1e-12)


def test_images_continue_a_polymer_stress_by_its_slope_at_the_wall(case):
    polymer = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.3}"
    rows = rows_of(case, EXPLICIT, COARSE, polymer, "walls.treatment.type=consistent_image")
    state = np.concatenate([np.zeros(25), 0.2 + 0.3 * rows.heights, [0.3, 0.3]])
    heights = rows._extend(rows.heights, -rows.depths, 1.0 + rows.depths)
    assert rows._extended_fields()[1] @ state == pytest.approx(0.2 + 0.3 * heights, rel=1e-12)


WALLS = ("comoving_image", "consistent_image", "fixed_image", "virtual_image")


@pytest.mark.parametrize("treatment", [*WALLS, "adami"])
def test_images_continue_an_even_polymer_stress_evenly(case, treatment):
    rows = rows_of(case, EXPLICIT, COARSE, OLDROYD_B, f"walls.treatment.type={treatment}")
    fields = rows._extended_fields()[1] @ np.concatenate([np.zeros(25), np.full(25, 0.2), [0.0, 0.0]])
    reached = np.flatnonzero(fields)  # images with liquid in reach
    assert reached[-1] - reached[0] + 1 == len(reached) >= 25 + 4
    assert fields[reached] == pytest.approx(0.2, rel=1e-12)


def test_a_polymer_stress_that_a_drive_has_developed_falls_by_its_part_of_the_drive_at_both_walls(case):
    polymer = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.4}"
    rows = rows_of(case, EXPLICIT, COARSE, polymer, "drive.acceleration=0.3", "initial.state=developed")
    # polymer viscosity u_yy = -0.6 of the drive: differences of a parabola's slope, but for rounding over a short way
    assert rows._wall_slopes() == pytest.approx([-0.6 * 0.3] * 2, rel=1e-6)


def test_linear_flow_solves_its_equations():
    """x' = a x + b cos(w t) + c from 0 for an even state, and an odd one that only decays; one row at each wall."""
    a, b, c, w, t = -0.7, 0.3, 0.2, 1.9, 1.3
    matrix = np.array([[a, 0.1], [0.1, a]])
    flow = LinearFlow(
        matrix,
        np.zeros(2),
        [(w, np.full(2, b, dtype=complex))],
        np.full(2, c),
        np.array([0.5, -0.5]),
        0.0,
        (np.array([1, 0]), np.ones(2)),
    )
    even, odd = a + 0.1, a - 0.1
    wave = (b / (1j * w - even) * (np.exp(1j * w * t) - np.exp(even * t))).real
    expected = wave - c / even * (1 - math.exp(even * t))
    assert flow.at(t) == pytest.approx(expected + 0.5 * math.exp(odd * t) * np.array([1, -1]), rel=1e-12)


def test_many_steps_at_once_are_what_they_are_one_by_one(case, monkeypatch):
    """Velocities and number of steps; the strain limits them here, and changes while many are taken at once."""
    overrides = (IMPLICIT, COARSE, "fluid.kinematic_viscosity=1e-3", "time.end=100")
    leaping = rows_of(case, *overrides)
    leaping.run_to(100.0)
    monkeypatch.setattr(implicit_rows, "MANY", 0.0)
    walking = rows_of(case, *overrides)
    walking.run_to(100.0)
    assert walking.steps > 200
    assert leaping.steps == pytest.approx(walking.steps, rel=0.02)
    assert leaping.velocity == pytest.approx(walking.velocity, abs=3e-7)  # the tolerance of a step


SWINGING = [
    f"walls.{side}={{amplitude: 0.5, angular_frequency: {w}, phase: sin}}"
    for side, w in zip(("top", "bottom"), (1.0, 0.7), strict=True)
]
RAMPS = ["walls.top={times: [0.0, 2.5], velocities: [0.0, 1.0]}", "walls.bottom={velocity: -0.2}"]


@pytest.mark.parametrize("walls", [SWINGING, RAMPS], ids=["swinging", "ramps"])
@pytest.mark.parametrize("treatment", ["consistent_image", "comoving_image"])
def test_what_is_left_after_a_long_time_solves_the_equations(case, treatment, walls):
    """x' = rates x + source(t), of both walls and the drive, to fourth order in the step of the difference."""
    drive = ("drive.acceleration=0.3", f"walls.treatment.type={treatment}", "time.end=2.5")
    rows = rows_of(case, IMPLICIT, COARSE, *drive, *walls)
    time, step = 2.0, 0.01
    around = [rows._settled(time + k * step) for k in (-2, -1, 1, 2)]
    rate = np.dot([1.0, -8.0, 8.0, -1.0], around) / (12 * step)
    expected = rows.rates * rows._settled(time) + rows._source(time)
    assert rate == pytest.approx(expected, abs=1e-8 * np.abs(rows._source(time)).max())


@pytest.mark.parametrize("length", [0.1, 1000.0])
def test_a_residual_does_to_the_slowest_mode_what_its_system_leaves_of_it(case, length):
    """The flow being that mode, its right side is as much larger than the mode as an error is smaller than a residual.

    Errors of a mode that falls faster come from a right side that is larger by its part of the Laplacian.
    """
    rows = rows_of(case, IMPLICIT, COARSE)
    rows.last, alone = length, rows.control.tolerance * implicit_rows.RESIDUALS
    for mode in (0, 7):
        rows.amplitudes = 3.0 * np.eye(25)[mode]
        left = 1.0 - implicit_rows.GAMMA * length * rows.rates[[0, mode]]
        assert rows.residual == pytest.approx(alone * left[1] / left[0], rel=1e-14)


def test_a_residual_of_a_liquid_with_memory_is_that_of_one_without(case):
    """Of the same rows, in one step of the same length; the Laplacians of both are those of the lattice."""
    rows, found = rows_of(case, IMPLICIT, "time.tolerance=1e-4"), []
    rows.run_to(1.0)
    both = {"channel": rows.channel, "control": rows.control, "length": rows.last}
    operators = elastic_rows._Operators(rows.channel, 4)
    for scale in (1.0, 3.0):
        elastic = SimpleNamespace(**both, operators=operators, velocity=scale * rows.velocity)
        found.append(elastic_rows.ElasticRows.residual.fget(elastic))
    assert found == pytest.approx([rows.residual] * 2, rel=1e-3)  # one has the slowest mode, one a wave of its length


def test_the_step_that_is_stated_is_the_longest_of_the_run(case):
    brief = case(IMPLICIT, COARSE, "time={end: 1.0e-3}")
    assert 0.0 < estimates(brief)["time_step"] <= 1e-3


def test_whole_periods_are_left_out_of_a_long_run(case):
    """The flow of a wall that oscillates is the same after each; steps go on as before."""
    wall = "walls.top={amplitude: 0.5, angular_frequency: 1.0, phase: sin}"
    numbers = estimates(case(IMPLICIT, COARSE, wall, "time.end=1e6", "time.samples=[1e3, 1e6]"))
    first, last = numbers["samples"]
    assert last.steps == pytest.approx(1e3 * first.steps, rel=0.1)
    assert last.rms == pytest.approx(first.rms, rel=1.0)  # another phase


@pytest.mark.timeout(120)  # it takes a tenth of a second, or weeks
def test_the_end_of_a_long_run_is_told_at_once(case):
    """Rows are not stepped one by one."""
    for scheme in (EXPLICIT, IMPLICIT):
        assert estimates(case(scheme, "time.end=1e12"))["steps"] > 1e11


def test_the_error_falls_with_the_order_of_the_operators(last):
    """In the spacing, where no other error counts; 4 and 2 for a layer of five spacings and more."""
    tight = ("time.tolerance=1e-8", "time.samples=[2]", "time.end=2")
    for scheme, order in ((IMPLICIT, 4), (IMPLICIT.replace("}", ", operators: {order: 2}}"), 2)):
        coarse, fine = (last(scheme, *tight, f"discretisation.particles_across={n}").rms for n in (25, 50))
        assert math.log2(coarse / fine) == pytest.approx(order, abs=0.5)
    coarse, fine = (last(EXPLICIT, *tight[1:], f"discretisation.particles_across={n}").rms for n in (25, 50))
    assert math.log2(coarse / fine) == pytest.approx(2, abs=0.5)


@pytest.mark.parametrize("scheme", [EXPLICIT, IMPLICIT])
def test_rows_finer_than_is_worth_the_time_are_extrapolated(last, scheme, monkeypatch):
    """The explicit scheme's error by its order; that of the implicit one is that of its steps."""
    late = ("time.samples=[10]", "time.end=10", "time.tolerance=1e-4" if scheme == IMPLICIT else "time.cfl=0.25")
    full = last(scheme, *late)
    monkeypatch.setattr("tisph.schemes._forecast.MOST_ROWS", {"newtonian": 25})
    monkeypatch.setattr("tisph.schemes._forecast.MOST_IMPLICIT_ROWS", 25)
    assert last(scheme, *late).rms == pytest.approx(full.rms, rel=0.5)  # steps differ with the rows


def test_single_precision_has_a_floor(last):
    late = ("time.samples=[300]", "time.end=300", "discretisation.precision=%s", COARSE)
    double, single = (last(EXPLICIT, *late[:2], late[2] % name, COARSE).rms for name in ("f64", "f32"))
    assert double < 1e-10 < 2.0**-25 < single


def test_disorder_costs_at_high_reynolds_numbers_only(last):
    def ratio(viscosity):
        flow = (IMPLICIT, COARSE, f"fluid.kinematic_viscosity={viscosity}", f"time.end={0.3 / viscosity}")
        return last(*flow, DISORDER).rms / last(*flow).rms

    assert ratio(0.1) < 2  # cell Reynolds number 0.2
    assert ratio(2e-4) > 10  # 100


@pytest.mark.parametrize(
    "overrides",
    [
        (EXPLICIT, "fluid.kinematic_viscosity=7e-5", "time.end=200"),  # cell Reynolds number 143: rows mix
        (EXPLICIT, DISORDER, "time.cfl=0.8"),
        (EXPLICIT, DISORDER, COARSE, "fluid.kinematic_viscosity=3.3e-4"),  # 61: they do, disordered
        ("scheme={type: implicit, operators: {order: 2}}", "fluid.kinematic_viscosity=5e-3", DISORDER),
    ],
)
def test_no_estimate_where_the_model_cannot_tell(last, overrides):
    sample = last(*overrides)
    assert (sample.l2, sample.rms) == (None, None)
    assert sample.steps > 0


@pytest.mark.parametrize(("viscosity", "at_most"), [(7.2e-4, False), (7.1e-4, True), (3.4e-4, True)])  # 27.8, 28.2, 59
def test_disorder_of_the_explicit_scheme_errs_at_most_as_rows_do_where_viscosity_does_not_keep_up(
    last, viscosity, at_most
):
    flow = EXPLICIT, COARSE, f"fluid.kinematic_viscosity={viscosity}"
    lattice, disordered = last(*flow), last(*flow, DISORDER)
    assert disordered.rms == pytest.approx(lattice.rms, rel=1e-2)  # rows of a lattice slide, those of a disorder do not
    assert (lattice.at_most, disordered.at_most) == (False, at_most)


@pytest.mark.parametrize(("reynolds", "t", "lost"), [(60.6, 0.1, True), (59.4, 0.1, False), (60.6, 1.0, False)])
def test_the_profile_is_lost_where_rows_mix_more_than_the_layer_holds(case, reynolds, t, lost):
    """Cell Reynolds numbers around RESOLVED; the layer is a seventh of a spacing, or half of one, so a LOST of it."""
    config = case(EXPLICIT, COARSE, f"fluid.kinematic_viscosity={0.5 * 0.04 / reynolds}", f"time={{end: {t}}}")
    channel = scenes.of(config)
    assert beyond.lost(config, channel) == lost


@pytest.mark.parametrize(
    ("scheme", "cost", "overhead"), [(EXPLICIT, EXPLICIT_COST, 0.0), (IMPLICIT, IMPLICIT_COST, IMPLICIT_OVERHEAD)]
)
def test_steps_and_cost_of_a_run_are_those_up_to_its_last_sample(case, scheme, cost, overhead):
    numbers = estimates(case(scheme, COARSE, "time.end=2", "time.samples=[0, 1, 2]"))
    assert numbers["samples"][-1].steps == numbers["steps"]
    assert numbers["run_time"] == pytest.approx(numbers["steps"] * (overhead + 25 * 50 * cost), rel=1e-14)


def test_what_disorder_leaves_is_that_of_a_dipole_at_the_wall(case):
    """sum k^2 exp(-2 (k pi)^2 t*), from t* = (spacing/gap)^2 on."""
    config = case(COARSE)
    channel = scenes.of(config)
    waves = np.arange(1.0, 1000.0)
    for t_star, effective in ((0.0, 0.04**2), (1e-3, 0.04**2), (0.01, 0.01), (0.3, 0.3)):
        expected = np.sum(waves**2 * np.exp(-2 * (waves * np.pi) ** 2 * effective))
        assert beyond._spread(config, channel, 100.0 * t_star) ** 2 == pytest.approx(
            expected, rel=1e-6
        )  # exp(-20) is left out


@pytest.mark.parametrize("time", [0.003, 0.1, 2.0])
def test_what_is_left_of_a_wave_solves_its_equation_in_a_liquid_with_memory(case, time):
    """relaxation_time u'' + (1 + relaxation_time nu_s q^2) u' + nu q^2 u = 0, from u = 1 and u' = -nu_s q^2."""
    config = case(COARSE, "fluid.kinematic_viscosity=0.2", OLDROYD_B)
    channel = scenes.of(config)
    waves = np.array([1.0, 3.0, 20.0])  # the first two oscillate
    left = beyond._left(config, channel, waves, time)
    for wave, found in zip(waves, left, strict=True):
        square = (wave * math.pi / channel.gap) ** 2
        first, second = np.roots([0.5, 1.0 + 0.5 * channel.solvent_viscosity * square, 0.2 * square])
        start = -channel.solvent_viscosity * square
        share = (start - second) / (first - second)
        expected = share * np.exp(first * time) + (1.0 - share) * np.exp(second * time)
        assert found == pytest.approx(expected.real, rel=1e-9)


def test_disorder_makes_as_much_of_normal_stresses_as_their_size_over_the_shear_stress(last):
    """sqrt(1 + (0.3 Wi)^2) times the error of the rows; at Wi = 5 that may as well cancel, at 0.5 it hardly can."""
    for speed, at_most in ((1.0, False), (10.0, True)):
        flow = (
            IMPLICIT,
            FEW,
            OLDROYD_B,
            "fluid.kinematic_viscosity=1.0",
            f"walls.top.velocity={speed}",
            "time={end: 0.5}",
        )
        lattice, disordered = last(*flow), last(*flow, DISORDER)
        assert disordered.rms == pytest.approx(lattice.rms * math.hypot(1.0, 0.3 * 0.5 * speed), rel=1e-2)
        assert disordered.at_most == at_most


@pytest.mark.parametrize(("viscosity", "known"), [(0.0205, True), (0.0195, False)])  # 9.8, 10.3
def test_disordered_polymer_breaks_up_where_the_solvent_has_little_viscosity(case, viscosity, known):
    flow = case(IMPLICIT, COARSE, OLDROYD_B, f"fluid.kinematic_viscosity={viscosity}", DISORDER)
    sample = estimates(flow)["samples"][-1]
    assert (sample.known, sample.rms is not None) == (known, known)


def test_disorder_leaves_more_where_rows_slide(case):
    """Its two limits: AT_REST of it where they do not, and all of it besides where they do."""
    found = []
    for viscosity in (1e3, 1e-9):
        config = case(IMPLICIT, COARSE, DISORDER, f"fluid.kinematic_viscosity={viscosity}")
        found.append(beyond._stirred(config, scenes.of(config)))
    whole = 0.3 * beyond.STIRRED * 0.04**2
    assert found == pytest.approx([beyond.AT_REST * whole, (1.0 + beyond.AT_REST) * whole], rel=1e-6)


def test_single_precision_stirs_where_viscosity_does_not_keep_up(case):
    """Cell Reynolds numbers 100 and 200: all of it, as of the largest jitter of the stability matrix, or nothing."""
    found = []
    for viscosity in (2e-4, 1e-4):
        config = case(IMPLICIT, COARSE, "discretisation.precision=f32", f"fluid.kinematic_viscosity={viscosity}")
        found.append(beyond._stirred(config, scenes.of(config)))
    assert found[0] == 0.0
    assert found[1] == pytest.approx(0.3 * beyond.STIRRED * 0.04**2, rel=0.05)  # and AT_REST


def test_a_start_has_no_error(case):
    first = estimates(case("time.samples=[0, 2]"))["samples"][0]
    assert (first.steps, first.rms) == (0, 0.0)
