"""What scenes of turning liquid in a doubly periodic box look at: centre lines, vorticity, spread of particles."""

import numpy as np

from tisph.scenes._views import Line
from tisph.verification.gradients import velocity_gradients
from tisph.verification.spread import largest_hole, nearest_two


def centre_line(scene, along):
    """The line ``along`` x or y through the middle of the box, with the particles half a spacing around it."""
    axis = "xy".index(along)
    ends = [(low, low + size) for low, size in zip(scene.origin, scene.extent, strict=True)]
    return Line(along, ends[axis], 0.5 * sum(ends[1 - axis]), half_width=0.5 * scene.spacing)


def vorticity(scene):
    """Return a function snapshot -> dv/dx - du/dy (1/time); it keeps the last one, which is asked for twice."""
    seen = [None, None]

    def of(snapshot):
        if seen[0] is not snapshot:
            slopes = velocity_gradients(scene, snapshot, degree=2)
            seen[:] = snapshot, slopes[2] - slopes[1]
        return seen[1]

    return of


def measures(scene, snapshot):
    """Return the mean square of the vorticity, and the numbers of a sample that need no reference.

    ``divergence_over_gradient``: largest |div u| over the largest velocity gradient (Frobenius norm), None at rest;
    ``nearest_two`` and ``largest_hole``, see ``verification/spread.py``; ``density_variation`` = max |density/density_0
    - 1|. Gradients are those of ``verification/gradients.py``, whose own errors are about 1e-4 of the largest at 50
    particles a wave, and fall with the fourth power of the spacing.
    """
    slopes = velocity_gradients(scene, snapshot)
    largest = np.max(np.linalg.norm(slopes, axis=0))
    return np.mean(np.square(slopes[2] - slopes[1])), {
        "divergence_over_gradient": np.max(np.abs(slopes[0] + slopes[3])) / largest if largest else None,
        "nearest_two": nearest_two(scene, snapshot),
        "largest_hole": largest_hole(scene, snapshot),
        "density_variation": np.max(np.abs(snapshot.density / scene.density - 1)),
    }
