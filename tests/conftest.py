"""Every run of the tests draws the same examples: a failure comes with a change, not with luck."""

import gc

from hypothesis import settings

settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")

gc.set_threshold(200_000, 20, 20)  # as the command line does, and for the same reason
