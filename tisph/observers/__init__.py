"""Observers read a run while it goes on. ``protocol.py`` defines their protocol and schedules."""
