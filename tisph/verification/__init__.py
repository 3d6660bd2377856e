"""Error measures and the verification suite."""
