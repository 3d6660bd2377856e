"""Open ends of a channel: flows through both, particles that leave and enter, steps that are taken back."""

from dataclasses import replace

import numpy as np
import pytest
from finished_run import finished
from flows import flow_config

import tisph
from tisph.config.loader import loaded
from tisph.runtime import view

pytestmark = pytest.mark.taichi

INLET, OUTLET = {"type": "inlet", "velocity": 1.0}, {"type": "outlet"}
CHANNEL = flow_config("open_channel")
OF_STEPS = 2e-5
"""Velocities of a parabola and their viscous force are exact with operators of order 4. What remains are the residuals
of the linear systems and the errors of steps, 2e-6 of the velocity each (``step_limits``), ten times over."""


def changed(**sections):
    return {**CHANNEL, **sections}


def parabola(y):
    return 6.0 * y * (1.0 - y)


@pytest.mark.parametrize(
    "fluid",
    [{}, {"kinematic_viscosity": 20.0}, {"inertia": False, "kinematic_viscosity": 1.0}],
    ids=["splitting", "together", "without inertia"],
)
def test_poiseuille_flow_leaves_as_it_came(fluid):
    fluid = CHANNEL["fluid"] | fluid
    initial = {"state": "rest"} if fluid["kinematic_viscosity"] == 1.0 else CHANNEL["initial"]
    _, snapshot, found = finished(changed(fluid=fluid, initial=initial))
    drop = 12.0 * fluid["kinematic_viscosity"] * 2.0
    assert np.abs(snapshot.u - parabola(snapshot.y)).max() < OF_STEPS
    assert np.abs(snapshot.v).max() < OF_STEPS
    assert found["pressure_drop"] == pytest.approx(drop, rel=1e-4)  # the wall shear follows from it
    assert abs(found["mass_imbalance"]) < OF_STEPS
    assert snapshot.passages.sum() > len(snapshot.x) / 2  # 1.6 of a length of 2 have passed


def test_the_longest_steps_are_stable_at_the_inlet():
    """With a Courant number of 2 the error is 3e-3 here."""
    config = changed(
        fluid={"density": 1.0, "kinematic_viscosity": 0.002},
        geometry={"gap": 1.0, "length": 1.0},
        scheme={"accuracy": "fast"},
        discretisation={"particles_across": 24},
        time={"end": 3.0},
    )
    _, snapshot, _ = finished(config)
    assert np.abs(snapshot.u - parabola(snapshot.y)).max() < OF_STEPS


def test_an_inlet_on_the_right_is_its_mirror_image():
    _, snapshot, found = finished(changed(ends={"left": OUTLET, "right": INLET}, time={"end": 0.4}))
    assert np.abs(snapshot.u + parabola(snapshot.y)).max() < OF_STEPS
    assert found["inflow"] == pytest.approx(1.0) == found["outflow"]


HEIGHTS = np.linspace(0.0, 1.0, 21)
BLUNT = {"heights": HEIGHTS.tolist(), "velocities": (1.0 - (2.0 * HEIGHTS - 1.0) ** 6).tolist()}


@pytest.mark.parametrize(("length", "courant"), [(1.5, 0.6), (3.0, 0.3)])
def test_pressure_does_not_scatter_behind_a_blunt_inlet(length, courant):
    """Whatever length and step: noise of the divergence alone makes it grow with the length and as 1/dt."""
    config = changed(
        fluid={"density": 1.0, "kinematic_viscosity": 0.02},
        geometry={"gap": 1.0, "length": length},
        ends={"left": {**INLET, "profile": BLUNT}, "right": OUTLET},
        initial={"state": "rest"},
        discretisation={"particles_across": 16},
        time={"end": 1.0, "cfl": courant},
    )
    drops = []
    with tisph.Simulation(config) as simulation:
        boundary, levels = simulation.scheme.boundary, simulation.scheme.levels
        while not simulation.finished:
            simulation.step()
            if simulation.time > 0.6:
                pressure = view(levels.fields)[boundary.slots, levels.first_pressure].astype(float)
                ends = boundary.parts[-1]
                drops.append(pressure[ends.of_inlets].mean() - pressure[ends.of_outlet].mean())
    middle = np.array(drops[1:-1]) - 0.5 * (np.array(drops[:-2]) + drops[2:])
    # 0.010 and 0.018 of the mean, since the layer of the inlet is 2.7 spacings thin here; 0.20 to 0.27 without control
    assert middle.std() / np.sqrt(1.5) < 0.03 * np.mean(drops)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "across", "end"),
    [
        ("backward_step", 24, 1.6),
        ("contraction", 48, 0.15),
        ("cylinder_in_stream", 32, 1.2),
        ("oldroyd_b_cylinder_in_stream", 20, 0.4),
    ],
)
def test_columns_of_the_history_do_not_scatter_or_a_sample_says_so(name, across, end):
    """In the last tenth of a run, beside a cubic; forces are relative to the largest of them."""
    changes = {"discretisation.particles_across": across, "time.end": end, "time.samples": [end], "runtime.threads": 1}
    lines = []
    with tisph.Simulation(loaded(f"configs/{name}.yaml", changes)) as simulation:
        scene, scheme = simulation.scene, simulation.scheme
        series = scene.time_series()
        while not simulation.finished:
            simulation.step()
            lines.append([scheme.time, *series.measure(scheme.snapshot())])
        resolved, _ = tisph.measures.resolution.resolution(scene, end, scheme.snapshot())
    times, values = np.split(np.array(lines), [1], axis=1)
    last = -max(12, np.count_nonzero(times >= 0.9 * end))
    time, values = (times[last:, 0] - end) / end, values[last:]
    beside = values - np.stack([np.polyval(np.polyfit(time, column, 3), time) for column in values.T], axis=1)
    force = np.array([column.startswith(("drag", "lift")) for column in series.columns])
    size = np.abs(values).max(axis=0)
    size[force] = size[force].max()
    scatter = beside.std(axis=0) * np.sqrt(len(time) / (len(time) - 4))
    assert not resolved or (scatter <= 0.01 * size).all(), dict(zip(series.columns, scatter / size, strict=True))


