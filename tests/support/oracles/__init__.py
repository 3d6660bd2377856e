"""Closed forms of flows that a run takes from ``tisph/exact/start_up.py``: its independent checks."""
