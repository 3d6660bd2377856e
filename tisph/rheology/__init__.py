"""Rheologies: the stress of the fluid as a function of its deformation. One file each."""
