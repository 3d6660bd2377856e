"""A simulation in the hand: the states, bits and files of ``tisph run``, step by step in this process."""

import gc
import signal

import numpy as np
import pytest
from couette import couette

import tisph
from tisph import runtime, simulation
from tisph.config.loader import loaded
from tisph.errors import ConfigError, DivergedError, TisphError
from tisph.runtime import ti
from tisph.simulation.simulation import changed

pytestmark = pytest.mark.taichi

TIMES = {"end": 1.0, "samples": [0.4, 1.0]}
CASE = couette(scheme={"type": "implicit"}, time=TIMES, output={"video": None})
VORTICES = {
    "scene": "taylor_green",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.05},
    "geometry": {"length": 1.0},
    "initial": {"velocity": 1.0},
    "discretisation": {"particles_across": 16},
    "time": {"end": 0.2, "samples": [0.2]},
    "output": {"video": None},
    "runtime": {"threads": 1},
}


@pytest.fixture(autouse=True)
def no_other():
    """Let no simulation of another test be open."""
    yield
    gc.collect()


@pytest.fixture(scope="module")
def end_of_run(tmp_path_factory):
    """Folder of the small case, and what is in its last sample."""
    folder = simulation.run(loaded(CASE, {}), tmp_path_factory.mktemp("small") / "out")
    return folder, tisph.open(folder).samples[-1]


def same(state, sample):
    return all(np.array_equal(getattr(state, name), sample[name]) for name in ("x", "y", "u", "v"))


def test_states_at_regular_times_end_with_the_bits_of_tisph_run(end_of_run):
    with tisph.Simulation(CASE) as sim:
        assert sim.state.t == 0.0
        assert not sim.state.u.any()
        with pytest.raises(ValueError, match="read-only"):
            sim.state.u[:] = 1.0
        states = list(sim.every(0.25))
        with pytest.raises(TisphError, match="there is no further step"):
            sim.step()
    assert [state.t for state in states] == [0.25, 0.5, 0.75, 1.0]
    assert same(states[-1], end_of_run[1])
    assert sim.state.error.shape == sim.state.x.shape
    assert sim.state.l2 == tisph.open(end_of_run[0]).summary.samples[-1].l2


@pytest.mark.parametrize("scheme", ["implicit", "wcsph"])
def test_callbacks_come_by_time_and_by_steps_and_change_no_bit(scheme):
    times, steps = [], []
    with tisph.Simulation(CASE, **{"scheme.type": scheme}) as sim:
        sim.on(tisph.every(time=0.1), lambda state: times.append(state.t))
        sim.on(tisph.every(steps=5), lambda state: steps.append(state.step))
        sim.run_until(0.55)
        assert sim.time >= 0.55
        watched = sim.run_until(1.0)
    assert len(times) == 10
    assert max(abs(np.array(times) - np.arange(1, 11) / 10)) < 0.02
    assert steps == list(range(5, watched.step + 1, 5))
    with tisph.Simulation(CASE, **{"scheme.type": scheme}) as alone:
        assert np.array_equal(alone.run_until(1.0).u, watched.u)


def test_results_are_the_files_of_tisph_run(end_of_run, tmp_path):
    sim = tisph.Simulation(CASE)
    sim.results(tmp_path / "mine")
    for _ in range(3):
        sim.step()
    with pytest.raises(TisphError, match="before the first step"):
        sim.results(tmp_path / "other")
    sim.close()
    assert tisph.open(tmp_path / "mine").summary.status == "interrupted"
    sim = tisph.Simulation.restore(tmp_path / "mine" / "checkpoint.h5")
    sim.results(tmp_path / "mine")
    while not sim.finished:
        sim.step()
    whole, mine = (tisph.open(folder) for folder in (end_of_run[0], tmp_path / "mine"))
    assert {path.name for path in mine.folder.iterdir()} - {"checkpoint.h5"} == {p.name for p in whole.folder.iterdir()}
    assert (mine.folder / "history.csv").read_text() == (whole.folder / "history.csv").read_text()
    assert mine.summary.samples == whole.summary.samples
    assert (mine.summary.numbers, mine.summary.momentum) == (whole.summary.numbers, whole.summary.momentum)
    assert all(np.array_equal(a[name], b[name]) for a, b in zip(mine.samples, whole.samples, strict=True) for name in a)


