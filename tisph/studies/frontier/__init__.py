"""Run time against error (``tisph bench frontier``): cases as data, their measurement, peers, tables and picture."""
