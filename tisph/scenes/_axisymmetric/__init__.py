"""Axisymmetric flow: x along the axis, y the distance from it, w around it."""
