"""Polymer in scheme implicit: orders, impulses, positivity and momentum of a viscoelastic fluid."""

import functools

import numpy as np
import pytest
from case_from_text import to_end as run
from flows import flow_text
from implicit_case import IMPLICIT, channel_of, fix_steps, start_of_layers

from tisph.schemes.implicit.channel.models import ViscoelasticModel, conformation_excess

pytestmark = pytest.mark.taichi

LIQUID = "fluid={{density: 2.0, kinematic_viscosity: 1.0, rheology: {}}}"
OLDROYD = LIQUID.format("{type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.1}")
GIESEKUS = LIQUID.format("{type: giesekus, relaxation_time: 1.0, solvent_fraction: 0.1, mobility: 0.3}")
DRIVEN = ("walls.top.velocity=0.0", "drive.acceleration=4.0")


@pytest.fixture
def make(make):
    """``make`` for scheme implicit with an Oldroyd-B liquid."""
    return functools.partial(make, *IMPLICIT, OLDROYD)


def errors(scheme):
    """Run to the end; return the relative errors of u, S_xy and S_xx."""
    last = run(scheme)
    exact = scheme.channel.exact
    pairs = [(getattr(last, name), exact(name, last.x, last.y, last.t)) for name in ("u", "stress_xy", "stress_xx")]
    return np.array([np.linalg.norm(found - wanted) / np.linalg.norm(wanted) for found, wanted in pairs])


def test_the_order_in_the_spacing_is_that_of_the_rows(make):
    # from the smooth flow at t = 0.5, whose wave has crossed half of the gap
    options = ("initial={state: exact, time: 0.5}", "time={end: 0.6, tolerance: 1.0e-8}", *DRIVEN)
    found = [errors(make(f"discretisation.particles_across={across}", *options)) for across in (12, 24)]
    assert np.all(np.log2(found[0] / found[1]) > 3.5)


def test_steps_are_of_third_order_in_velocity_and_stress(make):
    # a driven start without a jump; the truth is that of much shorter steps on the same lattice, to a 64th of the finer
    states = {}
    for length in (0.1, 0.05, 0.0125):
        scheme = make(GIESEKUS, *DRIVEN, "time.end=0.8", "scheme.largest_strain=2.0")
        fix_steps(scheme, length)
        last = run(scheme)
        states[length] = [last.u, last.stress_xy, last.stress_xx]
    for rough, fine, truth in zip(*states.values(), strict=True):
        # 8, less what the next order takes with steps of a tenth of the relaxation time
        assert np.linalg.norm(rough - truth) / np.linalg.norm(fine - truth) > 5.5


FENE = LIQUID.format("{type: fene_p, relaxation_time: 1.0, solvent_fraction: 0.1, maximum_extension: 9.0}")


def test_a_start_under_way_has_the_conformation(make):
    # a stress alone does not tell the stretch of a spring that stiffens; two modes are rows of verify
    start = "initial={state: exact, time: 0.5}", "walls.top.velocity=1.0", "time.end=0.6"
    scheme = make(FENE, *start, "discretisation.particles_across=16")
    channel, model = scheme.channel, scheme.walls.model
    heights = scheme.snapshot().y
    exact = channel.exact_polymer_stress(heights, channel.start_time)[:2]
    started = model.stress(model.initial(channel, heights))
    assert np.allclose(channel.density * started[:2], exact, rtol=1e-12, atol=1e-12)
    assert np.all(errors(scheme) < 1e-3)  # three times what was measured


def test_on_a_sheared_lattice_the_layers_solve_the_systems(make):
    scheme = make("walls.top.velocity=1.0", "time={end: 0.5, tolerance: 1.0e-4}")
    solver, counts = scheme.closed.solver, []
    solve = solver.solve_coupled
    solver.solve_coupled = lambda *numbers: (solve(*numbers), counts.append(solver.iterations))[0]
    run(scheme)
    # rounding of the operators over a tolerance of 1e-7 of the right side; without the rows it takes 5 to 10
    assert counts
    assert max(counts) <= 1


