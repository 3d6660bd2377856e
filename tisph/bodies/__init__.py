"""Bodies that stand or move in the liquid, as a config gives them. One file a shape."""
