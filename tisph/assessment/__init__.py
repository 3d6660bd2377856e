"""Assessment: what the result of any code is worth, judged as tisph judges its own runs."""
