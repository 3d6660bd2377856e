"""The annulus with polymer: its reference in Cartesian components and the config's units, and measures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import make_annulus

from tisph import registry
from tisph.geometry.motion import WallMotion
from tisph.snapshot import STRESSES, Snapshot

CENTRE, DENSITY = (0.4, -0.3), 2.0
TIME = 0.7


@pytest.fixture(scope="module")
def annulus():
    """Giesekus liquid, whose stresses are all other than 0, in flow that still changes."""
    numbers = {"relaxation_time": 0.6, "solvent_fraction": 0.3, "mobility": 0.3}
    return make_annulus(
        centre=CENTRE,
        outer=WallMotion(-0.3),
        density=DENSITY,
        kinematic_viscosity=0.5,
        rheology=registry.load("rheology", "giesekus").Parameters(**numbers),
    )


def slopes(of, x, y, step=2e-3):
    """d/dx and d/dy of fields by differences of fourth order."""
    ends = step * np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12 * step)
    return [
        sum(w * of(x + dx, y + dy) for w, dx, dy in zip(weights, *way, strict=True))
        for way in ((ends, 0 * ends), (0 * ends, ends))
    ]


def test_momentum_is_balanced_in_cartesian_components(annulus):
    """d(rho u)/dt + rho u.grad u = -grad p + div S + solvent viscosity lap u, away from any axis."""
    angle, radius = np.array([0.3, 2.0, 4.5]), np.array([1.2, 1.5, 1.8])
    x, y = CENTRE[0] + radius * np.cos(angle), CENTRE[1] + radius * np.sin(angle)

    def field(name, t=TIME):
        return lambda x, y: annulus.exact(name, x, y, t)

    def slope(name, axis):
        return lambda x, y: slopes(field(name), x, y)[axis]

    stress = {name: slopes(field(name), x, y) for name in STRESSES}
    pressure = slopes(field("pressure"), x, y)
    divergence = [stress["stress_xx"][0] + stress["stress_xy"][1], stress["stress_xy"][0] + stress["stress_yy"][1]]
    largest = np.abs(divergence).max()
    for axis, name in enumerate("uv"):
        gradient = slopes(field(name), x, y)
        laplacian = sum(slopes(slope(name, axis), x, y)[axis] for axis in range(2))
        carried = field("u")(x, y) * gradient[0] + field("v")(x, y) * gradient[1]
        step = 1e-3
        change = (field(name, TIME + step)(x, y) - field(name, TIME - step)(x, y)) / (2 * step)
        left = DENSITY * (change + carried) + pressure[axis]
        # what is left of differences in time, of second order
        assert np.abs(left - divergence[axis] - DENSITY * 0.3 * 0.5 * laplacian).max() < 1e-5 * largest


def test_torques_have_the_units_of_the_config(annulus):
    """They change the angular momentum, int 2 pi rho u r^2 dr, of the liquid."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    r, step = 1.5 + 0.5 * nodes, 1e-3
    momentum = [
        np.pi * DENSITY * np.sum(weights * r**2 * annulus.exact_around(CENTRE[0] + r, CENTRE[1], TIME + dt))
        for dt in (-step, step)
    ]
    torques = annulus.exact_torques(TIME)
    assert (momentum[1] - momentum[0]) / (2 * step) == pytest.approx(-sum(torques), abs=1e-4 * abs(torques[0]))


def exact_snapshot(annulus, t):
    x, y = annulus.jittered(0, 0.2)
    fields = {name: annulus.exact(name, x, y, t) for name in annulus.fields}
    bodies = SimpleNamespace(torque=np.array(annulus.exact_torques(t)))
    return Snapshot(t=t, step=1, x=x, y=y, density=np.full(len(x), DENSITY), bodies=bodies, **fields)


def test_measures_of_exact_fields_and_of_wrong_ones(annulus):
    snapshot = exact_snapshot(annulus, TIME)
    diagnostics = annulus.diagnostics(snapshot, None)
    assert max(diagnostics[f"{name}_stress_l2"] for name in ("shear", "normal")) < 1e-13
    assert diagnostics["torque_inner"] == diagnostics["torque_inner_exact"]
    off = annulus.diagnostics(replace(snapshot, **{name: 1.1 * getattr(snapshot, name) for name in STRESSES}), None)
    assert [off[f"{name}_stress_l2"] for name in ("shear", "normal")] == pytest.approx([0.1, 0.1])
    for profile in annulus.profiles():
        found, expected = profile.of(snapshot), profile.exact(snapshot.x, snapshot.y, TIME)
        assert np.allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_history_has_the_normal_stress_at_both_cylinders(annulus):
    extra_series, times = annulus.extra_series, np.array([0.0, 0.3, TIME])
    assert extra_series.columns == ["n1_inner", "n1_outer"]
    exact = extra_series.final(times, None)
    assert exact.shape == (3, 2)
    for place, column in zip((1.0, 2.0), exact.T, strict=True):
        stress = [annulus.exact(name, CENTRE[0], CENTRE[1] - place, times) for name in STRESSES]
        assert column == pytest.approx(stress[0] - stress[2], rel=1e-12)  # below the axis x is around it
    before = SimpleNamespace(bodies=SimpleNamespace(normal_stress=None))
    assert np.isnan(extra_series.measure(before)).all()
    assert make_annulus().extra_series is None


def test_a_start_from_rest_has_no_stress(annulus):
    x, y = annulus.jittered(0, 0.2)
    fields = annulus.initial(x, y)
    assert set(fields) == {"u", "v", *STRESSES}
    assert not any(values.any() for values in fields.values())
    view = annulus.movie_view("shear_stress", 2.0)
    assert view.signed
    assert view.ends[0] < 0
    assert set(STRESSES) <= {"stress_xy", *annulus.movie_fields("shear_stress")}
    assert "stress_xx" not in make_annulus().fields


def test_a_developed_start_knows_what_each_mode_remembers():
    modes = [
        {"relaxation_time": 1.0, "fraction": 0.6},
        {"type": "fene_p", "relaxation_time": 0.2, "maximum_extension": 9.0, "fraction": 0.3},
    ]
    rheology = registry.load("rheology", "multi_mode").Parameters(solvent_fraction=0.1, modes=modes)
    annulus = make_annulus(centre=CENTRE, kinematic_viscosity=0.5, rheology=rheology, initial_state="developed")
    x, y = annulus.jittered(0, 0.2)
    laws = zip(rheology.laws(0.5), annulus.initial_conformation_excess(x, y), strict=True)
    found = sum(np.stack(law.stress(conformation_excess)[:3]) for law, conformation_excess in laws)
    exact = annulus.initial(x, y)
    for part, name in zip(found, STRESSES, strict=True):
        assert np.allclose(part, exact[name], rtol=0, atol=1e-13)
    assert make_annulus(rheology=rheology).initial_conformation_excess is None  # at rest


def test_the_layer_at_a_wall_is_the_solvents_at_first(annulus):
    depth, place = annulus.thinnest_layer(1e-4)[:2]
    assert depth == pytest.approx(np.sqrt(0.3 * 0.5e-4), rel=1e-3)
    assert place == "the layer at the inner cylinder"
