"""``refine: auto``: a first run finds places; the run after it has smaller errors, and resumes without the first."""

import numpy as np
import pytest

import tisph
from tisph import simulation
from tisph.config.loader import load, loaded
from tisph.errors import DivergedError
from tisph.folder import Folder
from tisph.simulation.first_run import FirstRun
from tisph.simulation.process import Interrupts
from tisph.simulation.run import after_first_run

pytestmark = pytest.mark.taichi

ANNULUS = {
    "name": "annulus",
    "scene": "annulus",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.05},
    "geometry": {"inner_radius": 0.3, "outer_radius": 1.3},
    "walls": {"inner": {"angular_velocity": 3.0}, "outer": {"angular_velocity": 0.0}},
    "initial": {"state": "developed", "jitter": 0.2},
    "discretisation": {"particles_across": 12, "refine": "auto"},
    "time": {"end": 0.5},
    "output": {"video": None},
    "runtime": {"threads": 1},
}
"""Steady flow a r + b/r, whose derivatives of degree 5 fall with the sixth power of r."""

FREE = {
    "name": "free",
    "scene": "channel",
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 1.0,
        "rheology": {"type": "oldroyd_b", "relaxation_time": 0.1, "solvent_fraction": 0.5},
    },
    "geometry": {"gap": 1.0, "length": 1.0},
    "walls": {"bottom": {"velocity": -0.5}, "top": {"velocity": 0.5}},
    "bodies": [{"type": "circle", "centre": [0.5, 0.65], "radius": 0.15, "motion": "free"}],
    "initial": {"jitter": 0.2},
    "discretisation": {"particles_across": 20, "refine": "auto"},
    "time": {"end": 0.2},
    "output": {"video": None},
    "runtime": {"threads": 1},
}


def advanced(sim, steps=None):
    while not sim.finished and sim.steps != steps:
        sim.step()
    return sim.state


def error(state, scene):
    """Root mean square, by area, of the error of the velocity."""
    exact = [scene.exact(name, state.x, state.y, state.t) for name in "uv"]
    return np.sqrt(np.mean(state.snapshot.weight * np.square(np.hypot(state.u - exact[0], state.v - exact[1]))))


def same(one, other):
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in ("x", "y", "u", "v", "pressure"))


@pytest.fixture(scope="module")
def refined(tmp_path_factory):
    """The config with the places that were found, the last state, the error, and a checkpoint after ten steps."""
    path = tmp_path_factory.mktemp("refined") / "10.h5"
    with tisph.Simulation(ANNULUS) as sim:
        advanced(sim, 10)
        sim.save(path)
        state = advanced(sim)
        return sim.config, state, error(state, sim.scene), path


def test_errors_are_smaller_than_with_as_many_particles_everywhere(refined):
    _, state, refined_error, _ = refined
    with tisph.Simulation(ANNULUS, **{"discretisation": {"particles_across": 17}}) as sim:
        uniform = advanced(sim)
        assert len(state.x) <= len(uniform.x)
        assert refined_error < 0.8 * error(uniform, sim.scene)  # 0.68 with this seed


def test_the_places_are_in_the_config_and_give_the_same_bits(refined):
    config, state, _, _ = refined
    assert {place.near for place in config.discretisation.refine} == {"walls.inner"}
    with tisph.Simulation(loaded(config.resolved(), {})) as sim:
        assert same(state, advanced(sim))


def test_a_restored_run_has_the_same_bits_without_a_first_run(refined):
    config, state, _, path = refined
    with tisph.Simulation.restore(path, ANNULUS) as sim:
        assert (sim.config, sim.steps) == (config, 10)
        assert same(state, advanced(sim))


def test_a_resumed_folder_keeps_its_places(tmp_path):
    settings = loaded(ANNULUS, {"time": {"end": 0.1}, "output": {"checkpoint_every": 0.05, "video": None}})
    folder = Folder(simulation.run(settings, tmp_path, pictures=False, video=False))
    places = load(folder.config).discretisation.refine
    assert places[0].near == "walls.inner"
    simulation.run(settings, tmp_path, pictures=False, video=False, resume=True)
    assert load(folder.config).discretisation.refine == places
    assert folder.log.read_text(encoding="utf-8").count("places from a first run") == 1


def test_particles_in_a_polymer_are_closer_where_a_free_body_has_come():
    with tisph.Simulation(FREE) as sim:
        state, spacing = advanced(sim), sim.scene.spacing
    assert "bodies.0" in {place.near for place in sim.config.discretisation.refine}
    centre, width = state.snapshot.bodies.centre[0], state.snapshot.widths(spacing)
    assert np.hypot(*(centre - [0.5, 0.65])) > 0.3 * spacing
    away = np.hypot(state.x - centre[0], state.y - centre[1]) - 0.15
    assert width[away < 0.5 * spacing].max() < 0.8 * spacing


def test_the_end_counts_where_no_sample_comes_after_the_start():
    assert FirstRun(loaded(ANNULUS, {"time.samples": [0.0]})).schedule.times == [0.5]


def test_an_interrupt_ends_the_first_run_and_frees_the_process():
    interrupts = Interrupts()
    interrupts.count = 1
    with pytest.raises(KeyboardInterrupt):
        after_first_run(loaded(ANNULUS, {}), interrupts)
    with tisph.Simulation(ANNULUS, **{"discretisation": {"particles_across": 12}}) as sim:
        sim.step()


def test_a_first_run_that_diverges_is_named(monkeypatch):
    def diverge(*_):
        raise DivergedError("t = 0.1: u is not a finite number")

    monkeypatch.setattr(tisph.Simulation, "step", diverge)
    with pytest.raises(DivergedError, match=r"the first run of discretisation\.refine: t = 0\.1: u is not"):
        after_first_run(loaded(ANNULUS, {}), Interrupts())
