"""Scheme implicit, for its tests: overrides of the small Couette case, and how to run it."""

import numpy as np

IMPLICIT = ("scheme={type: implicit}", "time.tolerance=1.0e-5")

SLOW = 1e-6
"""Velocities with which nothing moves noticeably: the arrangement is the same whatever the steps."""


def run(scheme):
    """Step to the end; return the last snapshot."""
    while not scheme.finished:
        scheme.advance()
    return scheme.snapshot()


def exact_error(scheme):
    """Run to the end; return the error of the velocities, relative and root mean square."""
    last = run(scheme)
    exact = scheme.channel.exact_velocity(last.y, last.t)
    return np.linalg.norm(last.u - exact) / np.linalg.norm(exact)
