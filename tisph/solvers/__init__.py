"""Linear solvers: BiCGStab with a choice of preconditioner, and the auxiliary grids of the two-level one."""
