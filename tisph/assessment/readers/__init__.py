"""Readers, one file a format: ``SUFFIXES`` and ``read(path, select)``, which returns the frames of a file.

``select`` names the group of particles to read, where a format has groups; None leaves the choice to the reader.
"""
