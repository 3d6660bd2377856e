"""Every run of the tests draws the same examples: a failure comes with a change, not with luck."""

from hypothesis import settings

settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")