@pytest.mark.parametrize("scheme", ["implicit", "wcsph"])
def test_a_flow_of_functions_is_kept_steady_by_its_force(scheme):
    wave, speed = 2 * np.pi, 0.1

    def velocity(x, y, t):
        return speed * np.sin(wave * y), 0.0

    def force(x, y, t):
        return 0.05 * wave**2 * speed * np.sin(wave * y), 0.0

    given = {"initial_velocity": velocity, "scheme.type": scheme, "time": {"end": 0.1, "samples": [0.1]}}
    with tisph.Simulation(VORTICES, body_force=force, **given) as sim:
        assert sim.state.error is None
        state = sim.run_until(0.1)
    change = np.hypot(state.u - velocity(state.x, state.y, 0.1)[0], state.v)
    assert change.max() < (1e-3 if scheme == "implicit" else 2e-2) * speed
    with tisph.Simulation(VORTICES, **given) as sim:
        state = sim.run_until(0.1)  # without the force it decays
    decayed = speed * np.exp(-0.05 * wave**2 * 0.1)
    assert np.abs(state.u).max() == pytest.approx(decayed, rel=0.03)


def test_a_given_reference_velocity_serves_flow_that_a_force_drives():
    def force(x, y, t):
        return np.sin(2 * np.pi * y), 0.0

    slow = {"initial.velocity": 1e-6}  # by which the flow runs away: the force makes it 3e4 times as fast
    with (
        tisph.Simulation(VORTICES, body_force=force, **slow) as sim,
        pytest.raises(DivergedError, match=r"1000 times the reference velocity.* reference\.velocity, if"),
    ):
        sim.run_until(0.1)
    with tisph.Simulation(VORTICES, body_force=force, **slow, reference={"velocity": 0.1}) as sim:
        state = sim.run_until(0.1)
    rate = 0.05 * (2 * np.pi) ** 2  # u = sin(2 pi y) (1 - exp(-rate t)) / rate
    exact = np.sin(2 * np.pi * state.y) * -np.expm1(-rate * 0.1) / rate
    assert np.abs(state.u - exact).max() < 1e-3 * np.abs(exact).max()  # as of the steady flow above


def test_functions_are_refused_where_nothing_asks_for_them(tmp_path):
    with pytest.raises(ConfigError, match=r"initial_velocity: .* taylor_green and shear_layer"):
        tisph.Simulation(CASE, initial_velocity=lambda x, y, t: (x, y))
    with pytest.raises(ConfigError, match=r"body_force: .* drive\.acceleration"):
        tisph.Simulation(CASE, body_force=lambda x, y, t: (x, y))
    with (
        tisph.Simulation(VORTICES, body_force=lambda x, y, t: (0.0, 0.0)) as sim,
        pytest.raises(ConfigError, match="results: "),
    ):
        sim.results(tmp_path / "out")


def test_two_simulations_at_once_are_refused_and_one_after_the_other_run(end_of_run):
    with tisph.Simulation(CASE) as sim:
        sim.step()
        with pytest.raises(TisphError, match=r"'small' is open, .* close\(\), or use tisph.run"):
            tisph.Simulation(CASE)
        sim.run_until(1.0)
        with tisph.Simulation(CASE) as other:  # a finished one gives way
            assert same(sim.state, end_of_run[1])
            other.step()
    with pytest.raises(TisphError, match="is closed"):
        other.step()


