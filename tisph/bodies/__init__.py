"""Bodies at rest or moving in the fluid, as in a config. One file a shape."""
