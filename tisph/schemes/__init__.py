"""Schemes: how the particles are advanced in time. One file each."""
