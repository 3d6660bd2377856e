"""A flow in other units is the same flow: no length, time or density is written into any part."""

import numpy as np
import pytest

pytestmark = pytest.mark.taichi

LENGTH, TIME, DENSITY = 2.0**-8, 2.0**-4, 2.0**6
"""Powers of four: all that is computed of them is exact, square roots too, so that the bits of a flow stay as they are.

The gap is then 4 mm wide, and spacings, smoothing lengths and steps are small against 1."""

OLDROYD = "fluid.rheology={{type: oldroyd_b, relaxation_time: {0}, solvent_fraction: 0.4}}"


def overrides(length, time, density):
    """Overrides that say the small case, driven, in units so many times as large."""
    return (
        f"fluid={{density: {density}, kinematic_viscosity: {0.01 * length**2 / time}}}",
        f"geometry={{gap: {length}, length: {length}}}",
        f"walls={{bottom: {{velocity: {-0.25 * length / time}}}, top: {{velocity: {0.5 * length / time}}}}}",
        f"drive.acceleration={0.02 * length / time**2}",
        f"time={{end: {0.5 * time}}}",
    )


@pytest.mark.parametrize(
    "choice",
    [
        ("scheme.type=wcsph", "walls.treatment.type=virtual_image", "scheme.artificial_viscosity=0.1"),
        ("scheme.type=wcsph", "walls.treatment.type=comoving_image", "scheme.operators=standard"),
        ("scheme.type=wcsph", "walls.treatment.type=consistent_image", "polymer"),
        ("scheme.type=implicit", "walls.treatment.type=virtual_image", "scheme.operators.order=2"),
        ("scheme.type=implicit", "walls.treatment.type=consistent_image", "polymer"),
    ],
    ids=lambda choice: "-".join(choice),
)
def test_a_flow_in_other_units_is_bitwise_the_same(make, choice):
    ends = []
    for length, time, density in ((1.0, 1.0, 1.0), (LENGTH, TIME, DENSITY)):
        rheology = [OLDROYD.format(0.5 * time)] if "polymer" in choice else []
        chosen = [part for part in choice if "=" in part]
        scheme = make(*overrides(length, time, density), *chosen, *rheology, jitter=0.2)
        for _ in range(8):
            scheme.advance()
        last = scheme.snapshot()
        pressure = density * (length / time) ** 2
        found = [last.t / time, last.x / length, last.y / length, last.u * time / length, last.v * time / length]
        found += [last.density / density, last.pressure / pressure]
        found += [last.stress_xx / pressure, last.stress_xy / pressure] if rheology else []
        ends.append(found)
    assert np.ptp(ends[0][3]) > 0.01
    assert [np.array_equal(one, other) for one, other in zip(*ends, strict=True)] == [True] * len(ends[0])
