"""Scenes: geometry, boundary motion and exact solution of a flow. One file each."""
