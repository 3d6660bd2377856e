"""What `tisph verify` runs, and what each run is held to."""