def test_disorder_costs_no_more_than_a_factor_of_two(make):
    options = ("walls.top.velocity=1.0", "discretisation.particles_across=25", "time.end=1.0")
    lattice, disorder = (errors(make(*options, jitter=jitter)) for jitter in (0.0, 0.2))
    assert np.all(disorder[:2] < 2.0 * lattice[:2] + 1e-5)


def test_the_momentum_of_walls_drive_and_fluid_closes(make):
    scheme = make(*DRIVEN, "discretisation.particles_across=25", "time.end=1.0")
    run(scheme)
    # fits of third order at 12 spacings from the middle
    assert scheme.momentum_balance()["closure"] < 1e-3


JUMPING = flow_text("sheared_channel")


@pytest.fixture
def layers(tmp_path):
    """Return a function that gives the layers of a channel at the start."""
    return lambda *overrides: start_of_layers(*channel_of(tmp_path, JUMPING, overrides))


def test_a_jump_is_the_limit_of_a_fast_ramp(layers):
    # the wall speeds up by a polynomial within 1e-3 of the time in which momentum crosses a spacing
    jumped, ramped = layers(OLDROYD), layers(OLDROYD)
    channel = ramped.channel
    ramped.flow.velocity[...] = 0.0
    ramped.flow.state[...] = 0.0
    duration = 1e-3 * channel.spacing**2
    for wall in ramped.walls:
        wall.forget()
    ramped.walls.walls[1].motion = Ramp(duration)
    number = 200
    for step in range(number):
        flows, _ = ramped.step.advance(step * duration / number, duration / number, 1e-12)
        ramped.flow = flows[-1]
        ramped.walls.conclude()
    flow = ramped.flow
    # a few times the 1e-3 of the rates that the limit leaves out
    for found, wanted in ((jumped.flow.velocity, flow.velocity), (jumped.flow.state[1], flow.state[1])):
        assert np.abs(found - wanted).max() < 3e-3 * np.abs(wanted).max()
    for name in ("slope", "third"):
        # of A_xy, which alone has a part in the momentum
        found, wanted = (np.array([getattr(wall, name)[1] for wall in each.walls]) for each in (jumped, ramped))
        assert found == pytest.approx(wanted, rel=3e-3, abs=3e-3 * np.abs(wanted).max())


class Ramp:
    """A wall that speeds up to 1 with three continuous derivatives."""

    oscillates = False

    def __init__(self, duration):
        self.duration = duration
        self.curve = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])

    def velocity(self, time):
        return self.curve(time / self.duration)

    def acceleration(self, time):
        return self.curve.deriv()(time / self.duration) / self.duration

    def jerk(self, time):
        return self.curve.deriv(2)(time / self.duration) / self.duration**2


# --- the law at a point


@pytest.fixture(
    params=[
        "{type: oldroyd_b, relaxation_time: 2.0, solvent_fraction: 0.1}",
        "{type: giesekus, relaxation_time: 2.0, solvent_fraction: 0.1, mobility: 0.3}",
        "{type: fene_p, relaxation_time: 2.0, solvent_fraction: 0.1, maximum_extension: 30.0}",
        "{type: multi_mode, solvent_fraction: 0.1, modes: [{type: oldroyd_b, relaxation_time: 1, "
        "fraction: 0.5}, {type: giesekus, relaxation_time: 3, mobility: 0.2, fraction: 0.4}]}",
    ]
)
def model(request, tmp_path):
    """The model of a fluid."""
    settings, _ = channel_of(tmp_path, JUMPING, [f"fluid.rheology={request.param}"])
    return ViscoelasticModel(settings.fluid.rheology, 1.0)


