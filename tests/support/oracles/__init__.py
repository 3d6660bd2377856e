"""Independent solutions of the flows that ``tisph/exact/start_up.py`` solves for every run."""
