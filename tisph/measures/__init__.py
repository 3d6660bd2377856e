"""What measures a state or a series of a run: norms, fits, gradients, wall shear, steadiness, rheometry."""
