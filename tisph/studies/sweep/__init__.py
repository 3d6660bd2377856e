"""Sweeps: one config with some of its keys varied, run on all processors or on many machines, as one table."""
