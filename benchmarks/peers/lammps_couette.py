"""LAMMPS, SPH package, on the case of ``couette_case.py``; prints one line of JSON.

Standard library only: any Python runs it; ``lmp`` and ``mpiexec`` come from env-lammps. The input is
``in.couette.lammps``.
"""

import re
import subprocess
import tempfile
from pathlib import Path

import couette_case as case

HERE = Path(__file__).resolve().parent
PROGRAMS = HERE / "env-lammps" / "bin"

LOOP = re.compile(r"Loop time of (\S+) on (\d+) procs for (\d+) steps")
VERSION = re.compile(r"LAMMPS \((.+)\)")

DUMPS = 3
"""Times in the file of ``--dump``, evenly spaced; the last one is the end."""


def command(arguments, end):
    """Command and its input; y and u of the fluid particles at the end go to the file ``end`` (None: nowhere)."""
    variables = {
        "gap": case.GAP,
        "length": case.LENGTH,
        "density": case.DENSITY,
        "dynamic_viscosity": case.DENSITY * case.KINEMATIC_VISCOSITY,
        "wall_velocity": case.WALL_VELOCITY,
        "sound_speed": case.SOUND_SPEED,
        "spacing": case.spacing(arguments.across),
        "time_step": case.time_step(arguments),
        "steps": arguments.steps,
    }
    words = [PROGRAMS / "mpiexec", "-n", str(arguments.threads), PROGRAMS / "lmp", "-log", "none"]
    for name, value in variables.items():
        words += ["-var", name, repr(value)]
    source = (HERE / "in.couette.lammps").read_text(encoding="utf-8")
    if arguments.dump:
        source = source.replace("\nrun ", f"\n{dump_commands(arguments)}\nrun ")
    if end is not None:
        source += f'write_dump fluid custom "{end}" y vx modify format float %.17g\n'
    return words, source


def dump_commands(arguments):
    """Commands that dump fluid and walls as a user would: all particles with their types, at some times."""
    every = arguments.steps // DUMPS
    dump = f'dump all all custom {every} "{arguments.dump}" id type x y vx vy'
    return f"{dump}\ndump_modify all sort id time yes delay 1 format float %.9g"


def run(arguments, end=None):
    """Output of a run; RuntimeError with the end of it if LAMMPS fails."""
    words, source = command(arguments, end)
    done = subprocess.run(words, input=source, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError("LAMMPS failed:\n" + (done.stdout + done.stderr)[-2000:])
    return done.stdout


def read_dump(path):
    """Pairs (y, u) of the particles in a dump of columns y and vx."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = lines.index("ITEM: ATOMS y vx") + 1
    return [tuple(map(float, line.split())) for line in lines[first:]]


def main():
    """Run, read the loop time from LAMMPS' own output, and report."""
    parser = case.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=2, help="MPI processes")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        end = Path(folder) / "end.dump" if arguments.profile else None
        output = run(arguments, end)
        if arguments.profile:
            case.write_profile(arguments.profile, read_dump(end))
    seconds, processes, steps = LOOP.search(output).groups()
    case.report(
        version=VERSION.search(output).group(1),
        across=arguments.across,
        steps=int(steps),
        loop_seconds=float(seconds),
        threads=int(processes),
    )


if __name__ == "__main__":
    main()
