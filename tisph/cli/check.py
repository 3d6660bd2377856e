"""``tisph check``: validate a config and print size, steps, errors and cost of its run, without running it."""

from tisph.cli.terminal import ConfigFile, Overrides


def check(config: ConfigFile, overrides: Overrides = None) -> None:
    """Validate a config; print its numbers and cost.

    Nothing is run and nothing is written.

    \b
    Examples:
      tisph check configs/couette.yaml
      tisph check configs/couette.yaml --set discretisation.particles_across=100
    """
    from tisph.config import load
    from tisph.schemes._forecast import described, forecast

    loaded = load(config, overrides or ())
    for line in described(loaded, *forecast(loaded)):
        print(line)
