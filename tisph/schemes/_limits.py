"""Where the stability matrix (``tisph stress``) found the end of what is known of a scheme, in plain numbers."""

MIXED = 125.0
"""Cell Reynolds number U spacing/nu above which rows that slide past each other in the layer at a wall that started mix
the liquid of the explicit scheme: the error is no longer that of rows then. In the stability matrix it is at 125 (8
across, Re = 1000), and many times as large at 200 and 400."""

RESOLVED = 60.0
"""The same up to which disordered runs of the stability matrix vary little in density, and above which they mix."""

LOST = 4.0
"""Cell Reynolds number over ``RESOLVED``, over the depth of the layer at a wall in spacings, from which on the profile
is lost: half of it, where the error of rows is multiplied by the square of the former."""

STIFFEST = 3.0
"""Steps over the default, from which on disorder grows in them: some runs of the stability matrix are stopped then."""

DISORDERED_OF_ORDER_2 = 1.0
"""Cell Reynolds number above which disordered runs of order 2 of the implicit scheme err as they will, or stop."""

DISORDERED_SOLVENT = 10.0
"""Cell Reynolds number by the viscosity of the solvent, where there is polymer, up to which disordered runs are stable:
one failed at 20, and above it they take more steps and err more than rows do, or stop."""

STIFF = 4.0
"""Modulus of the polymer over density times (spacing over solvent viscosity) squared, up to which disordered particles
of the implicit scheme err as a lattice does where a wall jumps: at 3.5 they did, at 14 they erred eight times more."""