def test_the_update_solves_the_stage_and_its_tangent_is_the_derivative(model):
    known = 0.3 * np.random.default_rng(1).uniform(-1.0, 1.0, (model.components, 7))
    rates = np.linspace(-3.0, 3.0, 7)
    state, slope = model.update(known, 0.2, rates, known)
    assert state == pytest.approx(known + 0.2 * model.rate(state, rates), abs=1e-11)  # Newton ends at 1e-13 of 10
    step = 1e-5
    ahead, behind = (
        model.shear_stress(model.update(known, 0.2, one, known)[0], one) for one in (rates + step, rates - step)
    )
    assert slope == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)  # differences: 1e-10 and rounding 1e-11


def test_the_states_shear_as_the_conformation_does(model):
    # what is carried is another form of A; small steps of the law in A itself lead to the same stress
    carried, plain = np.zeros((model.components, 1)), [np.zeros(law.components) for law in model.laws]
    rate, length = 4.0, 1e-4
    for _ in range(2000):
        middle = carried + 0.5 * length * model.rate(carried, rate)
        carried = carried + length * model.rate(middle, rate)
        for law, state in zip(model.laws, plain, strict=True):
            middle = state + 0.5 * length * np.array(law.rate_in_shear(state, rate))
            state += length * np.array(law.rate_in_shear(middle, rate))
    for part, state in zip(model.parts, plain, strict=True):
        # midpoint rules of step 4e-4 of the strain: 1e-7 each
        assert np.array(conformation_excess(carried[part]))[:, 0] == pytest.approx(state, rel=1e-6, abs=1e-6)


def test_the_conformation_stays_positive_at_large_strain(make):
    # 40 units of strain while nothing relaxes: A_xx = 1 + 1600, and one unit less would not be positive
    law = LIQUID.format("{type: oldroyd_b, relaxation_time: 1000.0, solvent_fraction: 0.5}")
    scheme = make(law, "walls.top.velocity=40.0", "time={end: 1.0, tolerance: 1.0e-3}")
    run(scheme)
    states = scheme.walls.model.indefinite(scheme.particles.flow().state)
    assert states.size == 0


@pytest.mark.parametrize(("elasticity", "bound"), [(1e-3, 2e-5), (0.1, 2e-3)])
def test_an_impulse_moves_no_fluid_faster_than_the_wall(layers, elasticity, bound):
    # its series says 4.1 times as fast at 1e-3, and steps of 1e-8 of the viscous time followed at Re = 100
    liquid = f"fluid.rheology={{type: oldroyd_b, relaxation_time: {elasticity}, solvent_fraction: 0.1}}"
    speed = 0.1 / elasticity
    found = layers(liquid, f"walls.top.velocity={speed}", "discretisation.particles_across=25")
    assert 0.0 < np.abs(found.velocity).max() < speed
    found.run_to(0.1)
    assert not found.unknown
    exact = found.channel.exact_velocity(found.heights, 0.1)
    # Wi = 0.1; measured: 7.7e-6, without any impulse 2.5e-4, and 1.2e-3
    assert np.linalg.norm(found.velocity - exact) < bound * np.linalg.norm(exact)


def test_a_step_too_long_for_the_stress_is_tried_again(make):
    """Beside a later rate of 100 velocities have no error, and steps grow until the stress of a step has no value."""
    fluid = (
        "{type: phan_thien_tanner, relaxation_time: 1.0, solvent_fraction: 0.5, extensibility: 0.05, form: exponential}"
    )
    slow = (
        f"fluid={{density: 1.0e-8, dynamic_viscosity: 2.0, rheology: {fluid}}}",
        "time={end: 20.0, tolerance: 1.0e-5}",
    )
    ramp = "walls.top={times: [0.0, 1.0, 20.0, 21.0], velocities: [0.0, 0.1, 0.1, 100.0]}"
    scheme = make(*slow, ramp, "discretisation.particles_across=10", "geometry={gap: 1.0, length: 1.4}")
    last = run(scheme)
    assert last.stress_xy == pytest.approx(0.0999002, rel=1e-5)
