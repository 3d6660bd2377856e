"""Throughput: what a particle and a step cost, part by part, from 5 thousand to a million particles.

Every case is a process of its own, and so is every run of the C++ loop and of the peers; rounds are interleaved and
results kept in the folder, so that an interrupted benchmark goes on where it was.
"""

import hashlib
import json
import subprocess
import sys
from pathlib import Path

from rich.console import Console

from tisph.errors import TisphError
from tisph.study.bench import _throughput_reference as reference
from tisph.study.bench import machine
from tisph.study.bench._throughput_cases import ROUNDS, cases
from tisph.study.bench._throughput_results import LAMMPS, PYSPH, TUNED, Results, checks
from tisph.study.bench._throughput_table import show
from tisph.study.store import config_text, fingerprint

SECONDS = {False: 1.0, True: 0.3}
"""Seconds of steps in every process, by whether the benchmark is a quick one."""

PEERS = {
    (LAMMPS, 1): ("lammps", {50: 2000, 224: 100}),
    (LAMMPS, 2): ("lammps", {50: 4000, 224: 200}),
    (PYSPH, 2): ("pysph", {50: 200, 224: 20}),
    (TUNED, 2): ("pysph-tuned", {50: 200, 224: 20}),
}
"""Code, and steps by the number of particles across, of a label with so many threads or processes."""


def run(folder, quick=False, peers_folder=None):
    """Measure, print the tables, leave ``throughput.json`` in ``folder``; return whether every bound is kept.

    ``peers_folder``: where the peers' scripts are, None to leave them out.
    """
    (folder / "cases").mkdir(parents=True, exist_ok=True)
    bench = Bench(folder / "cases", SECONDS[quick], reference.compiled(folder))
    if bench.program is None:
        print("the C++ loop is left out: no compiler named c++, or no benchmarks/reference.cpp beside the package")
    wanted = cases(quick)
    for turn in range(1 if quick else ROUNDS):
        for case in wanted:
            if turn < (1 if quick else case.rounds):
                bench.measure(case, turn)
        for peer in PEERS if peers_folder else ():
            bench.measure_peer(peers_folder, peer, turn)
    judged = checks(bench.results)
    place = machine.describe()
    show(bench.results, judged, place)
    _write(folder / "throughput.json", bench.results, judged, place)
    print(f"numbers: {folder / 'throughput.json'}")
    return all(check.passed for check in judged)


class Bench:
    """Measures in processes for ``seconds`` each, and keeps what they say in ``folder``.

    ``program``: the compiled C++ loop, None to leave it out. ``results``: the ``Results`` so far.
    """

    def __init__(self, folder, seconds, program):
        self.folder, self.seconds, self.program = folder, seconds, program
        self.results = Results()
        self._code = code_mark()

    def measure(self, case, turn):
        """Run a case once, and after an explicit scheme with standard operators the C++ loop."""
        config = self.folder / f"{case.name}.yaml"
        config.write_text(config_text(case.name, case.config), encoding="utf-8")
        found = self._call(f"{case.name}_round_{turn}", "_throughput_process", config)
        self.results.cases.setdefault(case, []).append(found)
        if case.scheme == "standard" and self.program:
            found = self._call(f"reference_{case.name}_round_{turn}", "_throughput_reference", config, self.program)
            self.results.references.setdefault((case.precision, case.threads, case.across), []).append(found)

    def _call(self, name, module, config, *words):
        key = [self._code, self.seconds, config.read_text(encoding="utf-8")]
        command = [sys.executable, "-m", f"tisph.study.bench.{module}", config, *words, self.seconds]
        return kept(self.folder / f"{name}.json", key, command)

    def measure_peer(self, scripts, peer, turn):
        """Run a peer once at each size."""
        label, threads = peer
        code, steps_at = PEERS[peer]
        for across, steps in steps_at.items():
            words = ["--code", code, "--threads", threads, "--across", across, "--steps", steps]
            path = self.folder / f"{code}_{threads}_{across}_round_{turn}.json"
            found = kept(path, words, [sys.executable, scripts / "measure.py", *words])
            self.results.peers.setdefault((label, threads, across), []).append(found)


def kept(path, key, command):
    """Return the line of JSON that ``command`` prints, or the one that it printed before under the same ``key``.

    Raises TisphError where it fails.
    """
    if path.is_file():
        old = json.loads(path.read_text(encoding="utf-8"))
        if old["key"] == key:
            return old["found"]
    with Console(stderr=True).status(path.stem):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if done.returncode:
        raise TisphError(f"{path.stem}: {done.stderr.strip()[-500:]}")
    found = json.loads(done.stdout.splitlines()[-1])
    path.write_text(json.dumps({"key": key, "found": found}) + "\n", encoding="utf-8")
    return found


def code_mark():
    """Hash of what is timed and of what times it: results of other code are not used again."""
    digest = hashlib.sha256(fingerprint().encode())
    for path in [*sorted(Path(__file__).parent.glob("_throughput_*.py")), reference.SOURCE]:
        if path.is_file():
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _write(path, results, judged, place):
    numbers = {
        "machine": place,
        "cases": [
            {**vars(case), "ns_per_particle_step": results.cost(case), "rounds": rounds}
            for case, rounds in results.cases.items()
        ],
        "references": _listed(("precision", "threads", "across"), results.references),
        "peers": _listed(("label", "threads", "across"), results.peers),
        "checks": [
            {"what": one.what, "values": one.values, "bound": one.bound, "passed": one.passed} for one in judged
        ],
    }
    path.write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")


def _listed(names, found):
    return [{**dict(zip(names, key, strict=True)), "rounds": rounds} for key, rounds in found.items()]
