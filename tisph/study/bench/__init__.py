"""Benchmarks: run time against error, throughput, what parts cost, start-up. Ratios within one call on one machine."""
