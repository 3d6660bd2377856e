"""Studies of many runs: sweeps, verification, the stability matrix, comparisons, run time against error."""
