"""Smoothing kernels, as plain arithmetic that Taichi compiles. One file each."""
