"""Rheologies: the stress of the liquid as a function of its deformation. One file each."""
