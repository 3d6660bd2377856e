"""Linear solvers: BiCGStab with its preconditioners, and the auxiliary grids of the two-level one."""
