"""The implicit scheme of parallel flow.

``step.py`` is the step and ``walls.py`` the walls in it; ``stress_controlled.py`` has the walls on which a stress is
given, and ``models.py`` the extra stress of fluids that are not Newtonian. All of these are NumPy: ``scheme.py`` and
``operators.py`` take the step on particles, and ``schemes/_estimate.py`` on layers of the start lattice.
"""
