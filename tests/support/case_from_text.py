"""Scenes and schemes of configs that stand in a test file, for tests of flows that have no case of their own."""

from tisph import config, runtime, scenes, schemes
from tisph.simulation.state import start_values


def read(folder, text, changes):
    """Return settings and scene of the config ``text`` with ``changes``; Taichi starts, on one thread."""
    path = folder / "case.yaml"
    path.write_text(text)
    settings, _ = schemes.resolve(config.load(path, changes))
    runtime.start("f64", 1)
    return settings, scenes.of(settings)


def to_end(scheme):
    """Step a scheme to its end; return the last snapshot."""
    while not scheme.finished:
        scheme.advance()
    return scheme.snapshot()


def started(folder, text, changes, targets=None, begin=True):
    """Return scene and scheme at the start of the run that ``read`` reads.

    The scheme ends on ``targets``, or on the end of the run. With ``begin=False`` there are no particles in it yet.
    """
    settings, scene = read(folder, text, changes)
    scheme = schemes.build(settings, scene, targets or [settings.time.end], serial=True)
    if begin:
        scheme.start(*start_values(scene, settings.initial))
    return scene, scheme
