"""Whether the particles resolve the flow at a time: the depth of its thinnest layer against their spacing."""

import math

LEAST_DEPTH = 2.0
"""Depth of a layer, in particle spacings, from which on a sample counts as resolved.

The error of the velocities of the layer is then at most 1.5 % (L2) and that of the wall shear 1 %, with both schemes
and every order; with polymer that of the wall shear is 5 %. ``benchmarks/resolution.py`` measures it, docs/results.md
has its table.
"""

STEEPEST = 2.0
"""Change of the logarithm of a conformation tensor within a spacing up to which a sample counts as resolved.

The error of the drag of a confined cylinder is 0.4 % with 1.5 and 1 % with 2.6 (docs/bodies.md), that of flow between
cylinders 1e-3 with 0.5.
"""


def resolution(scene, t, steepest=None):
    """Tell whether the flow of a scene is resolved at time ``t``, and why not: (True, None) or (False, reason).

    ``steepest``: see ``Snapshot``.
    """
    depth, layer = scene.thinnest_layer(t)
    spacings = depth / scene.spacing
    if spacings >= LEAST_DEPTH:
        if steepest is None or steepest[0] <= STEEPEST:
            return True, None
        change, x, y = steepest
        text = f"the polymer's stretch changes {math.exp(change):.2g}-fold within a spacing at ({x:.4g}, {y:.4g})"
        return False, f"{text}; resolved up to {math.exp(STEEPEST):.2g}-fold"
    return False, f"{layer} is {spacings:.2g} spacings thin; resolved from {LEAST_DEPTH:g} spacings on"


def layer_spacings(scene, t):
    """Depth of the thinnest layer at time ``t`` in particle spacings; infinite where there is none."""
    return scene.thinnest_layer(t)[0] / scene.spacing
