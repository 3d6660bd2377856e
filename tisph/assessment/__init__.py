"""Assessment: the result of any code, judged as tisph judges its own runs."""
