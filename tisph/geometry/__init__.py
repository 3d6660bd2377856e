"""Walls as curves, and the bodies that they bound, without Taichi. One file a shape."""
