"""``tisph`` on a disk that is full from a tenth of a run on: no file grows beyond a limit, but for those of Taichi.

``limited_run.py LIMIT TIME run CONFIG --out FOLDER`` leaves a copy of the folder as it was then in ``before``.
"""

import resource
import shutil
import sys

from tisph import cli, runtime
from tisph.observers.samples import Samples

observe, stop = Samples.observe, runtime.stop


def main(limit, time, *arguments):
    """Call the command line with ``arguments``; the first sample after ``time`` finds the disk full."""

    def limited(self, snapshot):
        if snapshot.t > float(time) and resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY:
            shutil.copytree(arguments[-1], "before")
            resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), resource.RLIM_INFINITY))
        observe(self, snapshot)

    def unlimited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        stop()

    Samples.observe, runtime.stop = limited, unlimited
    sys.argv[1:] = arguments
    cli.main()


if __name__ == "__main__":
    main(*sys.argv[1:])
