"""Runs of many configs: verification suites and tables."""
