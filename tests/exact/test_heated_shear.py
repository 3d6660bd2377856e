"""Flow with a viscosity that depends on temperature: printed values, closed forms, and balances of energy."""

import numpy as np
import pytest
from printed import matches

from tisph.errors import UnsolvedError
from tisph.exact import couette
from tisph.exact.heat import CircularHeating, Conduction, ExponentialCouette, PipeHeating
from tisph.exact.heat import Wall as ThermalWall
from tisph.exact.heated_shear import HeatedShear, StartUp, Wall

QUARTERS = np.array([0.25, 0.5, 0.75])
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
COLD = Wall(0.0)


def exponential(temperature, rate):
    return np.exp(-temperature)


def constant(temperature, rate):
    return 1.0


@pytest.mark.parametrize(
    ("flow", "velocity", "temperature", "stress"),
    [
        (
            HeatedShear((0, 1), (Wall(1.0), Wall(1.0, speed=1.0)), lambda T, g: np.exp(5 * (1 / T - 1)), 1 / 0.4),
            "0.23677349, 0.5, 0.76322651",
            "1.0332809, 1.0447652, 1.0332809",
            "0.86494207",
        ),
        (
            HeatedShear((0, 1), (COLD, COLD), exponential, 1.0, pressure_gradient=8.0),
            "0.98761253, 1.3907711, 0.98761253",
            "0.45536377, 0.48909474, 0.45536377",
            "4.0000000",
        ),
        (
            HeatedShear((0, 1), (COLD, Wall(1.0, speed=1.0)), exponential, 1.0, heating=False),
            "0.16529618, 0.37754067, 0.65006799",
            "0.25000000, 0.50000000, 0.75000000",
            "0.58197671",
        ),
        (
            HeatedShear((0, 1), (Wall(-0.5), Wall(0.5)), exponential, 1.0, buoyancy=1.0, heating=False),
            "-0.0048145533, 0.0025406688, 0.011615521",
            "-0.25000000, 0.00000000, 0.25000000",
            None,
        ),
    ],
    ids=["Arrhenius", "Poiseuille", "hot wall", "vertical channel"],
)
def test_steady_flow_between_plates_has_the_printed_values(flow, velocity, temperature, stress):
    """shared/reference/slip_layers_heat.md, section 3: Other laws, and vertical channel."""
    found = flow.steady()
    assert matches(found.velocity(QUARTERS), velocity)
    assert matches(found.temperature(QUARTERS), temperature)
    if stress:
        assert matches(found.shear_stress(0.0), stress)
    else:
        assert matches(0.5 * WEIGHTS @ found.velocity(0.5 + 0.5 * NODES), "0.0027621189")


def test_steady_flow_between_cylinders_has_the_printed_values():
    """shared/reference/slip_layers_heat.md, section 3: torque 10 on the inner cylinder; also with twice the radii.

    There half the stress, twice the torque, has the same velocities and temperatures.
    """
    for size in (1.0, 2.0):
        walls = Wall(0.0, speed=None, stress=10.0 / (2 * np.pi) / size), COLD
        found = HeatedShear((size, 2 * size), walls, exponential, 1.0, geometry="around").steady()
        assert matches(found.velocity(size), "0.63203275")
        assert matches(found.velocity(size * (1 + QUARTERS)), "0.4149167, 0.24398624, 0.10929819")
        assert matches(found.temperature(size * (1 + QUARTERS)), "0.080563263, 0.079438775, 0.045995028")
        torque = -2 * np.pi * (2 * size) ** 2 * found.shear_stress(2 * size)
        assert torque == pytest.approx(10.0 * size, rel=1e-11)


@pytest.mark.parametrize(
    ("time", "velocity", "temperature"),
    [
        (0.1, "0.025397829, 0.10242111, 0.34419126", "0.005397094, 0.046588607, 0.20367133"),
        (0.3, "0.16114474, 0.3876152, 0.69872953", "0.21233882, 0.37786409, 0.37099065"),
        (1.0, "0.21909776, 0.49865074, 0.77926476", "0.35497105, 0.48415153, 0.35678316"),
    ],
)
def test_start_up_of_a_ramped_wall_has_the_printed_values(time, velocity, temperature):
    """shared/reference/slip_layers_heat.md, section 3: Start-up with heating, Pr = 2, Br = 5, "digits to 2e-9"."""
    ramp = Wall(0.0, speed=lambda t: min(t / 0.1, 1.0))
    found = StartUp(HeatedShear((0, 1), (COLD, ramp), exponential, 0.2, heat_capacity=0.4), breaks=[0.1]).at(time)
    assert matches(found.velocity(QUARTERS), velocity, 2e-9)
    assert matches(found.temperature(QUARTERS), temperature, 2e-9)