@pytest.fixture
def heeded_interrupts():
    """Ctrl-C raises KeyboardInterrupt, also where what started the tests has it ignored, as ``nohup ... &`` does."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeded_interrupts")
def test_ctrl_c_takes_effect_after_the_step_and_changes_no_bit(end_of_run, monkeypatch):
    with tisph.Simulation(CASE) as sim:
        sim.on(tisph.every(time=0.1), lambda state: times.append(state.t))
        times, advance = [], sim.scheme.advance

        def interrupted():
            signal.raise_signal(signal.SIGINT)
            advance()

        for _ in range(3):
            monkeypatch.setattr(sim.scheme, "advance", interrupted)
            with pytest.raises(KeyboardInterrupt):
                sim.step()
            monkeypatch.setattr(sim.scheme, "advance", advance)
        assert sim.steps == 3
        assert same(sim.run_until(1.0), end_of_run[1])
    assert len(times) == 10


def test_a_program_of_somebody_else_is_refused_and_left_alone():
    runtime.stop()
    ti.init(arch=ti.cpu, log_level=ti.ERROR)
    field = ti.field(ti.i32, 3)
    field.fill(7)
    with pytest.raises(TisphError, match=r"another Taichi program .* ti.reset\(\) .* tisph.run"):
        tisph.Simulation(CASE)
    assert field.to_numpy().tolist() == [7, 7, 7]
    ti.reset()
    with tisph.Simulation(CASE) as sim:
        sim.step()
        ti.init(arch=ti.cpu, log_level=ti.ERROR)
        with pytest.raises(TisphError, match="fields of this simulation are gone"):
            sim.step()
        ti.reset()


def test_times_that_are_over_and_intervals_of_zero_are_refused():
    with tisph.Simulation(CASE) as simulation:
        first = simulation.run_until(0.5 * simulation.config.time.end)
        assert simulation.run_until(first.t).t == first.t
        with pytest.raises(ConfigError, match="is over"):
            simulation.run_until(0.1 * first.t)
        for interval in (0.0, -1.0):
            with pytest.raises(ConfigError, match="positive"):
                next(simulation.every(interval))


def test_a_changed_wall_has_its_reference_and_is_resumed_bitwise(tmp_path):
    """The reference includes the change; a run that has the schedule from the start has errors as small."""
    with tisph.Simulation(CASE) as sim:
        sim.results(tmp_path / "run")
        sim.run_until(0.4)
        sim.set("walls.top.velocity", -0.25)
        begun = sim.time
        state = sim.run_until(0.7)
        sim.save(tmp_path / "checkpoint.h5")
        end = sim.run_until(1.0)
    assert state.u.min() < -0.05  # beside the wall, which moves back
    with tisph.Simulation.restore(tmp_path / "checkpoint.h5") as again:
        assert np.array_equal(again.run_until(1.0).u, end.u)
    run = tisph.open(tmp_path / "run")
    assert (run.config.walls.top.times, run.config.walls.top.velocities) == ((0.0, begun, begun), (0.5, 0.5, -0.25))
    assert run.summary.status == "done"
    assert [sample.t for sample in run.samples] == [0.4, 1.0]
    assert np.array_equal(run.samples[-1].u, end.u)
    assert len(run.history) == end.step + 1  # the start and a line for each step, before and after the change
    with tisph.Simulation(CASE, **{"walls.top": run.config.walls.top.model_dump(exclude_none=True)}) as scheduled:
        assert end.l2 < 1.5 * scheduled.run_until(1.0).l2  # other steps


@pytest.mark.parametrize(
    ("key", "words"),
    [
        (
            "walls.top.velocty",
            "must be one of walls.bottom.velocity, walls.top.velocity, drive.acceleration; nearest: walls.top.velocity",
        ),
        ("fluid.density", "fluid.density cannot be changed in a run; must be one of walls.bottom.velocity"),
    ],
)
def test_other_keys_cannot_be_changed_in_a_run(key, words):
    with tisph.Simulation(CASE) as sim:
        sim.step()
        with pytest.raises(ConfigError, match=words.replace(".", r"\.")):
            sim.set(key, 1.0)
        assert sim.config.walls.top.velocities is None


def test_a_repeated_change_keeps_the_earlier_ones():
    once = changed(loaded(CASE, {}), "walls.top.velocity", 1.0, 0.2)
    twice = changed(once, "walls.top.velocity", 2.0, 0.4)
    assert twice.walls.top.times == (0.0, 0.2, 0.2, 0.4, 0.4)
    assert twice.walls.top.velocities == (0.5, 0.5, 1.0, 1.0, 2.0)
    plate = loaded({**CASE, "walls": {"top": {"shear_stress": 1.0, "mass_per_area": 2.0}}}, {})
    top = changed(plate, "walls.top.shear_stress", 3.0, 0.2).walls.top
    assert (top.times, top.stresses, top.mass_per_area) == ((0.0, 0.2), (1.0, 3.0), 2.0)


THICK = {"density": 1.0, "kinematic_viscosity": 0.1}
OLDROYD_B = {"type": "oldroyd_b", "relaxation_time": 0.5, "solvent_fraction": 0.5}
PIPE = {"scene": "pipe", "geometry": {"radius": 1.0, "length": 1.5}, "drive": {"acceleration": 1.0}}
STREAM = {
    "scene": "channel",
    "geometry": {"gap": 1.0, "length": 1.5},
    "ends": {"left": {"type": "inlet", "velocity": 1.0}, "right": {"type": "outlet"}},
}


@pytest.mark.parametrize(
    ("case", "key", "over"),
    [
        ({**CASE, "fluid": THICK}, "drive.acceleration", 0.0),
        ({**CASE, "fluid": {**THICK, "rheology": OLDROYD_B}}, "drive.acceleration", 0.1),
        (PIPE, "drive.acceleration", 0.0),
        (STREAM, "ends.left.velocity", 0.1),
    ],
)
def test_a_changed_drive_or_inflow_is_resumed_bitwise(tmp_path, case, key, over):
    small = {"fluid": THICK, **case, "discretisation": {"particles_across": 12}, "time": {"end": 0.4}}
    with tisph.Simulation(small) as sim:
        sim.run_until(0.1)
        sim.set(key, 2.0, over)
        begun = sim.time
        sim.run_until(0.25)
        sim.save(tmp_path / "checkpoint.h5")
        end = sim.run_until(0.4)
        section = sim.config.drive if case is not STREAM else sim.config.ends.left
    values = section.velocities if case is STREAM else section.accelerations
    assert (section.times, values[1:]) == ((0.0, begun, begun + over), (values[0], 2.0))
    with tisph.Simulation.restore(tmp_path / "checkpoint.h5") as again:
        assert np.array_equal(again.run_until(0.4).u, end.u)
    if case is not STREAM:
        assert end.l2 < 1e-2  # with 12 particles across; without the change a large part of the velocity is missing


CIRCLE = {
    "scene": "region",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.1},
    "walls": {"around": {"type": "circle", "centre": [0.3, 0.2], "radius": 1.0, "motion": {"angular_velocity": 1.0}}},
    "discretisation": {"particles_across": 20},
    "initial": {"jitter": 0.2},
    "time": {"end": 0.05},
}
CHANNEL = {**CASE, "fluid": CIRCLE["fluid"], "scheme": {"type": "wcsph"}, "discretisation": {"particles_across": 20}}
CHANNEL |= {"time": {"end": 0.1}}


def turning(x, y, t):
    """Rigid rotation with the wall of ``CIRCLE``."""
    return 0.2 - y, x - 0.3


def with_divergence(x, y, t):
    """The same and grad (cos x e^y/2 + x^2/5), whose divergence is 0.4, and which goes through the wall."""
    u, v = turning(x, y, t)
    return u - 0.5 * np.sin(x) * np.exp(y) + 0.4 * x, v + 0.5 * np.cos(x) * np.exp(y)


def test_the_divergence_of_an_initial_velocity_is_removed_and_said_so(capsys):
    with tisph.Simulation(CIRCLE, initial_velocity=with_divergence) as sim:
        state = sim.run_until(0.05)
    u, v = turning(state.x, state.y, 0.05)
    # what is left of a gradient of size 1 after projection by operators of order 4: some (spacing)^4, 1e-4
    assert np.hypot(state.u - u, state.v - v).max() < 1e-3
    assert capsys.readouterr().err.count("the divergence of the initial velocity") == 1


def test_nothing_is_said_of_an_initial_velocity_without_divergence(capsys):
    with tisph.Simulation(CIRCLE, initial_velocity=turning) as sim:
        sim.step()
    assert not capsys.readouterr().err


def test_a_body_force_is_at_places_of_the_config_s_frame():
    """Both walls move at one speed: the flow is the one between walls at rest, as a moving frame sees it."""
    wave, found = 2.0 * np.pi, []
    for speed in (0.0, 0.4):

        def force(x, y, t, speed=speed):
            return np.sin(wave * y) * (1.0 + 0.5 * np.cos(wave * (x - speed * t))), 0.0

        walls = {side: {"velocity": speed} for side in ("bottom", "top")}
        change = {"walls": walls, "initial": {"state": "developed"}, "reference": {"velocity": 0.1}}
        with tisph.Simulation({**CHANNEL, **change}, body_force=force) as sim:
            state = sim.run_until(0.1)
        found.append(np.stack([(state.x - speed * state.t) % 1.0, state.y, state.u - speed]))
    # the same steps but for rounding
    assert np.allclose(*found, atol=1e-9)


def test_a_body_force_on_a_wall_is_refused_by_wcsph():
    with (
        pytest.raises(ConfigError, match="must be 0 on walls"),
        tisph.Simulation({**CHANNEL, "reference": {"velocity": 0.1}}, body_force=lambda x, y, t: (1.0, 0.0)) as sim,
    ):
        sim.step()


def test_a_changed_body_force_acts_from_then_on():
    still = {
        **CIRCLE,
        "walls": {"around": {**CIRCLE["walls"]["around"], "motion": "fixed"}},
        "reference": {"velocity": 1.0},
    }
    with tisph.Simulation(still, body_force=lambda x, y, t: (0.0, 0.0)) as sim:
        sim.step()
        assert np.abs(sim.state.u).max() < 1e-12
        with pytest.raises(ConfigError, match="body_force needs a function"):
            sim.set("body_force", 1.0)
        with pytest.raises(ConfigError, match="must be a number"):
            sim.set("drive.acceleration", turning)
        sim.set("body_force", turning)
        assert np.abs(sim.run_until(0.05).u).max() > 1e-3


@pytest.mark.parametrize(
    ("case", "key", "words"),
    [
        (STREAM, "ends.left.velocity", "give a short ramp"),
        ({**PIPE, "drive": {"amplitude": 1.0, "angular_frequency": 2.0}}, "drive.acceleration", "cannot be changed"),
        (STREAM, "drive.acceleration", "must be left out"),
    ],
)
def test_a_change_that_the_flow_cannot_take_is_refused(case, key, words):
    config = loaded({"fluid": CASE["fluid"], **case, "time": {"end": 1.0}}, {})
    with pytest.raises(ConfigError, match=words):
        changed(config, key, 2.0, 0.2)
