"""The runs of a sweep as processes of this machine."""

from contextlib import closing

from tisph.study.processes import run_side_by_side


def outcomes(cases, store, processes):
    """Yield (name, summary, message) of ``cases`` as they end, ``processes`` at a time."""
    configs = {case.name: case.config for case in cases}

    def launch(name):
        store.wait(name)
        return store.launch(name, configs[name])

    with closing(run_side_by_side(configs, launch, processes)) as ended:
        for name, result, message in ended:
            yield name, result.summary, message
