"""Suspensions: many bodies that one section of a config describes. One file a kind."""
