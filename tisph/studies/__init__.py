"""Studies: many runs of one program, judged and drawn together."""