@pytest.mark.parametrize(
    ("time", "velocity", "temperature"),
    [
        (0.02, "-0.0022821409, -0.0016817031, -0.00050817731", "-0.33669228, -0.14531962, -0.040233857"),
        (0.1, "-0.0057292972, -0.0073519536, -0.0037292981", "-0.39928015, -0.24877531, -0.099280147"),
        (0.5, "-0.006000000, -0.0078124999, -0.0040000000", "-0.4000000, -0.2500000, -0.1000000"),
    ],
)
def test_start_up_of_a_vertical_channel_has_the_printed_values(time, velocity, temperature):
    """shared/reference/slip_layers_heat.md, section 3: Buoyancy, Pr = 0.71."""
    flow = HeatedShear((0, 1), (Wall(-0.5), Wall(0.5)), constant, 1 / 0.71, buoyancy=1.0, heating=False)
    found, y = StartUp(flow).at(time), np.array([0.1, 0.25, 0.4])
    assert matches(found.velocity(y), velocity)
    assert matches(found.temperature(y), temperature)
    steady = flow.steady()
    assert steady.velocity(y) == pytest.approx(-(y**3 / 6 - y**2 / 4 + y / 12), abs=1e-13)


@pytest.mark.parametrize("nahme", [1.0, 20.0, 2000.0])
def test_exponential_couette_flow_is_the_closed_form(nahme):
    """Given speed, in units with a gap of 2, mu0 3, k 5, a 0.1 and T0 300; and its stress, on the cold branch."""
    closed = ExponentialCouette(2.0, 3.0, 5.0, 0.1, np.sqrt(nahme * 5.0 / 0.3), 300.0)
    law, y = (lambda T, g: 3.0 * np.exp(-0.1 * (T - 300.0))), np.linspace(0.0, 2.0, 41)
    found = HeatedShear((0, 2), (Wall(300.0), Wall(300.0, speed=closed.speed)), law, 5.0).steady()
    assert found.velocity(y) == pytest.approx(closed.velocity(y), abs=1e-11 * closed.speed)
    assert found.temperature(y) == pytest.approx(closed.temperature(y), abs=1e-10)
    # elements of a fourth of the gap do not resolve the hot core at Na = 2000 as well
    assert found.shear_stress(y) == pytest.approx(closed.stress, rel=1e-10 if nahme < 100 else 1e-8)
    assert found.heat_flux(2.0) == pytest.approx(closed.heat_flux(2.0), rel=1e-10)
    if nahme < 18.2:
        pulled = HeatedShear((0, 2), (Wall(300.0), Wall(300.0, speed=None, stress=closed.stress)), law, 5.0)
        assert pulled.steady().velocity(2.0) == pytest.approx(closed.speed, rel=1e-10)


def test_no_steady_flow_above_the_largest_stress():
    flow = HeatedShear((0, 1), (COLD, Wall(0.0, speed=None, stress=np.sqrt(3.52))), exponential, 1.0)
    with pytest.raises(UnsolvedError, match="no steady flow"):
        flow.steady()


def test_flow_of_one_viscosity_is_the_closed_form_in_each_geometry():
    # fluxes: a round-off of 1e-16 over the first distance of two nodes at a wall, 2e-5 of the gap, times k T
    r = np.linspace(0.0, 2.0, 9)
    pipe = HeatedShear(
        (0, 2), (COLD, Wall(1.0)), lambda T, g: 3.0, 0.4, pressure_gradient=5.0, geometry="along"
    ).steady()
    closed = PipeHeating(2.0, 3.0, 0.4, 5.0, 1.0)
    for name in ("velocity", "temperature", "heat_flux"):
        assert getattr(pipe, name)(r) == pytest.approx(getattr(closed, name)(r), abs=1e-10)
    walls = Wall(1.0, speed=0.7), Wall(-2.0, speed=-0.4)
    around = HeatedShear((0.5, 2), walls, lambda T, g: 3.0, 0.4, geometry="around").steady()
    circular = CircularHeating((0.5, 2.0), (1.4, -0.2), 3.0, 0.4, (1.0, -2.0))
    for name in ("velocity", "temperature", "heat_flux"):
        assert getattr(around, name)(r[2:]) == pytest.approx(getattr(circular, name)(r[2:]), abs=1e-11)


def test_power_law_flow_in_a_pipe_is_the_closed_form():
    """mu = (e + g^2)^((n - 1)/2), n = 2 and e small, hence u = 2/3 (G/2)^(1/2) (R^1.5 - r^1.5), shear-thickening."""
    flow = HeatedShear(
        (0, 1), (COLD, COLD), lambda T, g: np.sqrt(1e-8 + g * g), 1.0, pressure_gradient=2.0, geometry="along"
    )
    r = np.array([0.0, 0.25, 0.5, 1.0])
    assert flow.steady().velocity(r) == pytest.approx(2 / 3 * (1 - r**1.5), abs=1e-4)


