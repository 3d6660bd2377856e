"""Bodies that stand or move in the fluid, as a config gives them. One file a shape."""