def test_faults_of_the_flow_through_ends_are_said():
    with tisph.Simulation(changed(time={"end": 0.2})) as simulation:
        snapshot = simulation.run_until(0.2).snapshot
        resolution = tisph.measures.resolution.resolution
        number = len(simulation.scene.bodies) - 2
        small = replace(snapshot, load_scatter=(0.009, number), flow_rates=np.array([1.0, -0.991]))
        assert resolution(simulation.scene, 0.2, small) == (True, None)
        for change, words in (
            ({"load_scatter": (0.02, number)}, "the pressure at the inlet scatters"),
            ({"flow_rates": np.array([1.0, -0.98])}, "flow rates through inlet and outlet differ by 0.02"),
        ):
            resolved, reason = resolution(simulation.scene, 0.2, replace(snapshot, **change))
            assert not resolved
            assert words in reason
        boundary, levels, problem = (getattr(simulation.scheme, name) for name in ("boundary", "levels", "problem"))
        inner = boundary.positions[: problem.n_fluid, 0] < problem.open_ends[0] + 1.0
        view(levels.divergence)[: len(inner)] = 0.1 * inner
        boundary.parts[-1].measure_parts()
        # in the half that is as long as the inlet is wide; over the channel it is 2^(1/2) smaller. Of 144 particles
        assert boundary.residual(0.0) == pytest.approx(0.1 / np.sqrt(12.0), rel=0.05)


def test_particles_pass_evenly_and_as_many_as_flow_in():
    counts, steps, columns = np.zeros(24), 0, np.linspace(0.0, 2.0, 25)
    with tisph.Simulation(changed(time={"end": 5.0, "cfl": 0.3})) as simulation:
        scene, particles = simulation.scene, simulation.scene.particles
        while not simulation.finished:
            simulation.step()
            assert len(simulation.state.x) == particles
            if simulation.time > 1.0:
                counts, steps = counts + np.histogram(simulation.state.x, columns)[0], steps + 1
        ends = simulation.scheme.boundary.parts[-1]
        entered, due = ends.levels.passages.sum(), ends.due.sum() - 0.5 * len(ends.due)  # at first half a particle
    middles = (np.arange(12) + 0.5) / 12
    assert entered + due == pytest.approx(5.0 * parabola(middles).sum() / 12 / scene.spacing**2, rel=1e-9)  # rounding
    density = counts / steps * scene.spacing**2 / (columns[1] * 1.0)
    # a spacing is even to 1 % where the density, that of a few hundred particles, is to 2 %; a column may be half empty
    # beside an end, from which particles keep their distance
    inner = density[2:-2]
    assert inner.mean() == pytest.approx(1.0, abs=0.02)
    assert np.abs(inner.reshape(-1, 4).mean(axis=1) / inner.mean() - 1.0).max() < 0.02


def test_a_rejected_step_leaves_no_trace():
    with tisph.Simulation(CHANNEL) as simulation:
        scheme, boundary, ends = simulation.scheme, simulation.scheme.boundary, simulation.scheme.boundary.parts[-1]
        while not (simulation.finished or ends.levels.passages.any()):
            simulation.step()

        def state():
            fields = [view(field)[: scheme.problem.n_fluid].copy() for field in boundary.carried_fields]
            return [*fields, ends.due.copy(), ends.levels.passages.copy()]

        before = state()
        scheme.attempt(0.05)  # in which the fastest fluid passes half a spacing
        assert len(ends.replaced[0])
        boundary.reject()
        for one, other in zip(before, state(), strict=True):
            np.testing.assert_array_equal(one, other)


