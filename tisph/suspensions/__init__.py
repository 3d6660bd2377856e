"""Suspensions: many bodies that a config describes together. One file a kind."""
