"""Neighbour search: cells by stable counting sort, particles kept in cell order, reusable Verlet lists."""
