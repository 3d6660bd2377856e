"""The implicit step of a parallel flow, once for all fluids and walls, in NumPy: what particles and layers share.

``stages.py`` is the step, ``walls.py`` and ``stress_controlled.py`` are the walls in it, ``wall_pair.py`` both of a
channel and their impulse, ``models.py`` the response of the extra stress of a fluid that is not Newtonian. The
derivatives and linear systems are those of a ``ClosedOperators`` object: of the particles
(``schemes/_channel/operators.py``), or of layers of the start lattice (``schemes/_estimate.py``).
"""
