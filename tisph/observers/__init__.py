"""Observers: what is written down while a run goes on. One file each.

An observer has ``due(time)``, ``observe(snapshot)`` and ``close()``. It looks at the run and never changes
it: with or without a movie the particles are the same to the last bit.
"""
