"""Stability matrix: cells with a promise each, what becomes of them, and the maps that show it."""