def test_start_up_without_heating_is_that_of_conduction_and_of_couette_flow():
    """Both fields of one equation each: T by ``heat``, u by ``couette``; an insulated and a stress-free wall, too."""
    flow = HeatedShear((0, 1), (Wall(2.0, speed=0.5), Wall(3.0, speed=1.0)), lambda T, g: 0.5, 0.7, heating=False)
    found, y = StartUp(flow, initial=1.0), np.linspace(0.0, 1.0, 21)
    heat = Conduction((0.0, 1.0), (ThermalWall(2.0), ThermalWall(3.0)), 0.7, initial=1.0)
    unit = {"gap": 1.0, "kinematic_viscosity": 0.5, "bottom": 0.5, "top": 1.0}
    for time in (1e-3, 0.03, 0.4):
        assert found.at(time).temperature(y) == pytest.approx(heat.temperature(y, time), abs=1e-9)
        assert found.at(time).velocity(y) == pytest.approx(couette.velocity(y, time, **unit), abs=1e-9)
    walls = Wall(heat_flux=0.6, speed=None, stress=0.3), Wall(3.0)
    free = HeatedShear((0.4, 1.4), walls, lambda T, g: 0.7, 0.7, heating=False, geometry="along")
    found, r = StartUp(free).at(0.2), 0.4 + y
    heat = Conduction((0.4, 1.4), (ThermalWall(heat_flux=0.6), ThermalWall(3.0)), 0.7, 0.7, cylindrical=True)
    pull = Conduction((0.4, 1.4), (ThermalWall(heat_flux=0.3), ThermalWall(0.0)), 0.7, 0.7, cylindrical=True)
    assert found.temperature(r) == pytest.approx(heat.temperature(r, 0.2), abs=1e-9)
    assert found.velocity(r) == pytest.approx(pull.temperature(r, 0.2), abs=1e-9)


def test_a_late_pulse_of_a_wall_is_not_stepped_over():
    """Start-up of plane Couette flow at 4, minus start-up at 4.01; without its breaks the flow would stay at rest."""
    pulse = Wall(speed=lambda t: 1.0 if 4.0 < t <= 4.01 else 0.0)
    found = StartUp(HeatedShear((0, 1), (COLD, pulse), constant, 1.0, heating=False), breaks=[4.0, 4.01])
    y, unit = np.linspace(0.0, 1.0, 21), {"gap": 1.0, "kinematic_viscosity": 1.0, "bottom": 0.0, "top": 1.0}
    assert found.at(4.005).velocity(y) == pytest.approx(couette.velocity(y, 0.005, **unit), abs=1e-9)
    expected = couette.velocity(y, 0.1, **unit) - couette.velocity(y, 0.09, **unit)
    assert found.at(4.1).velocity(y) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("geometry", ["plates", "along", "around"])
def test_energy_of_an_insulated_start_up_is_the_work_of_the_wall(geometry):
    """d/dt of the integral of rho u^2/2 + rho c T is the stress times the speed of the wall; Gauss's quadrature."""
    pull = Wall(speed=None, stress=0.8)
    flow = HeatedShear((1, 2), (pull, Wall()), exponential, 0.3, 1.5, 0.4, geometry=geometry)
    found, y = StartUp(flow), 1.5 + 0.5 * NODES
    area = np.ones_like(y) if geometry == "plates" else y

    def energy(time):
        fields = found.at(time)
        return 0.5 * WEIGHTS @ (area * 1.5 * (fields.velocity(y) ** 2 / 2 + 0.4 * fields.temperature(y)))

    times = 0.3 + 0.2 * NODES
    work = 0.2 * WEIGHTS @ np.array([0.8 * found.at(time).velocity(1.0) for time in times])
    assert energy(0.5) - energy(0.1) == pytest.approx(work, rel=1e-9)


def test_a_late_start_up_is_the_steady_flow():
    """In a pipe of a shear-thinning fluid, heated by a hot wall and by dissipation."""

    def law(temperature, rate):
        return np.exp(-temperature) * (1 + rate**2) ** -0.25

    flow = HeatedShear((0, 1), (COLD, Wall(1.0)), law, 1.0, pressure_gradient=1.0, geometry="along")
    r, late, steady = np.linspace(0.0, 1.0, 5), StartUp(flow).at(60.0), flow.steady()
    for name in ("velocity", "temperature", "shear_stress"):
        assert getattr(late, name)(r) == pytest.approx(getattr(steady, name)(r), abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"geometry": "round"}, "geometry is"),
        ({"ends": (1.0, 0.5)}, "must grow"),
        ({"geometry": "around", "ends": (1.0, 2.0), "pressure_gradient": 1.0}, "around an axis"),
    ],
)
def test_flows_without_a_meaning_are_refused(change, message):
    case = {"ends": (0.0, 1.0), "walls": (COLD, COLD), "viscosity": constant, "conductivity": 1.0}
    with pytest.raises(ValueError, match=message):
        HeatedShear(**(case | change))


@pytest.mark.parametrize("free", [Wall(), Wall(0.0, speed=None)], ids=["insulated", "stress"])
def test_steady_flow_needs_a_held_wall(free):
    with pytest.raises(ValueError, match="needs a wall"):
        HeatedShear((0, 1), (free, free), constant, 1.0).steady()
