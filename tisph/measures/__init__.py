"""Measures of a state or a series of a run: norms, fits, gradients, wall shear, steadiness, rheometry."""
