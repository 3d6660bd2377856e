"""Particle operators: gradient, divergence and Laplacian as sums over neighbours. One file each."""
