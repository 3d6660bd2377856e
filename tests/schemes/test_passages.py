"""Passages of a snapshot: how often the fluid of each particle has left through an outlet."""

import numpy as np
import pytest
from case_from_text import started

from tisph.runtime import view

pytestmark = pytest.mark.taichi

CHANNEL = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.05}
geometry: {gap: 1.0, length: 1.0}
ends:
  left: {type: inlet, velocity: 1.0}
  right: {type: outlet}
initial: {state: developed}
discretisation: {particles_across: 12}
time: {end: 0.2}
runtime: {threads: 1}
"""


def test_particles_that_jump_to_the_inlet_have_passed_whatever_their_order(tmp_path):
    _, scheme = started(tmp_path, CHANNEL, [])
    before, order = scheme.snapshot(), view(scheme.levels.number)
    while not scheme.finished:
        scheme.advance()
        scheme.levels.reorder(scheme.extra_stress.fields)
        scheme.output_cache = None
        after = scheme.snapshot()
        jumped = after.x - before.x < -0.5
        assert np.array_equal(after.passages - before.passages, jumped)
        before = after
    assert before.passages.sum() > 10
    assert (np.diff(order[: len(before.x)]) < 0).any()  # particles are stored in another order
