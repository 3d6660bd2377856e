"""The implicit step of a parallel flow, once for all fluids and walls, in NumPy: what particles and layers share.

``stages.py`` is the step; ``walls.py``, ``massless_wall.py`` and ``inertial_wall.py`` what walls of each kind prescribe
in it, ``models.py`` how the extra stress of a fluid that is not Newtonian responds, ``impulse.py`` what an impulsively
started wall does. The derivatives and linear systems are those of a ``ClosedOperators`` object: of the particles
(``schemes/implicit/_operators.py``), or of layers of the start lattice (``schemes/_error_estimate``).
"""
