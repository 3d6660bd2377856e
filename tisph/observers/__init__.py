"""Observers: what looks at a run while it goes on. One file each; ``protocol.py`` says what one must have."""
