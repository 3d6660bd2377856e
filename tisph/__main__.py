"""``python -m tisph``: the same as the ``tisph`` command."""

from tisph.cli import main

main()