def test_particles_that_jump_to_the_inlet_have_passed_whatever_their_order():
    with tisph.Simulation(changed(geometry={"gap": 1.0, "length": 1.0}, time={"end": 0.2})) as simulation:
        simulation.begin()
        scheme = simulation.scheme
        before, order = scheme.snapshot(), view(scheme.levels.number)
        while not simulation.finished:
            simulation.step()
            scheme.levels.reorder()
            scheme.output_cache = None
            after = scheme.snapshot()
            assert np.array_equal(after.passages - before.passages, after.x - before.x < -0.5)
            before = after
    assert before.passages.sum() > 10
    assert (np.diff(order[: len(before.x)]) < 0).any()  # particles are stored in another order


def test_overdue_inflow_takes_the_particle_that_leaves_next():
    """Not the one that is nearest to the outlet: near a wall its place would stay empty for long."""
    with tisph.Simulation(CHANNEL) as simulation:
        boundary = simulation.scheme.boundary
        fluid, width = simulation.scheme.problem.n_fluid, simulation.scene.spacing
        nearest_too = []
        while simulation.time < 0.8:
            simulation.step()
            place, velocity = boundary.positions[:fluid] + boundary.walls.origin, boundary.newest_velocities[:fluid, 0]
            away = (2.0 - place[:, 0]) / width
            if away.min() < 0.3:
                continue
            next_one, ends = np.argmin((away - 0.3) / velocity), boundary.parts[-1]
            ends.due[...] = 0.0
            ends.due[3] = 1.5
            ends.exchange(0.0, simulation.time)
            np.testing.assert_array_equal(ends.replaced[0], [next_one] if away[next_one] < 1.3 else [])
            nearest_too.append(next_one == np.argmin(away))
        assert not all(nearest_too)


def test_particles_are_within_the_ends_at_every_time_of_a_step():
    with tisph.Simulation(changed(time={"end": 1.0})) as simulation:
        while not simulation.finished:
            before = simulation.time
            simulation.step()
            for part in (0.25, 0.75):
                x = simulation.scheme.snapshot(before + part * (simulation.time - before)).x
                assert 0.0 <= x.min() <= x.max() <= 2.0


def test_backflow_through_the_outlet_is_said():
    inlet = {"type": "inlet", "velocity": 1.0, "amplitude": 1.0, "angular_frequency": 6.0}
    scene, snapshot, found = finished(changed(ends={"left": inlet, "right": OUTLET}, time={"end": 0.5236}))
    flow = -scene.inlet.velocity(scene.bodies[-1].boundary_points(scene.spacing).point, 0.5236)[:, 0]
    assert found["backflow"] == pytest.approx(flow.max() / 2.0, abs=0.02)  # near walls where the mean is 0; 12 across
    assert found["backflow"] > 0.02
    resolved, reason = tisph.measures.resolution.resolution(scene, snapshot.t, snapshot)
    assert not resolved
    assert "flows in through the outlet" in reason


def test_the_outlets_rows_are_exact_for_a_polynomial_of_degree_4():
    """Of a flow without divergence and with dv/dx = 0 at the outlet, whose slope du/dx = -dv/dy is not 0 there."""
    with tisph.Simulation(CHANNEL) as simulation:
        for _ in range(2):
            simulation.step()
        scheme, boundary, points = simulation.scheme, simulation.scheme.boundary, simulation.scheme.problem.particles
        scheme.attempt(scheme.control.dt_next)  # operators at the places of the end of a step
        velocity, at_outlet = scheme.equations.velocity, slice(boundary.parts[-1].first, points)
        x, y = boundary.positions.T
        x = x - x[boundary.parts[-1].first]
        slope = 2.0 - 2.0 * y + 3.0 * y**2
        u = 1.0 - 2.0 * y + 4.0 * y**3 + slope * x + 2.0 * y * x**3
        v = -(2.0 * y - y**2 + y**3 + 3.0 * y**2 * x**2)
        view(velocity.x)[:points] = np.stack([u, v], axis=1)
        sigma = float(velocity.sigma[None])
        boundary.add_normal_momentum(scheme.equations, 0.01, sigma, 0.05)
        velocity.start()
        rounding = 1e-11  # of double precision, some hundred times over
        assert np.abs(view(velocity.residual)[at_outlet] / sigma).max() < rounding
        assert view(scheme.equations.pressure.x)[at_outlet] == pytest.approx(0.05 * slope[at_outlet], abs=rounding)
