"""The discrete Laplacian next to a wall, by wall treatment, as ``tisph verify --walls`` states it."""

import pytest

from tisph.studies.walls import ROUND_OFF, measured

pytestmark = pytest.mark.taichi


@pytest.fixture(scope="module")
def near():
    """Return a function that gives the error next to the walls on the lattice, 12 and 24 across."""

    def errors(treatment, profile):
        lattice, *_ = measured(treatment, profile, (12, 24))
        return [at_wall for at_wall, _ in lattice["errors"].values()]

    return errors


def test_consistent_images_continue_a_parabola_exactly(near):
    assert max(near("consistent_image", "bent")) < ROUND_OFF


def test_plain_mirror_images_are_inconsistent_on_a_bent_profile(near):
    # the image is off by d^2 u_yy, and d is a multiple of the spacing
    coarse, fine = near("comoving_image", "bent")
    assert coarse > 0.1
    assert fine == pytest.approx(coarse, rel=1e-9)


def test_kernel_averages_have_an_error_that_grows(near):
    # the average of a row is off by a multiple of the spacing times the slope, which is not small
    coarse, fine = near("adami", "straight")
    assert fine > 1.5 * coarse
