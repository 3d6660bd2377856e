"""The tables of ``tisph bench throughput``."""

from statistics import median

from tisph.study.bench._throughput_cases import Case
from tisph.study.bench._throughput_results import ratios
from tisph.verification.table import format_table

COSTS = ("operators", "precision", "threads", "particles", "ns per particle-step", "10^6/s", "of C++", "neighbours")
PARTS = ("operators", "precision", "threads", "particles", "binning", "list", "walls", "density + forces")
PARTS += ("integration", "rest", "steps between rebuilds")
IMPLICIT = ("precision", "threads", "particles", "assembly", "lists", "linear systems", "whole step", "neighbours")
MEMORY = ("scheme", "precision", "particles", "bytes a particle", "tisph check", "ratio")
PEERS = ("code", "processes", "particles", "ns per particle-step", "10^6/s", "neighbours", "standard", "consistent")
CHECKS = ("what", "median (smallest..largest)", "bound", "")

NOTES = """Medians (smallest..largest) of the rounds; every case in a process of its own.
density + forces: one pass over the neighbours gives both; timed alone, without writing what follows from them.
integration: the rest of the kernel of a step, with the images of particles at the walls. walls: what a rebuild of the
lists does for them. rest: wall forces for the balance of momentum, launches, Python. Binning, list and walls are
divided by the steps between two rebuilds."""


def show(results, judged, place):
    """Print all tables of ``results``, and the verdicts of the checks ``judged``."""
    explicit = [case for case in results.cases if case.scheme != "implicit"]
    implicit = [case for case in results.cases if case.scheme == "implicit"]
    print(f"\n{place['processor']}, {place['cores']} cores\n{NOTES}")
    _print("Explicit scheme", COSTS, [_cost_row(results, case) for case in explicit])
    _print("Parts of an explicit step [ns per particle-step]", PARTS, [_parts_row(results, case) for case in explicit])
    title = "Implicit scheme of order 4 [ns per particle and assembly, or step]"
    _print(title, IMPLICIT, [_implicit_row(results, case) for case in implicit])
    _print("Memory, by the growth of the process from 5000 particles on", MEMORY, _memory_rows(results))
    _print("Peers, and how many times their throughput ours is (f64)", PEERS, _peer_rows(results))
    rows = [(one.what, spread(one.values), one.bound, "PASS" if one.passed else "FAIL") for one in judged]
    _print("Bounds", CHECKS, rows)


def _print(title, header, rows):
    if rows:
        print(f"\n{title}\n\n{format_table(header, rows)}", flush=True)


def spread(values):
    """Median and range as text, to three digits."""
    if len(values) == 1:
        return _number(values[0])
    return f"{_number(median(values))} ({_number(min(values))}..{_number(max(values))})"


def _number(value):
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _of(case):
    return case.precision, str(case.threads), str(case.particles)


def _neighbours(rounds):
    return f"{median(one['neighbours_mean'] for one in rounds):.1f}"


def _cost_row(results, case):
    cost, reference = results.cost(case), results.reference_cost(case)
    part = f"{median(reference) / median(cost):.2f}" if reference and case.scheme == "standard" else ""
    return (
        case.scheme,
        *_of(case),
        spread(cost),
        f"{1e3 / median(cost):.1f}",
        part,
        _neighbours(results.cases[case]),
    )


def _parts_row(results, case):
    parts = [f"{value:.1f}" for value in results.parts(case).values()]
    return case.scheme, *_of(case), *parts, f"{results.interval(case):.0f}"


def _implicit_row(results, case):
    rounds = results.cases[case]
    values = [spread([one[part] for one in rounds]) for part in ("assembly", "neighbours", "systems", "step")]
    return *_of(case), *values, _neighbours(rounds)


def _memory_rows(results):
    smallest = min(case.across for case in results.cases)
    chosen = [case for case in results.cases if case.threads == 2 and case.across > smallest]
    rows = []
    for case in chosen:
        measured, said = results.memory(case)
        numbers = (f"{measured:.0f}", f"{said:.0f}", f"{measured / said:.2f}")
        rows.append((case.scheme, case.precision, str(case.particles), *numbers))
    return rows


def _peer_rows(results):
    rows = []
    for (label, threads, across), rounds in results.peers.items():
        cost = results.peer_cost(label, threads, across)
        ours = [results.cost(Case(scheme, "f64", threads, across)) for scheme in ("standard", "consistent")]
        times = [spread(ratios(cost, one)) if one else "" for one in ours]
        neighbours = rounds[0]["neighbours"]
        numbers = (str(threads), str(rounds[0]["particles"]), spread(cost), f"{1e3 / median(cost):.2f}")
        rows.append((label, *numbers, "" if neighbours is None else f"{neighbours:g}", *times))
    return rows
