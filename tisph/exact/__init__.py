"""Exact solutions, without Taichi. One file each."""
